#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/program.h"

namespace {

using arbox::testing::expect_one_line_error;
using arbox::testing::run_arbox;
using arbox::testing::TemporaryDirectory;
using ::testing::HasSubstr;

TEST(Config, RefusesAnUnknownName) {
  expect_one_line_error(run_arbox({"config", "show", "no_such_options"}), 2,
                        {"unknown options 'no_such_options'", "arbox config show --help"});
}

}  // namespace
