#include "arbox/io/internal/mat_file.h"

#include <matio.h>
#include <sys/mman.h>
#include <unistd.h>

#include <memory>
#include <mutex>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/mat_access.h"
#include "arbox/io/internal/mat_image.h"
#include "arbox/io/internal/text.h"

namespace arbox::io::internal {
namespace {

/// A file in memory. Throws IoError.
int memory_file(std::string_view content, const std::filesystem::path& path) {
  const int descriptor = ::memfd_create("arbox", MFD_CLOEXEC);
  while (descriptor >= 0 && !content.empty()) {
    const ssize_t written = ::write(descriptor, content.data(), content.size());
    if (written <= 0) break;
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  if (descriptor >= 0 && content.empty()) return descriptor;
  if (descriptor >= 0) ::close(descriptor);
  throw IoError(path.string() + ": no memory for its content");
}

template <class T>
void copy_columns(const matvar_t& variable, MatMatrix& matrix) {
  const auto* data = static_cast<const T*>(variable.data);
  for (std::size_t row = 0; row < matrix.rows; ++row) {
    for (std::size_t column = 0; column < matrix.columns; ++column) {
      matrix.values.push_back(static_cast<float>(data[column * matrix.rows + row]));
    }
  }
}

}  // namespace

std::mutex& mat_mutex() {
  static std::mutex mutex;
  return mutex;
}

MatFile::MatFile(const std::filesystem::path& path) {
  const std::string image = unpacked_mat(read_file(path), path.string());
  // The library prints what it does not like on standard error.
  static const bool silent = [] {
    Mat_LogInitFunc("arbox", [](int, char*) {});
    return true;
  }();
  static_cast<void>(silent);
  descriptor_ = memory_file(image, path);
  const std::string name = "/proc/self/fd/" + std::to_string(descriptor_);
  const std::scoped_lock lock(mat_mutex());
  file_.reset(Mat_Open(name.c_str(), MAT_ACC_RDONLY));
  if (file_) return;
  ::close(descriptor_);
  throw FormatError(path.string() + ": expected a MATLAB 5.0 MAT-file, got a broken one");
}

MatFile::~MatFile() {
  file_.reset();
  ::close(descriptor_);
}

MatVariable read_variable(const MatFile& file, const std::filesystem::path& path,
                          const std::string& name) {
  MatVariable variable(Mat_VarRead(file.get(), name.c_str()));
  if (!variable) {
    throw FormatError(path.string() + ": expected a variable '" + name + "', got none");
  }
  return variable;
}

MatMatrix read_mat_matrix(const std::filesystem::path& path, const std::string& name) {
  const MatFile file(path);
  const std::scoped_lock lock(mat_mutex());
  const MatVariable variable = read_variable(file, path, name);
  const bool number = variable->class_type == MAT_C_SINGLE || variable->class_type == MAT_C_DOUBLE;
  if (variable->rank != 2 || !number || variable->isComplex != 0) {
    throw FormatError(path.string() + ": expected a real matrix of single or double numbers as '" +
                      name + "'");
  }
  MatMatrix matrix{.rows = variable->dims[0], .columns = variable->dims[1], .values = {}};
  const std::size_t count = matrix.rows * matrix.columns;
  if (count == 0) return matrix;
  const bool wide = variable->data_type == MAT_T_DOUBLE;
  if (variable->data == nullptr || (!wide && variable->data_type != MAT_T_SINGLE) ||
      variable->nbytes < count * (wide ? sizeof(double) : sizeof(float))) {
    throw FormatError(path.string() + ": the data of '" + name + "' are broken");
  }
  matrix.values.reserve(count);
  wide ? copy_columns<double>(*variable, matrix) : copy_columns<float>(*variable, matrix);
  return matrix;
}

void write_variable(const std::filesystem::path& path, const MatVariable& variable) {
  std::filesystem::path beside = path;
  beside += ".part" + std::to_string(::getpid());
  std::unique_ptr<mat_t, CloseMat> file(Mat_CreateVer(beside.c_str(), nullptr, MAT_FT_MAT5));
  const bool written =
      file && variable && Mat_VarWrite(file.get(), variable.get(), MAT_COMPRESSION_ZLIB) == 0;
  file.reset();
  std::error_code error;
  if (!written) {
    std::filesystem::remove(beside, error);
    throw IoError(path.string() + ": cannot be written");
  }
  std::filesystem::rename(beside, path, error);
  if (error) throw IoError(path.string() + ": cannot be written: " + error.message());
}

void write_mat_matrix(const std::filesystem::path& path, const std::string& name,
                      const MatMatrix& matrix) {
  std::vector<float> columns(matrix.values.size());
  for (std::size_t row = 0; row < matrix.rows; ++row) {
    for (std::size_t column = 0; column < matrix.columns; ++column) {
      columns[column * matrix.rows + row] = matrix.values[row * matrix.columns + column];
    }
  }
  const std::scoped_lock lock(mat_mutex());
  std::size_t sizes[2] = {matrix.rows, matrix.columns};
  write_variable(path, MatVariable(Mat_VarCreate(name.c_str(), MAT_C_SINGLE, MAT_T_SINGLE, 2, sizes,
                                                 columns.data(), MAT_F_DONT_COPY_DATA)));
}

}  // namespace arbox::io::internal
