// One source for all fixture plugins: ARBOX_FIXTURE_NAME says which one it is.
#include "base/plugins/greeter.h"

#include <stdexcept>

namespace {

using arbox::testing::add_greeter;

[[maybe_unused]] void register_good(arbox::Registrar& registrar) {
  add_greeter(registrar, ARBOX_FIXTURE_NAME);
}

[[maybe_unused]] void register_and_throw(arbox::Registrar& registrar) {
  add_greeter(registrar, ARBOX_FIXTURE_NAME);
  throw std::runtime_error("no licence for today");
}

[[maybe_unused]] void register_twice(arbox::Registrar& registrar) {
  add_greeter(registrar, ARBOX_FIXTURE_NAME);
  add_greeter(registrar, ARBOX_FIXTURE_NAME);
}

[[maybe_unused]] void register_other_name(arbox::Registrar& registrar) {
  add_greeter(registrar, "somebody_else");
}

[[maybe_unused]] void register_taken_name(arbox::Registrar& registrar) {
  add_greeter(registrar, ARBOX_FIXTURE_NAME);
  add_greeter(registrar, "polite");
}

[[maybe_unused]] void register_other_kind(arbox::Registrar& registrar) {
  registrar.add<arbox::testing::CounterKind, arbox::testing::GreeterOptions>(
      ARBOX_FIXTURE_NAME, "Counts",
      [](const arbox::testing::GreeterOptions&) { return std::make_unique<int>(0); });
}

struct GreeterKindOfAnotherVersion {
  static constexpr std::string_view kName = "greeter";
  using Factory = std::unique_ptr<int>(const arbox::OptionsInstance& options);
};

[[maybe_unused]] void register_other_signature(arbox::Registrar& registrar) {
  registrar.add<GreeterKindOfAnotherVersion, arbox::testing::GreeterOptions>(
      ARBOX_FIXTURE_NAME, "Greets in the old way",
      [](const arbox::testing::GreeterOptions&) { return std::make_unique<int>(0); });
}

}  // namespace

#if defined(ARBOX_FIXTURE_WRONG_ABI)
extern "C" const ArboxPluginInfo* arbox_plugin_info() {
  static const ArboxPluginInfo info = {8, 99, nullptr, nullptr, nullptr, nullptr, {}};
  return &info;
}
extern "C" void arbox_plugin_register(arbox::Registrar& registrar) { register_good(registrar); }
#elif defined(ARBOX_FIXTURE_WRONG_BUILD)
ARBOX_PLUGIN_WITH_BUILD("greeter", ARBOX_FIXTURE_NAME, "1.0.0", "MIT", register_good,
                        arbox::build_fingerprint("2.9.9", "gcc 3", "libc++", 199711, 128,
                                                 1 - ARBOX_NDEBUG))
#elif defined(ARBOX_FIXTURE_NO_REGISTER)
extern "C" const ArboxPluginInfo* arbox_plugin_info() { return nullptr; }
#else
ARBOX_PLUGIN(ARBOX_FIXTURE_KIND, ARBOX_FIXTURE_NAME, "1.2.3", "Apache-2.0", ARBOX_FIXTURE_REGISTER)
#endif
