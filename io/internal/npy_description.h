#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/number_type.h"

namespace arbox::io::internal {

/// The header of a .npy file with any element type.
struct NpyDescription {
  /// "<f4", "|O", "<U12".
  std::string type;
  bool fortran_order = false;
  std::vector<std::size_t> shape;
  std::size_t data_offset = 0;
};

/// Throws FormatError for what is no header, and for structured types.
NpyDescription parse_npy_description(std::string_view bytes, const std::string& name);

/// The type of numbers of such a word; nothing for others.
std::optional<NumberType> number_type_of(std::string_view type);

/// The product of the shape times `element_bytes`, or nothing if it or one of its parts is beyond
/// 2^63. Zeros are left out of the test, so that an empty array cannot hide an absurd dimension.
std::optional<std::size_t> array_bytes(const std::vector<std::size_t>& shape,
                                       std::size_t element_bytes);

/// Throws FormatError unless an array of that shape takes `held` bytes or fewer.
void require_array_bytes(const std::vector<std::size_t>& shape, std::size_t element_bytes,
                         std::string_view type, std::size_t held, const std::string& name);

/// Positions of the numbers of an array in Fortran order, when they are asked for in C order.
class FortranOrder {
 public:
  /// `shape` must live as long.
  explicit FortranOrder(const std::vector<std::size_t>& shape)
      : shape_(shape), index_(shape.size()), stride_(shape.size()) {
    std::size_t stride = 1;
    for (std::size_t axis = 0; axis < shape.size(); ++axis) {
      stride_[axis] = stride;
      stride *= shape[axis];
    }
  }

  std::size_t position() const { return position_; }

  void advance() {
    for (std::size_t axis = shape_.size(); axis-- > 0;) {
      position_ += stride_[axis];
      if (++index_[axis] < shape_[axis]) return;
      position_ -= stride_[axis] * shape_[axis];
      index_[axis] = 0;
    }
  }

 private:
  const std::vector<std::size_t>& shape_;
  std::vector<std::size_t> index_, stride_;
  std::size_t position_ = 0;
};

}  // namespace arbox::io::internal
