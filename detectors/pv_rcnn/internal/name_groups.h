#pragma once

#include <string>
#include <vector>

namespace arbox::detectors::pv_rcnn::internal {

/// Names with dots, shortened: where `chosen` has all names of `all` that begin with "a.b.", and
/// there are several, "a.b.* (4)" stands for them. Both sorted.
std::vector<std::string> grouped_names(const std::vector<std::string>& chosen,
                                       const std::vector<std::string>& all);

}  // namespace arbox::detectors::pv_rcnn::internal
