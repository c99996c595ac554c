#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "arbox/io/number_type.h"

/// \file
/// NumPy's array files (.npy, format versions 1 to 3): bool, integer and float arrays of any shape
/// in C or Fortran order and either byte order. Structured, complex, text and object arrays are
/// refused (object arrays hold pickles; nothing here runs code). Archives of them: io/npz.h.

namespace arbox::io {

/// What the header of a .npy file says.
struct NpyHeader {
  NumberType type = NumberType::kFloat32;
  bool big_endian = false;
  /// True if the first index runs fastest in the file.
  bool fortran_order = false;
  /// Empty for a scalar.
  std::vector<std::size_t> shape;
  /// Byte of the first number.
  std::size_t data_offset = 0;

  /// Numbers in the array: the product of the shape.
  std::size_t count() const;
};

/// Reads a header and checks that `bytes` holds all the numbers that it announces; bytes after them
/// are ignored, as NumPy does. Allocates nothing that the file does not hold. `name` goes into
/// messages. Throws FormatError.
NpyHeader parse_npy_header(std::string_view bytes, const std::string& name);

/// An array with its bytes as in the file.
class NpyArray {
 public:
  NpyArray(NpyHeader header, std::string data)
      : header_(std::move(header)), data_(std::move(data)) {}

  const NpyHeader& header() const { return header_; }
  const std::vector<std::size_t>& shape() const { return header_.shape; }
  std::size_t size() const { return header_.count(); }
  /// The numbers as the file holds them.
  std::string_view data() const { return data_; }

  /// The numbers in C order (last index fastest). T is float, double, int32_t, int64_t, uint8_t or
  /// uint32_t. Floats take every number, rounded; an integer T throws InvalidArgument for a number
  /// that it cannot hold exactly.
  template <class T>
  std::vector<T> values() const;

 private:
  NpyHeader header_;
  std::string data_;
};

/// `bytes` is the content of a .npy file. Throws FormatError that names `name`.
NpyArray parse_npy(std::string_view bytes, const std::string& name);

/// Throws IoError, FormatError.
NpyArray read_npy(const std::filesystem::path& path);

/// The bytes of a .npy file (version 1, C order, little-endian) of float, double, int32_t, int64_t,
/// uint8_t or uint32_t. Throws InvalidArgument if the
/// number of values is not the product of the shape.
template <class T>
std::string encode_npy(std::span<const T> values, const std::vector<std::size_t>& shape);

/// The bytes of a .npy file of numbers that are already stored as such a file has them. Throws
/// InvalidArgument if `data` has another length than the shape asks for.
std::string encode_npy(NumberType type, const std::vector<std::size_t>& shape,
                       std::string_view data);

/// Writes encode_npy(values, shape). Throws IoError, InvalidArgument.
template <class T>
void write_npy(const std::filesystem::path& path, std::span<const T> values,
               const std::vector<std::size_t>& shape);

}  // namespace arbox::io
