#include "arbox/base/error.h"

namespace arbox {

// Out of line, so that one copy of each type exists and plugins can be caught across libraries.
Error::~Error() = default;
InvalidArgument::~InvalidArgument() = default;
ConfigError::~ConfigError() = default;
IoError::~IoError() = default;
FormatError::~FormatError() = default;
PluginError::~PluginError() = default;
NumericalError::~NumericalError() = default;
NotAvailable::~NotAvailable() = default;

}  // namespace arbox
