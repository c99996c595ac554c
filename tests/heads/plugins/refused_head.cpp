// Heads that must be refused: ARBOX_REFUSED_NAME and one macro say which and why.
#include <memory>

#include "arbox/base/plugin.h"
#include "arbox/heads/head_kind.h"

namespace {

struct NoOptions {
  template <class Visitor>
  static void describe(Visitor&) {}
};

[[maybe_unused]] void add(arbox::Registrar& registrar, const char* name) {
  registrar.add<arbox::heads::HeadKind, NoOptions>(
      name, "Never made", [](const NoOptions&, const arbox::heads::HeadContext&) {
        return std::shared_ptr<arbox::heads::BoxHead>();
      });
}

[[maybe_unused]] void register_own(arbox::Registrar& registrar) {
  add(registrar, ARBOX_REFUSED_NAME);
}

[[maybe_unused]] void register_taken(arbox::Registrar& registrar) {
  add(registrar, ARBOX_REFUSED_NAME);
  add(registrar, "gaussian");
}

}  // namespace

#if defined(ARBOX_REFUSED_ABI)
extern "C" const ArboxPluginInfo* arbox_plugin_info() {
  static const ArboxPluginInfo info = {sizeof(ArboxPluginInfo),
                                       arbox::kPluginAbi + 1,
                                       "head",
                                       ARBOX_REFUSED_NAME,
                                       "1.0.0",
                                       "MIT",
                                       arbox::build_fingerprint(TORCH_VERSION)};
  return &info;
}
extern "C" void arbox_plugin_register(arbox::Registrar& registrar) { register_own(registrar); }
#elif defined(ARBOX_REFUSED_LIBTORCH)
ARBOX_PLUGIN_WITH_BUILD("head", ARBOX_REFUSED_NAME, "1.0.0", "MIT", register_own,
                        arbox::build_fingerprint("9.8.7"))
#elif defined(ARBOX_REFUSED_SYMBOL)
extern "C" const ArboxPluginInfo* arbox_plugin_info() { return nullptr; }
#elif defined(ARBOX_REFUSED_TAKEN)
ARBOX_PLUGIN("head", ARBOX_REFUSED_NAME, "1.0.0", "MIT", register_taken)
#endif
