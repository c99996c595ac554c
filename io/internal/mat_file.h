#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "arbox/io/sunrgbd.h"

/// \file
/// The only place that includes libmatio. Reads MATLAB 5 files (what `save -v7` writes); others
/// are refused before the library sees them.

namespace arbox::io::internal {

/// A real matrix, row after row.
struct MatMatrix {
  std::size_t rows = 0, columns = 0;
  std::vector<float> values;
};

/// Reads a variable. Throws FormatError for what is no such file, for a missing variable, for what
/// is no real matrix of numbers, and for sizes that the file cannot hold; IoError.
MatMatrix read_mat_matrix(const std::filesystem::path& path, const std::string& variable);

/// Writes one float32 variable, compressed. Throws IoError.
void write_mat_matrix(const std::filesystem::path& path, const std::string& variable,
                      const MatMatrix& matrix);

}  // namespace arbox::io::internal
