#pragma once

#include <ATen/core/ivalue.h>

#include <utility>

#include "arbox/sparse/coordinate_manager.h"

namespace arbox::sparse::internal {

/// A connection as the autograd graph can keep it between forward and backward.
struct ConnectionHolder : torch::CustomClassHolder {
  explicit ConnectionHolder(Connection held) : connection(std::move(held)) {}
  Connection connection;
};

inline c10::IValue hold(const Connection& connection) {
  return c10::IValue::make_capsule(c10::make_intrusive<ConnectionHolder>(connection));
}

inline Connection held(const c10::IValue& value) {
  return static_cast<const ConnectionHolder&>(*value.toCapsule()).connection;
}

}  // namespace arbox::sparse::internal
