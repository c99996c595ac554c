#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/geometry/box.h"
#include "arbox/io/detection_json.h"

/// \file
/// The parts of JSON reading and writing that need the JSON library's types.

namespace arbox::io::internal {

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
  /// The member of that name; refuses the object if it has none.
  JsonCursor at(const char* key) const;
  /// The elements; refuses what is not an array.
  std::vector<JsonCursor> elements() const;

  double number() const;
  bool boolean() const;
  std::string text() const;

 private:
  const Json* value_;
  std::string place_;
};

Json to_json(const geometry::Box& box);
Json to_json(const ScanDetections& scan);

geometry::Box read_box(const JsonCursor& value);
ScanDetections read_scan(const JsonCursor& value);

/// The values of a text: one, the elements of an array, or one after another.
std::vector<Json> parse_values(std::string_view text, std::string_view source);

/// The value as text: on one line if `indent` < 0, else with arrays and objects of plain numbers on
/// one line and all others indented. Bytes that are not UTF-8 become U+FFFD.
std::string dump(const Json& value, int indent);

}  // namespace arbox::io::internal
