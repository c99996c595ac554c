#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/number_type.h"

/// \file
/// Pickles of plain values and of NumPy's arrays, for programs in Python that want their data so
/// (protocol 4: Python 3.4 and later, NumPy 1 and 2). What is written needs no code but NumPy's.
///
///     PickleWriter pickle;
///     pickle.begin_dict();
///     pickle.text("count"), pickle.integer(2);
///     pickle.text("boxes"), pickle.array<double>(boxes, {2, 7});
///     pickle.end();
///     write_file("infos.pkl", std::move(pickle).finish());

namespace arbox::io {

/// Writes values one after another; those between a begin and its end are inside of it. A
/// dictionary takes keys and values in turn.
class PickleWriter {
 public:
  PickleWriter();

  void none();
  void boolean(bool value);
  void integer(std::int64_t value);
  void number(double value);
  /// Bytes that are not UTF-8 become U+FFFD.
  void text(std::string_view value);
  void bytes(std::string_view value);

  void begin_list();
  void begin_dict();
  /// An array without shape that holds one Python object (dtype object), as numpy.savez makes of a
  /// dictionary.
  void begin_object_array();
  /// Ends the list, dictionary or array that was begun last. Throws InvalidArgument for a
  /// dictionary with a key too many, an array that does not hold one value, and if nothing is open.
  void end();

  /// A list of numbers, and one of lists of `columns` numbers each.
  void numbers(std::span<const double> values);
  void rows(std::span<const double> values, std::size_t columns);

  /// A NumPy array of numbers in C order. Throws InvalidArgument if `data` does not fill the shape.
  void array(NumberType type, const std::vector<std::size_t>& shape, std::string_view data);
  /// The same of float, double, int32_t, int64_t, uint8_t or uint32_t.
  template <class T>
  void array(std::span<const T> values, const std::vector<std::size_t>& shape);
  /// A NumPy array of text (dtype str) with one dimension.
  void texts(std::span<const std::string> values);

  /// The whole pickle. Throws InvalidArgument unless one value was written and all is ended.
  std::string finish() &&;

 private:
  enum class Kind { kPickle, kList, kDict, kObject };
  struct Open {
    Kind kind;
    std::size_t values = 0;
  };

  void begin(Kind kind, std::string_view code);
  void count();
  void put(std::string_view code) { bytes_.append(code); }
  void put_length(std::uint64_t length, char small, char large);
  void put_integer(std::int64_t value);
  void put_text(std::string_view value);
  void put_bytes(std::string_view value);
  void put_type(std::string_view word, char order, std::int64_t size, std::int64_t alignment,
                std::int64_t flags);
  void begin_array(const std::vector<std::size_t>& shape);

  std::string bytes_;
  std::vector<Open> open_;
};

/// The .npy bytes of an array without shape that holds one Python object: `pickle` is what a
/// PickleWriter made between begin_object_array() and end().
std::string encode_npy_object(std::string_view pickle);

}  // namespace arbox::io
