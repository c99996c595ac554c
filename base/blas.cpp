#include "arbox/base/blas.h"

#include <dlfcn.h>

#include <cstdlib>
#include <memory>

#include "arbox/base/cpu.h"

namespace arbox {
namespace {

constexpr const char* kChoice = "OPENBLAS_CORETYPE";

struct CloseLibrary {
  void operator()(void* library) const { ::dlclose(library); }
};
using Library = std::unique_ptr<void, CloseLibrary>;

// Only one that the process has loaded already, whoever sees its names.
Library loaded_openblas() { return Library(::dlopen("libopenblas.so.0", RTLD_LAZY | RTLD_NOLOAD)); }

template <typename Function>
Function* find(const Library& library, const char* name) {
  return reinterpret_cast<Function*>(::dlsym(library.get(), name));
}

std::string kernels_of(const Library& openblas) {
  if (!openblas) return "";
  auto* const name = find<char*()>(openblas, "openblas_get_corename");
  return name != nullptr ? name() : "";
}

const char* kernels_for(SimdLevel level) {
  if (level == SimdLevel::kAvx512) return "SkylakeX";
  return level == SimdLevel::kAvx2 ? "Haswell" : nullptr;
}

}  // namespace

std::string blas_kernels() { return kernels_of(loaded_openblas()); }

bool mend_blas_kernels() {
  const Library openblas = loaded_openblas();
  if (kernels_of(openblas) != "Prescott" || std::getenv(kChoice) != nullptr) return false;
  auto* const forget = find<void()>(openblas, "gotoblas_dynamic_quit");
  auto* const choose = find<void()>(openblas, "gotoblas_dynamic_init");
  const char* const kernels = kernels_for(best_simd_level());
  if (forget == nullptr || choose == nullptr || kernels == nullptr) return false;
  ::setenv(kChoice, kernels, 1);
  forget();
  choose();
  ::unsetenv(kChoice);
  return kernels_of(openblas) != "Prescott";
}

}  // namespace arbox
