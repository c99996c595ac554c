#pragma once

#include <matio.h>

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

/// \file
/// What the readers of MAT-files share; includes libmatio.

namespace arbox::io::internal {

struct CloseMat {
  void operator()(mat_t* file) const { Mat_Close(file); }
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using MatFile = std::unique_ptr<mat_t, CloseMat>;
using MatVariable = std::unique_ptr<matvar_t, CloseMat>;

/// libmatio's log and its HDF5 are not for several threads at once.
std::mutex& mat_mutex();

/// Throws FormatError unless it is a MATLAB 5 file.
MatFile open_mat(const std::filesystem::path& path);

/// The variable's description without its data. Throws FormatError if it is not there.
MatVariable read_variable(mat_t* file, const std::filesystem::path& path, const std::string& name);

}  // namespace arbox::io::internal
