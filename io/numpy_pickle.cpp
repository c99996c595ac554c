#include "arbox/io/numpy_pickle.h"

#include <cstdint>
#include <optional>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/io/internal/load_number.h"
#include "arbox/io/internal/npy_description.h"
#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/pickle_text.h"
#include "arbox/io/internal/text.h"

namespace arbox::io {
namespace {

using internal::fail;
using internal::FortranOrder;

/// An array as it is stored, whatever its elements are.
struct StoredArray {
  /// "<f4", "|O", "<U12".
  std::string type;
  bool fortran_order = false;
  std::vector<std::size_t> shape;
  /// Bytes, or a list of objects.
  std::optional<PickleValue> data;
};

bool is_made_by(const PickleValue& value, std::string_view module, std::string_view name) {
  if (value.name() != name) return false;
  return value.module() == "numpy.core." + std::string(module) ||
         value.module() == "numpy._core." + std::string(module);
}

bool is_plain_array(const PickleValue& value) {
  return is_made_by(value, "multiarray", "_reconstruct");
}
bool is_buffer_array(const PickleValue& value) {
  return is_made_by(value, "numeric", "_frombuffer");
}
bool is_scalar(const PickleValue& value) { return is_made_by(value, "multiarray", "scalar"); }

/// Element `index` of a tuple that has at least `count`.
PickleValue part(const PickleValue& tuple, std::size_t index, std::size_t count) {
  if (!tuple.is(PickleKind::kTuple) || tuple.size() < count) {
    tuple.refuse("a tuple of at least " + std::to_string(count) + " parts of a NumPy array");
  }
  return tuple[index];
}

std::string read_type(const PickleValue& value) {
  if (!value.is(PickleKind::kObject) || !value.is("numpy", "dtype")) value.refuse("a NumPy dtype");
  std::string type(part(value.arguments(), 0, 1).text());
  char order = '|';
  if (const auto state = value.state()) {
    const std::string_view told = part(*state, 1, 4).text();
    if (told.size() != 1 || std::string_view("<>=|").find(told[0]) == std::string_view::npos) {
      (*state)[1].refuse("a byte order < > = or |");
    }
    order = told[0] == '=' ? '<' : told[0];
    if (!(*state)[2].is_none() || !(*state)[3].is_none()) {
      value.refuse("a dtype without fields; structured arrays are not read");
    }
  }
  if (type.starts_with('O')) type = "O";
  return order + type;
}

std::vector<std::size_t> read_shape(const PickleValue& value) {
  if (!value.is(PickleKind::kTuple)) {
    if (value.is(PickleKind::kInteger)) return {value.length()};
    value.refuse("a shape");
  }
  constexpr std::size_t kMostAxes = 32;
  if (value.size() > kMostAxes) value.refuse("at most 32 dimensions");
  std::vector<std::size_t> shape;
  for (const PickleValue& size : value.elements()) shape.push_back(size.length());
  return shape;
}

StoredArray stored(const PickleValue& value) {
  StoredArray array;
  if (!value.is(PickleKind::kObject)) value.refuse("a NumPy array");
  if (is_plain_array(value)) {
    const auto state = value.state();
    if (!state) value.refuse("a NumPy array with its state");
    const std::size_t parts = state->is(PickleKind::kTuple) ? state->size() : 0;
    const std::size_t first = parts > 4 ? 1 : 0;  // The version, which NumPy 1.0 left out.
    array.shape = read_shape(part(*state, first, first + 4));
    array.type = read_type((*state)[first + 1]);
    array.fortran_order = (*state)[first + 2].integer() != 0;
    array.data = (*state)[first + 3];
  } else if (is_buffer_array(value)) {
    const PickleValue arguments = value.arguments();
    array.data = part(arguments, 0, 4);
    array.type = read_type(arguments[1]);
    array.shape = read_shape(arguments[2]);
    array.fortran_order = arguments[3].text() == "F";
  } else if (is_scalar(value)) {
    const PickleValue arguments = value.arguments();
    array.type = read_type(part(arguments, 0, 2));
    array.data = arguments[1];
  } else {
    value.refuse("a NumPy array");
  }
  return array;
}

std::size_t count_of(const StoredArray& array, const std::string& place) {
  internal::require_array_bytes(array.shape, 1, "elements", SIZE_MAX, place);
  return NpyHeader{.shape = array.shape}.count();
}

/// The bytes, exactly as many as the shape asks for.
std::string bytes_of(const StoredArray& array, std::size_t element_bytes,
                     const std::string& place) {
  std::string bytes = array.data->bytes();
  internal::require_array_bytes(array.shape, element_bytes, array.type, bytes.size(), place);
  if (bytes.size() != count_of(array, place) * element_bytes) {
    fail(place, "expected a NumPy array of " + std::to_string(count_of(array, place)) +
                    " elements of " + array.type + ", got " + std::to_string(bytes.size()) +
                    " bytes");
  }
  return bytes;
}

NumpyObjects objects_of(const StoredArray& array, const std::string& place) {
  if (array.type.substr(1) != "O") {
    fail(place, "expected an array of objects, got one of " + internal::quoted_text(array.type));
  }
  NumpyObjects objects{.shape = array.shape, .values = array.data->elements()};
  if (objects.values.size() != count_of(array, place)) {
    array.data->refuse("a list of " + std::to_string(count_of(array, place)) +
                       " objects, as the shape tells");
  }
  return objects;
}

/// One element of an array of text, without the zeros at its end.
std::string text_element(std::string_view bytes, bool wide, bool big_endian,
                         const std::string& place) {
  std::string text;
  if (!wide) {
    text = bytes;
  } else {
    for (std::size_t at = 0; at + 4 <= bytes.size(); at += 4) {
      const auto point = internal::load_number<std::uint32_t>(
          reinterpret_cast<const std::byte*>(bytes.data() + at), big_endian);
      if (point > 0x10FFFF) fail(place, "holds a character that is not in Unicode");
      internal::append_utf8(text, point);
    }
  }
  text.resize(text.find_last_not_of('\0') + 1);
  return text;
}

/// `bytes`: as many as shape and type ask for.
NumpyTexts texts_of(std::string_view type, bool fortran_order,
                    const std::vector<std::size_t>& shape, std::string_view bytes,
                    std::size_t element_bytes, const std::string& place) {
  NumpyTexts texts{.shape = shape, .values = {}};
  const std::size_t count = NpyHeader{.shape = shape}.count();
  FortranOrder order(shape);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = fortran_order ? order.position() : i;
    texts.values.push_back(text_element(bytes.substr(at * element_bytes, element_bytes),
                                        type[1] == 'U', type[0] == '>', place));
    if (fortran_order) order.advance();
  }
  return texts;
}

/// Bytes of an element of a type such as "<U12" or "|S3".
std::size_t text_bytes(std::string_view type, const std::string& place) {
  std::size_t characters = 0;
  const bool text = type.size() > 2 && (type[1] == 'U' || type[1] == 'S' || type[1] == 'a');
  if (!text || !internal::to_number(type.substr(2), characters) || characters == 0 ||
      characters > UINT32_MAX) {
    fail(place, "expected an array of text, got one of " + internal::quoted_text(type));
  }
  return type[1] == 'U' ? 4 * characters : characters;
}

NumpyTexts texts_of_objects(const NumpyObjects& objects) {
  NumpyTexts texts{.shape = objects.shape, .values = {}};
  for (const PickleValue& value : objects.values) texts.values.emplace_back(value.text());
  return texts;
}

PickleValue pickle_in_npy(std::string_view bytes, const internal::NpyDescription& header,
                          const std::string& name) {
  return parse_pickle(std::string(bytes.substr(header.data_offset)), name);
}

}  // namespace

bool is_numpy(const PickleValue& value) {
  return value.is(PickleKind::kObject) &&
         (is_plain_array(value) || is_buffer_array(value) || is_scalar(value));
}

NpyArray numpy_array(const PickleValue& value) {
  const StoredArray array = stored(value);
  const auto type = internal::number_type_of(array.type);
  if (!type) {
    fail(value.place(), "expected an array of bools, integers or floats, got one of " +
                            internal::quoted_text(array.type));
  }
  std::string bytes = bytes_of(array, size_of(*type), value.place());
  return {{.type = *type,
           .big_endian = array.type.front() == '>' && size_of(*type) > 1,
           .fortran_order = array.fortran_order,
           .shape = array.shape},
          std::move(bytes)};
}

NumpyObjects numpy_objects(const PickleValue& value) {
  return objects_of(stored(value), value.place());
}

NumpyTexts numpy_texts(const PickleValue& value) {
  if (value.is(PickleKind::kText) || value.is(PickleKind::kBytes)) {
    return {.shape = {}, .values = {std::string(value.text())}};
  }
  if (value.is(PickleKind::kList) || value.is(PickleKind::kTuple)) {
    return texts_of_objects({.shape = {value.size()}, .values = value.elements()});
  }
  const StoredArray array = stored(value);
  if (array.type.substr(1) == "O") return texts_of_objects(objects_of(array, value.place()));
  const std::size_t element = text_bytes(array.type, value.place());
  const std::string bytes = bytes_of(array, element, value.place());
  return texts_of(array.type, array.fortran_order, array.shape, bytes, element, value.place());
}

NumpyObjects parse_npy_objects(std::string_view bytes, const std::string& name) {
  const internal::NpyDescription header = internal::parse_npy_description(bytes, name);
  if (!header.type.ends_with('O')) {
    fail(name, "expected an array of objects, got one of " + internal::quoted_text(header.type));
  }
  NumpyObjects objects = numpy_objects(pickle_in_npy(bytes, header, name));
  if (objects.shape != header.shape) {
    fail(name, "expected one shape in the header and in the pickle, got two");
  }
  return objects;
}

NumpyTexts parse_npy_texts(std::string_view bytes, const std::string& name) {
  const internal::NpyDescription header = internal::parse_npy_description(bytes, name);
  if (header.type.ends_with('O')) return numpy_texts(pickle_in_npy(bytes, header, name));
  const std::size_t element = text_bytes(header.type, name);
  const std::string_view data = bytes.substr(header.data_offset);
  internal::require_array_bytes(header.shape, element, header.type, data.size(), name);
  return texts_of(header.type, header.fortran_order, header.shape, data, element, name);
}

}  // namespace arbox::io
