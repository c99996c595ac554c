#pragma once

#include <matio.h>

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

/// \file
/// What the readers and writers of MAT-files share; includes libmatio.

namespace arbox::io::internal {

struct CloseMat {
  void operator()(mat_t* file) const { Mat_Close(file); }
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using MatVariable = std::unique_ptr<matvar_t, CloseMat>;

/// libmatio's log and its HDF5 are not for several threads at once.
std::mutex& mat_mutex();

/// A MAT-file as libmatio sees it: checked and unpacked (internal/mat_image.h), in memory.
class MatFile {
 public:
  /// Throws IoError, and FormatError as unpacked_mat.
  explicit MatFile(const std::filesystem::path& path);
  ~MatFile();
  MatFile(const MatFile&) = delete;
  MatFile& operator=(const MatFile&) = delete;

  mat_t* get() const { return file_.get(); }

 private:
  int descriptor_ = -1;
  std::unique_ptr<mat_t, CloseMat> file_;
};

/// The variable with its data. Throws FormatError if it is not there. Hold mat_mutex().
MatVariable read_variable(const MatFile& file, const std::filesystem::path& path,
                          const std::string& name);

/// Writes one variable, compressed, beside `path` and renames. Throws IoError. Hold mat_mutex().
void write_variable(const std::filesystem::path& path, const MatVariable& variable);

}  // namespace arbox::io::internal
