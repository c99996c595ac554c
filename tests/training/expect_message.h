#pragma once

#include <gtest/gtest.h>

#include <string>

/// Expects that `call` throws an Error whose message has `part` in it.
template <class Error, class Call>
void expect_message(const Call& call, const std::string& part) {
  try {
    call();
    ADD_FAILURE() << "expected an error with '" << part << "'";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}
