#pragma once

#include <string>

#include "arbox/base/error.h"

namespace arbox::testing {

/// The message of the `Expected` that `call` throws, or "no error".
template <class Expected = InvalidArgument, class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const Expected& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace arbox::testing
