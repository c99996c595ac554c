#include "arbox/io/json.h"

#include <algorithm>
#include <iterator>
#include <sstream>

#include "arbox/base/error.h"
#include "arbox/io/internal/text.h"

namespace arbox::io {
namespace {

std::string without_prefix(const std::string& message) {
  std::string text = message.substr(std::min(message.find("] ") + 2, message.size()));
  const std::size_t syntax = text.find("syntax error");
  return syntax == std::string::npos ? text : text.substr(syntax);
}

std::size_t line_of(std::string_view text, std::size_t byte) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte, text.size()));
  return 1 + static_cast<std::size_t>(std::count(text.begin(), end, '\n'));
}

std::string dump_flat(const Json& value) {
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

bool is_plain(const Json& value) {
  return !value.is_structured() ||
         (value.is_array() && std::none_of(value.begin(), value.end(),
                                           [](const Json& v) { return v.is_structured(); }));
}

void dump_pretty(const Json& value, int indent, int level, std::string& text) {
  if (value.empty() || is_plain(value)) {
    text += dump_flat(value);
    return;
  }
  const bool object = value.is_object();
  text += object ? '{' : '[';
  const char* separator = "\n";
  for (auto item = value.begin(); item != value.end(); ++item) {
    text += separator;
    text.append(static_cast<std::size_t>(indent) * (level + 1), ' ');
    if (object) text += dump_flat(Json(item.key())) + ": ";
    dump_pretty(*item, indent, level + 1, text);
    separator = ",\n";
  }
  text += '\n';
  text.append(static_cast<std::size_t>(indent) * level, ' ');
  text += object ? '}' : ']';
}

}  // namespace

void JsonCursor::refuse(const std::string& expected) const {
  std::string came = value_->type_name();
  if (value_->is_number()) came = value_->dump();
  if (value_->is_string()) came = internal::quoted_text(value_->get_ref<const std::string&>());
  if (value_->is_array()) {
    constexpr std::size_t kShown = 10;
    came = value_->size() <= kShown && is_plain(*value_)
               ? dump_flat(*value_)
               : came + " of " + std::to_string(value_->size());
  }
  throw FormatError(place_ + ": expected " + expected + ", got " + came);
}

void JsonCursor::require_object() const {
  if (!value_->is_object()) refuse("an object");
}

void JsonCursor::require_object(const std::vector<std::string_view>& known) const {
  require_object();
  for (auto item = value_->begin(); item != value_->end(); ++item) {
    if (std::find(known.begin(), known.end(), item.key()) == known.end()) {
      throw FormatError(place_ + ": expected keys among " + internal::joined(known, ", ") +
                        ", got " + internal::quoted_text(item.key()));
    }
  }
}

std::vector<std::string> JsonCursor::keys() const {
  require_object();
  std::vector<std::string> names;
  for (auto item = value_->begin(); item != value_->end(); ++item) names.push_back(item.key());
  return names;
}

JsonCursor JsonCursor::at(const char* key) const {
  const auto found = value_->find(key);
  if (found == value_->end()) {
    throw FormatError(place_ + ": expected the key '" + key + "', got an object without it");
  }
  return {*found, place_ + "/" + key};
}

std::vector<JsonCursor> JsonCursor::elements() const {
  if (!value_->is_array()) refuse("an array");
  std::vector<JsonCursor> result;
  for (const Json& element : *value_) {
    result.emplace_back(element, place_ + "/" + std::to_string(result.size()));
  }
  return result;
}

double JsonCursor::number() const {
  if (!value_->is_number()) refuse("a number");
  return value_->get<double>();
}

bool JsonCursor::boolean() const {
  if (!value_->is_boolean()) refuse("true or false");
  return value_->get<bool>();
}

std::string JsonCursor::text() const {
  if (!value_->is_string()) refuse("a string");
  return value_->get<std::string>();
}

std::vector<Json> parse_json_values(std::string_view text, std::string_view source) {
  std::vector<Json> values;
  std::istringstream stream{std::string(text)};
  std::size_t begin = 0;
  try {
    while ((stream >> std::ws).good()) {
      begin = static_cast<std::size_t>(stream.tellg());
      stream >> values.emplace_back();
    }
  } catch (const Json::parse_error& error) {
    const internal::TextPlace place{source, line_of(text, begin + error.byte)};
    internal::refuse(place, "JSON", without_prefix(error.what()));
  } catch (const Json::exception& error) {
    internal::refuse({source, line_of(text, begin)}, "JSON", without_prefix(error.what()));
  }
  if (values.size() != 1 || !values[0].is_array()) return values;
  // Moved, since copies of deeply nested values would exhaust the stack.
  Json array = std::move(values[0]);
  return {std::make_move_iterator(array.begin()), std::make_move_iterator(array.end())};
}

std::string dump_json(const Json& value, int indent) {
  if (indent < 0) return dump_flat(value);
  std::string text;
  dump_pretty(value, indent, 0, text);
  return text;
}

}  // namespace arbox::io
