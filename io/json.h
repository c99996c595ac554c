#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

/// \file
/// What the readers and writers of JSON files share. The only header of this room that needs the
/// JSON library (nlohmann-json) to be installed where it is included.

namespace arbox::io {

/// Keeps the order in which keys are written.
using Json = nlohmann::ordered_json;

/// A value that is being read, with the file and the path of keys that lead to it.
class JsonCursor {
 public:
  JsonCursor(const Json& value, std::string place) : value_(&value), place_(std::move(place)) {}

  /// Throws FormatError "PLACE: expected EXPECTED, got <the value's type or text>".
  [[noreturn]] void refuse(const std::string& expected) const;

  /// Refuses the value unless it is an object.
  void require_object() const;
  /// Refuses the value unless it is an object whose keys are all among `known`.
  void require_object(const std::vector<std::string_view>& known) const;
  bool has(const char* key) const { return value_->contains(key); }
  /// The keys of an object in their order; refuses what is none.
  std::vector<std::string> keys() const;
  /// The file and the keys that lead here, for messages.
  const std::string& place() const { return place_; }
  /// The member of that name; refuses the object if it has none.
  JsonCursor at(const char* key) const;
  /// The elements; refuses what is not an array.
  std::vector<JsonCursor> elements() const;

  bool is_null() const { return value_->is_null(); }
  /// The value itself; each refuses a value of another type.
  double number() const;
  bool boolean() const;
  std::string text() const;

 private:
  const Json* value_;
  std::string place_;
};

/// The values of a text: one, the elements of an array, or one after another. Throws FormatError
/// with the line of what is not JSON.
std::vector<Json> parse_json_values(std::string_view text, std::string_view source);

/// The value as text: on one line if `indent` < 0, else with arrays and objects of plain numbers on
/// one line and all others indented. Bytes that are not UTF-8 become U+FFFD.
std::string dump_json(const Json& value, int indent);

}  // namespace arbox::io
