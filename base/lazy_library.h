#pragma once

#include <string_view>

/// \file
/// Parts of an installation in libraries that are opened when they are first needed: what these are
/// linked with (LibTorch, VTK) takes longer to load than most commands run.

namespace arbox {

struct LazyLibrary {
  /// Its file, beside the folder of the installation's plugins: "libarbox_program_torch.so".
  std::string_view file;
  /// What an installation without it lacks: "networks".
  std::string_view content;
  /// What to do then: "install the component 'program_torch'".
  std::string_view mend;
};

/// Whether this installation has it. Does not open it.
bool is_installed(const LazyLibrary& library);

/// The address of a function that the library exports under this name, with C linkage. Opens the
/// library (RTLD_NOW | RTLD_LOCAL) and never closes it. Throws NotAvailable, with the mend, if the
/// installation lacks it, and if it cannot be loaded or has no such function.
void* find_symbol(const LazyLibrary& library, const char* name);

/// find_symbol as a function. Its type is not checked: the library must be of the same build.
template <class Function>
Function* find_function(const LazyLibrary& library, const char* name) {
  return reinterpret_cast<Function*>(find_symbol(library, name));
}

}  // namespace arbox
