#include "arbox/detectors/pv_rcnn/internal/name_groups.h"

#include <algorithm>
#include <string_view>

namespace arbox::detectors::pv_rcnn::internal {
namespace {

std::ptrdiff_t count_of(const std::vector<std::string>& names, std::string_view prefix) {
  const auto begin = std::lower_bound(names.begin(), names.end(), prefix);
  return std::partition_point(begin, names.end(),
                              [&](const std::string& name) { return name.starts_with(prefix); }) -
         begin;
}

/// The shortest prefix of whole parts of which all names are chosen; empty if there is none.
std::string_view whole_prefix(const std::string& name, const std::vector<std::string>& chosen,
                              const std::vector<std::string>& all) {
  for (std::size_t dot = name.find('.'); dot != std::string::npos; dot = name.find('.', dot + 1)) {
    const std::string_view prefix = std::string_view(name).substr(0, dot + 1);
    const auto count = count_of(all, prefix);
    if (count > 1 && count_of(chosen, prefix) == count) return prefix;
  }
  return {};
}

}  // namespace

std::vector<std::string> grouped_names(const std::vector<std::string>& chosen,
                                       const std::vector<std::string>& all) {
  std::vector<std::string> result;
  std::string_view last;
  for (const std::string& name : chosen) {
    if (!last.empty() && name.starts_with(last)) continue;
    last = whole_prefix(name, chosen, all);
    result.push_back(last.empty()
                         ? name
                         : std::string(last) + "* (" + std::to_string(count_of(all, last)) + ")");
  }
  return result;
}

}  // namespace arbox::detectors::pv_rcnn::internal
