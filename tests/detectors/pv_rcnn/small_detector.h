#pragma once

#include <ATen/Context.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arbox/detectors/pv_rcnn/pv_rcnn.h"
#include "detectors/pv_rcnn/small_network.h"

namespace arbox::detectors::pv_rcnn {

/// The same small network with random weights every time; `more` changes it.
inline std::shared_ptr<Network> made_network(const std::vector<std::string>& more = {}) {
  std::vector<std::string> changes = small_autoregressive();
  changes.insert(changes.end(), more.begin(), more.end());
  at::manual_seed(5);
  auto network = std::make_shared<Network>(small_options(true, changes));
  unsettle(*network);
  return network;
}

inline PvRcnn made_detector(const std::vector<std::string>& more = {},
                            std::optional<evaluation::ConfidenceCalibration> calibration = {}) {
  return PvRcnn(made_network(more), std::move(calibration));
}

}  // namespace arbox::detectors::pv_rcnn
