#include "arbox/base/lazy_library.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "arbox/base/error.h"
#include "arbox/base/plugin.h"
#include "support/program.h"
#include "support/refusal.h"

namespace {

using arbox::find_function;
using arbox::is_installed;
using arbox::LazyLibrary;
using arbox::NotAvailable;
using arbox::testing::refusal;
using arbox::testing::TemporaryDirectory;
using ::testing::AllOf;
using ::testing::HasSubstr;

// A path from the root stands for itself, wherever the installation is.
const std::string kPolite = ARBOX_FIXTURE_FOLDER "/libarbox_greeter_polite.so";
constexpr const char* kFunction = "arbox_plugin_info";

LazyLibrary gadgets(const std::string& file) {
  return {.file = file, .content = "gadgets", .mend = "install the package gadgets"};
}

std::string refusal_of(const std::string& file, const char* function) {
  return refusal<NotAvailable>(
      [&] { find_function<const ArboxPluginInfo*()>(gadgets(file), function); });
}

TEST(LazyLibrary, GivesTheSameFunctionEachTime) {
  const LazyLibrary library = gadgets(kPolite);
  EXPECT_TRUE(is_installed(library));
  auto* const info = find_function<const ArboxPluginInfo*()>(library, kFunction);
  EXPECT_STREQ(info()->name, "polite");
  EXPECT_EQ(find_function<const ArboxPluginInfo*()>(library, kFunction), info);
}

TEST(LazyLibrary, SaysWhatIsMissingAndTheMend) {
  EXPECT_FALSE(is_installed(gadgets("libarbox_gadgets.so")));
  EXPECT_THAT(refusal_of("libarbox_gadgets.so", kFunction),
              AllOf(HasSubstr("this installation of Arbox has no gadgets: "),
                    HasSubstr("/arbox/libarbox_gadgets.so is missing"),
                    HasSubstr("install the package gadgets")));
}

TEST(LazyLibrary, SaysWhichFileCannotBeLoaded) {
  const TemporaryDirectory folder;
  const std::string broken = folder.write("libarbox_gadgets.so", "no library").string();
  EXPECT_TRUE(is_installed(gadgets(broken)));
  EXPECT_THAT(refusal_of(broken, kFunction), HasSubstr(broken + ": cannot be loaded: "));
  EXPECT_THAT(refusal_of(kPolite, "no_such_function"),
              AllOf(HasSubstr(kPolite), HasSubstr("no_such_function")));
}

}  // namespace
