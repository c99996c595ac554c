#pragma once

#include <stdexcept>
#include <string>

namespace arbox {

/// Root of every exception that Arbox throws on purpose.
///
/// The text names where it happened (function, file, line, record), what was expected, what came,
/// and the mend where one is known. It is one line without a final full stop or line break.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  ~Error() override;
};

/// A caller's argument is out of its documented domain.
class InvalidArgument : public Error {
 public:
  using Error::Error;
  ~InvalidArgument() override;
};

/// A configuration (YAML, command line, options struct) holds unknown keys or values out of range.
class ConfigError : public Error {
 public:
  using Error::Error;
  ~ConfigError() override;
};

/// The operating system refused: a file is missing, unreadable, unwritable.
class IoError : public Error {
 public:
  using Error::Error;
  ~IoError() override;
};

/// A file's content is not what its format asks for: truncated, wrong counts, non-numbers.
class FormatError : public Error {
 public:
  using Error::Error;
  ~FormatError() override;
};

/// A plugin could not be loaded or does not fit this build.
class PluginError : public Error {
 public:
  using Error::Error;
  ~PluginError() override;
};

/// A computation met numbers that it cannot go on with (non-finite features, singular systems).
class NumericalError : public Error {
 public:
  using Error::Error;
  ~NumericalError() override;
};

/// What was asked for is not part of this build or this machine.
class NotAvailable : public Error {
 public:
  using Error::Error;
  ~NotAvailable() override;
};

}  // namespace arbox
