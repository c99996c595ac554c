#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "arbox/base/error.h"

/// \file
/// Bad input must be refused by an arbox::Error in one line that tells all of the given parts.

namespace arbox::testing {

template <class Action>
void expect_refusal(const Action& action, const std::vector<std::string>& parts) {
  try {
    action();
  } catch (const arbox::Error& error) {
    const std::string text = error.what();
    for (const std::string& part : parts) EXPECT_THAT(text, ::testing::HasSubstr(part));
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return;
  }
  ADD_FAILURE() << "nothing was refused; expected an error with '" << parts.front() << "'";
}

}  // namespace arbox::testing
