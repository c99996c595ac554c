#pragma once

#include <vector>

#include "arbox/detectors/pv_rcnn/options.h"
#include "arbox/sparse/set_abstraction.h"

namespace arbox::detectors::pv_rcnn::internal {

inline std::vector<sparse::AbstractionScale> scales(const AbstractionOptions& options) {
  std::vector<sparse::AbstractionScale> result;
  for (std::size_t i = 0; i < options.radii.size(); ++i) {
    result.push_back({static_cast<float>(options.radii[i]),
                      static_cast<std::int32_t>(options.samples[i]), options.widths});
  }
  return result;
}

}  // namespace arbox::detectors::pv_rcnn::internal
