#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstdlib>
#include <filesystem>

#include "arbox/base/error.h"
#include "arbox/base/plugin_loader.h"
#include "base/plugins/greeter.h"
#include "support/program.h"

namespace arbox::testing {
std::size_t align_without_eigen();
}

namespace {

namespace fs = std::filesystem;
using arbox::load_plugin;
using arbox::PluginError;
using arbox::Registrar;
using arbox::Registry;
using arbox::testing::add_greeter;
using arbox::testing::CounterKind;
using arbox::testing::GreeterKind;
using arbox::testing::TemporaryDirectory;
using ::testing::AllOf;
using ::testing::HasSubstr;

const fs::path kFolder = ARBOX_FIXTURE_FOLDER;

fs::path fixture(const std::string& name) { return kFolder / ("libarbox_" + name + ".so"); }

Registry make_registry() {
  Registry registry;
  registry.declare<GreeterKind>();
  registry.declare<CounterKind>();
  return registry;
}

template <class Exception = PluginError, class Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const Exception& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing thrown";
  return "";
}

// A refused plugin must leave nothing behind.
std::string refusal(const fs::path& file) {
  Registry registry = make_registry();
  const std::string error = error_of([&] { load_plugin(file, registry); });
  EXPECT_TRUE(registry.entries().empty());
  EXPECT_THAT(error, HasSubstr(file.filename().string()));
  return error;
}

class PluginPath : public ::testing::Test {
 protected:
  void TearDown() override { ::unsetenv("ARBOX_PLUGIN_PATH"); }
  static void set_path(const std::string& path) { ::setenv("ARBOX_PLUGIN_PATH", path.c_str(), 1); }
};

TEST(Registry, CreatesWhatWasRegisteredWithItsOptions) {
  Registry registry = make_registry();
  registry.add_built_in([](Registrar& registrar) { add_greeter(registrar, "plain"); });
  const auto options = registry.find("greeter", "plain").options();
  assign_overrides(options.fields, {"word=Hi"});
  EXPECT_EQ(registry.create<GreeterKind>("plain", options, 2)->greet("Ann"), "Hi Hi Ann");
  EXPECT_EQ(registry.find("greeter", "plain").origin, "built in");
}

TEST(Registry, UnknownNameListsTheKnownAndTheNearest) {
  Registry registry = make_registry();
  registry.add_built_in([](Registrar& registrar) {
    add_greeter(registrar, "plain");
    add_greeter(registrar, "formal");
  });
  EXPECT_EQ(error_of<arbox::InvalidArgument>([&] { registry.find("greeter", "plane"); }),
            "unknown greeter 'plane', nearest is 'plain'; known: formal, plain");
}

TEST(Registry, RefusesOptionsOfAnotherStruct) {
  Registry registry = make_registry();
  registry.add_built_in([](Registrar& registrar) { add_greeter(registrar, "plain"); });
  EXPECT_THAT(error_of<arbox::InvalidArgument>(
                  [&] { registry.create<GreeterKind>("plain", arbox::OptionsInstance(), 1); }),
              HasSubstr("another struct"));
}

TEST(Registry, KeepsNothingOfARegistrationThatThrows) {
  Registry registry = make_registry();
  EXPECT_THROW(registry.add_built_in([](Registrar& registrar) {
    add_greeter(registrar, "plain");
    throw std::runtime_error("stop");
  }),
               std::runtime_error);
  EXPECT_TRUE(registry.entries().empty());
}

TEST(Registry, RefusesAnUndeclaredKind) {
  Registry registry;
  EXPECT_EQ(error_of([&] {
              registry.add_built_in([](Registrar& registrar) { add_greeter(registrar, "a"); });
            }),
            "unknown plugin kind 'greeter'; none is known");
}

TEST(Fingerprint, KnowsEigensAlignmentWithoutItsHeaders) {
  EXPECT_EQ(arbox::testing::align_without_eigen(), std::size_t{EIGEN_MAX_ALIGN_BYTES});
}

TEST(LoadPlugin, MakesAGoodPluginUsable) {
  Registry registry = make_registry();
  const auto plugin = load_plugin(fixture("greeter_polite"), registry);
  EXPECT_EQ(plugin.kind, "greeter");
  EXPECT_EQ(plugin.name, "polite");
  EXPECT_EQ(plugin.version, "1.2.3");
  EXPECT_EQ(plugin.licence, "Apache-2.0");
  const auto& entry = registry.find("greeter", "polite");
  EXPECT_EQ(entry.origin, fixture("greeter_polite"));
  const auto greeter = registry.create<GreeterKind>("polite", entry.options(), 1);
  EXPECT_EQ(greeter->greet("Ann"), "Hello Ann");
}

TEST(LoadPlugin, LoadsTheSameFileOnce) {
  Registry registry = make_registry();
  load_plugin(fixture("greeter_polite"), registry);
  load_plugin(kFolder / "." / "libarbox_greeter_polite.so", registry);
  EXPECT_EQ(registry.entries().size(), 1U);
}

TEST(LoadPlugin, RefusesAnotherAbiBeforeReadingTheRest) {
  EXPECT_THAT(refusal(fixture("greeter_wrong_abi")),
              AllOf(HasSubstr("plugin ABI: the plugin has 99, Arbox has 1"),
                    HasSubstr("size of ArboxPluginInfo: the plugin has 8, Arbox has ")));
}

TEST(LoadPlugin, RefusesAnotherBuildWithBothValuesOfEveryDifference) {
  EXPECT_THAT(refusal(fixture("greeter_wrong_build")),
              AllOf(HasSubstr("compiler: the plugin has 'gcc 3', Arbox has '"),
                    HasSubstr("standard library: the plugin has 'libc++', Arbox has 'libstdc++"),
                    HasSubstr("C++ standard: the plugin has 199711, Arbox has 2"),
                    HasSubstr("LibTorch: the plugin has '2.9.9', Arbox has ''"),
                    HasSubstr("EIGEN_MAX_ALIGN_BYTES: the plugin has 128, Arbox has "),
                    HasSubstr("NDEBUG (CMAKE_BUILD_TYPE=Release sets it): the plugin has ")));
}

TEST(LoadPlugin, RefusesAPluginOfAKindThatNeedsLibTorchWithoutIt) {
  Registry registry;
  registry.declare<GreeterKind>("1.13.1");
  EXPECT_THAT(error_of([&] { load_plugin(fixture("greeter_polite"), registry); }),
              HasSubstr("LibTorch: the plugin has '', Arbox has '1.13.1'"));
}

TEST(LoadPlugin, RefusesALibraryWithoutTheFunctions) {
  EXPECT_THAT(refusal(fixture("greeter_no_register")),
              HasSubstr("has no function 'arbox_plugin_register'"));
}

TEST(LoadPlugin, TellsWhatRegistrationThrew) {
  EXPECT_THAT(refusal(fixture("greeter_throws")),
              HasSubstr("failed to register: no licence for today"));
}

TEST(LoadPlugin, RefusesWhatRegistersOtherThanItSays) {
  EXPECT_THAT(refusal(fixture("greeter_other_name")),
              HasSubstr("does not register the greeter 'other_name'"));
  EXPECT_THAT(refusal(fixture("greeter_other_kind")),
              HasSubstr("adds the counter 'other_kind', expected entries of its kind 'greeter'"));
  EXPECT_THAT(refusal(fixture("greeter_other_signature")), HasSubstr("with a factory of type"));
  EXPECT_THAT(refusal(fixture("greeter_twice")), HasSubstr("is registered twice"));
}

TEST(LoadPlugin, RefusesAnUnknownKind) {
  EXPECT_THAT(refusal(fixture("stranger_unknown_kind")),
              HasSubstr("unknown plugin kind 'stranger'; known: greeter, counter"));
}

TEST(LoadPlugin, DuplicateNamesBothFiles) {
  Registry registry = make_registry();
  load_plugin(fixture("greeter_polite"), registry);
  EXPECT_EQ(error_of([&] { load_plugin(fixture("greeter_taken"), registry); }),
            "the greeter 'polite' is registered twice: by " + fixture("greeter_polite").string() +
                " and by " + fixture("greeter_taken").string());
  EXPECT_EQ(registry.entries().size(), 1U);
}

TEST(LoadPlugin, RefusesFilesThatAreNoPlugins) {
  const TemporaryDirectory folder;
  EXPECT_THAT(refusal(folder.write("libarbox_greeter_text.so", "just words")),
              HasSubstr("cannot be loaded"));
  EXPECT_THAT(refusal(folder.write("libarbox_greeter_empty.so", "")),
              HasSubstr("cannot be loaded"));
  EXPECT_THAT(refusal(folder / "libarbox_greeter_missing.so"), HasSubstr("no such file"));
  EXPECT_THAT(refusal(folder.path()), HasSubstr("no such file"));
}

TEST(LoadPlugin, RefusesAFileNameThatIsNotItsOwn) {
  const TemporaryDirectory folder;
  fs::copy_file(fixture("greeter_polite"), folder / "libarbox_greeter_rude.so");
  EXPECT_THAT(refusal(folder / "libarbox_greeter_rude.so"),
              HasSubstr("expected the file name libarbox_greeter_polite.so"));
}

TEST_F(PluginPath, FindsANameInTheFoldersOfTheVariable) {
  set_path("/nonexistent:" + kFolder.string());
  Registry registry = make_registry();
  require_plugin("greeter", "polite", registry);
  EXPECT_TRUE(registry.contains("greeter", "polite"));
  require_plugin("greeter", "polite", registry);
  EXPECT_EQ(registry.entries().size(), 1U);
}

TEST_F(PluginPath, UnknownNameListsWhatIsRegisteredAndWhatIsFound) {
  set_path(kFolder.string());
  Registry registry = make_registry();
  registry.add_built_in([](Registrar& registrar) { add_greeter(registrar, "plain"); });
  EXPECT_THAT(error_of([&] { require_plugin("greeter", "polit", registry); }),
              AllOf(HasSubstr("unknown greeter 'polit', nearest is 'polite'"), HasSubstr("plain"),
                    HasSubstr("throws")));
}

TEST_F(PluginPath, NeverSearchesTheWorkingDirectory) {
  const fs::path before = fs::current_path();
  fs::current_path(kFolder);
  Registry registry = make_registry();
  EXPECT_THROW(require_plugin("greeter", "polite", registry), PluginError);
  for (const char* path : {".", ":", "/usr/lib::/tmp", "fixture_plugins"}) {
    set_path(path);
    EXPECT_THROW(arbox::plugin_folders(), arbox::ConfigError) << path;
  }
  fs::current_path(before);
}

TEST_F(PluginPath, ComesBeforeTheInstallation) {
  set_path("/b:/a");
  const auto folders = arbox::plugin_folders();
  ASSERT_EQ(folders.size(), 3U);
  EXPECT_EQ(folders[0], "/b");
  EXPECT_EQ(folders[1], "/a");
  EXPECT_TRUE(folders[2].is_absolute());
  EXPECT_EQ(folders[2].filename(), "plugins");
}

}  // namespace
