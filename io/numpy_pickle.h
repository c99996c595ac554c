#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/npy.h"
#include "arbox/io/pickle.h"

/// \file
/// NumPy's arrays in pickles (io/pickle.h), as every version of NumPy since 1.0 writes them in
/// every protocol, and the arrays of objects and of text in .npy files. Nothing is run.

namespace arbox::io {

/// True for an array or a single number of NumPy.
bool is_numpy(const PickleValue& value);

/// An array of numbers or booleans, or a single number (without shape). Either byte order, C or
/// Fortran order. Throws FormatError for other values, for element types that npy.h does not know,
/// and for data that do not fit the shape.
NpyArray numpy_array(const PickleValue& value);

/// An array with its elements in C order.
struct NumpyObjects {
  std::vector<std::size_t> shape;
  std::vector<PickleValue> values;
};
struct NumpyTexts {
  std::vector<std::size_t> shape;
  std::vector<std::string> values;
};

/// An array of Python objects (dtype object). Throws FormatError.
NumpyObjects numpy_objects(const PickleValue& value);

/// An array of text (dtypes str, bytes, and object if all are text), in UTF-8 (bytes as they are),
/// without NumPy's zeros at the end. Also a list or tuple of text, and one text (without shape).
/// Throws FormatError.
NumpyTexts numpy_texts(const PickleValue& value);

/// The array of objects in a .npy file: what numpy.save(..., allow_pickle=True) writes, and what
/// npz files of dictionaries hold. Throws FormatError.
NumpyObjects parse_npy_objects(std::string_view bytes, const std::string& name);

/// The array of text in a .npy file, as numpy_texts. Throws FormatError.
NumpyTexts parse_npy_texts(std::string_view bytes, const std::string& name);

}  // namespace arbox::io
