#include "arbox/io/internal/mat_file.h"

#include <matio.h>
#include <unistd.h>

#include <cmath>
#include <memory>
#include <mutex>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/mat_access.h"
#include "arbox/io/internal/text.h"

namespace arbox::io::internal {

std::mutex& mat_mutex() {
  static std::mutex mutex;
  return mutex;
}

MatFile open_mat(const std::filesystem::path& path) {
  constexpr std::size_t kHeader = 128;
  const std::string head = read_file(path, kHeader);
  if (head.size() < kHeader || !head.starts_with("MATLAB 5.0 MAT-file")) {
    throw FormatError(path.string() +
                      ": expected a MATLAB 5.0 MAT-file (save it with -v7), got one that begins "
                      "with " +
                      quoted_text(std::string_view(head).substr(0, 16)));
  }
  // The library prints what it does not like on standard error.
  static const bool silent = [] {
    Mat_LogInitFunc("arbox", [](int, char*) {});
    return true;
  }();
  static_cast<void>(silent);
  MatFile file(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  if (!file)
    throw FormatError(path.string() + ": expected a MATLAB 5.0 MAT-file, got a broken one");
  return file;
}

MatVariable read_variable(mat_t* file, const std::filesystem::path& path, const std::string& name) {
  MatVariable variable(Mat_VarReadInfo(file, name.c_str()));
  if (!variable) {
    throw FormatError(path.string() + ": expected a variable '" + name + "', got none");
  }
  return variable;
}

namespace {

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

MatMatrix read_mat_matrix(const std::filesystem::path& path, const std::string& name) {
  // Deflate makes at most 1032 bytes of one.
  constexpr std::uintmax_t kExpansion = 1032;
  const std::scoped_lock lock(mat_mutex());
  const MatFile file = open_mat(path);
  const MatVariable variable = read_variable(file.get(), path, name);
  const bool number = variable->class_type == MAT_C_SINGLE || variable->class_type == MAT_C_DOUBLE;
  if (variable->rank != 2 || !number || variable->isComplex != 0) {
    throw FormatError(path.string() + ": expected a real matrix of single or double numbers as '" +
                      name + "'");
  }
  MatMatrix matrix{.rows = variable->dims[0], .columns = variable->dims[1], .values = {}};
  const std::uintmax_t most = std::filesystem::file_size(path) * kExpansion;
  if (matrix.columns != 0 && matrix.rows > most / matrix.columns) {
    throw FormatError(path.string() + ": variable '" + name + "' claims " +
                      std::to_string(matrix.rows) + " x " + std::to_string(matrix.columns) +
                      " numbers, more than the file can hold");
  }
  if (matrix.rows * matrix.columns == 0) return matrix;
  if (Mat_VarReadDataAll(file.get(), variable.get()) != 0 || variable->data == nullptr ||
      variable->nbytes <
          matrix.rows * matrix.columns * static_cast<std::size_t>(variable->data_size)) {
    throw FormatError(path.string() + ": the data of '" + name + "' are broken");
  }
  matrix.values.reserve(matrix.rows * matrix.columns);
  if (variable->data_type == MAT_T_DOUBLE) {
    copy_columns<double>(*variable, matrix);
  } else if (variable->data_type == MAT_T_SINGLE) {
    copy_columns<float>(*variable, matrix);
  } else {
    throw FormatError(path.string() + ": expected numbers as '" + name + "', got another type");
  }
  return matrix;
}

void write_mat_matrix(const std::filesystem::path& path, const std::string& name,
                      const MatMatrix& matrix) {
  std::vector<float> columns(matrix.values.size());
  for (std::size_t row = 0; row < matrix.rows; ++row) {
    for (std::size_t column = 0; column < matrix.columns; ++column) {
      columns[column * matrix.rows + row] = matrix.values[row * matrix.columns + column];
    }
  }
  std::filesystem::path beside = path;
  beside += ".part" + std::to_string(::getpid());
  const std::scoped_lock lock(mat_mutex());
  {
    const MatFile file(Mat_CreateVer(beside.c_str(), nullptr, MAT_FT_MAT5));
    std::size_t sizes[2] = {matrix.rows, matrix.columns};
    const MatVariable variable(Mat_VarCreate(name.c_str(), MAT_C_SINGLE, MAT_T_SINGLE, 2, sizes,
                                             columns.data(), MAT_F_DONT_COPY_DATA));
    if (!file || !variable || Mat_VarWrite(file.get(), variable.get(), MAT_COMPRESSION_ZLIB) != 0) {
      std::error_code ignored;
      std::filesystem::remove(beside, ignored);
      throw IoError(path.string() + ": cannot be written");
    }
  }
  std::error_code error;
  std::filesystem::rename(beside, path, error);
  if (error) throw IoError(path.string() + ": cannot be written: " + error.message());
}

}  // namespace arbox::io::internal
