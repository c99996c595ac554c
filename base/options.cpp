#include "arbox/base/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "arbox/base/error.h"
#include "arbox/base/names.h"

namespace arbox {
namespace {

template <class Type>
struct ListTraits : std::false_type {};
template <class Scalar>
struct ListTraits<std::vector<Scalar>> : std::true_type {
  using Element = Scalar;
  static constexpr std::size_t kCount = 0;
};
template <class Scalar, std::size_t count>
struct ListTraits<std::array<Scalar, count>> : std::true_type {
  using Element = Scalar;
  static constexpr std::size_t kCount = count;
};

template <class Type>
struct OptionalTraits : std::false_type {};
template <class Scalar>
struct OptionalTraits<std::optional<Scalar>> : std::true_type {
  using Element = Scalar;
};

template <class Scalar>
constexpr bool kIsNumber = std::is_arithmetic_v<Scalar> && !std::is_same_v<Scalar, bool>;

template <class Number>
std::string number_text(Number number) {
  if constexpr (std::is_floating_point_v<Number>) {
    if (std::isinf(number)) return number > 0 ? ".inf" : "-.inf";
    if (std::isnan(number)) return ".nan";
  }
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
  return {buffer.data(), end};
}

std::string quoted_text(std::string_view text) {
  static constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./-+";
  static constexpr std::string_view kHex = "0123456789abcdef";
  const bool plain = !text.empty() && text != "null" && text != "Null" && text != "NULL" &&
                     text.find_first_not_of(kPlain) == std::string_view::npos && text[0] != '-';
  if (plain) return std::string(text);
  std::string result = "\"";
  for (const char letter : text) {
    if (static_cast<unsigned char>(letter) < 0x20) {
      result += "\\x";
      result += kHex[static_cast<unsigned char>(letter) / 16];
      result += kHex[static_cast<unsigned char>(letter) % 16];
    } else {
      if (letter == '"' || letter == '\\') result += '\\';
      result += letter;
    }
  }
  return result + "\"";
}

template <class Scalar>
std::string scalar_text(const Scalar& value) {
  if constexpr (std::is_same_v<Scalar, bool>) {
    return value ? "true" : "false";
  } else if constexpr (std::is_same_v<Scalar, std::string>) {
    return quoted_text(value);
  } else {
    return number_text(value);
  }
}

template <class Scalar>
std::optional<Scalar> parse_scalar(std::string_view text) {
  if constexpr (std::is_same_v<Scalar, bool>) {
    if (text == "true" || text == "True") return true;
    if (text == "false" || text == "False") return false;
    return std::nullopt;
  } else if constexpr (std::is_same_v<Scalar, std::string>) {
    return std::string(text);
  } else {
    if constexpr (std::is_floating_point_v<Scalar>) {
      if (text == ".inf" || text == "-.inf") {
        const Scalar infinity = std::numeric_limits<Scalar>::infinity();
        return text[0] == '-' ? -infinity : infinity;
      }
    }
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
    Scalar number{};
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return number;
  }
}

template <class Scalar>
bool allowed(const Scalar& value, const OptionField& field) {
  if constexpr (std::is_same_v<Scalar, std::string>) {
    return field.choices.empty() ||
           std::find(field.choices.begin(), field.choices.end(), value) != field.choices.end();
  } else if constexpr (kIsNumber<Scalar>) {
    return static_cast<double>(value) >= field.low && static_cast<double>(value) <= field.high;
  } else {
    return true;
  }
}

std::string choice_list(const OptionField& field) {
  std::vector<std::string> words;
  for (const std::string_view word : field.choices) words.push_back(quoted_text(word));
  return "one of " + join(words, ", ");
}

std::string range_text(const OptionField& field) {
  const bool low = std::isfinite(field.low);
  const bool high = std::isfinite(field.high);
  if (low && high) return " from " + number_text(field.low) + " to " + number_text(field.high);
  if (low) return " of at least " + number_text(field.low);
  if (high) return " of at most " + number_text(field.high);
  return {};
}

template <class Scalar>
std::string type_text(const OptionField& field, bool plural) {
  if constexpr (std::is_same_v<Scalar, bool>) {
    return "true or false";
  } else if constexpr (std::is_same_v<Scalar, std::string>) {
    if (!field.choices.empty()) return choice_list(field);
    return plural ? "texts" : "text";
  } else {
    const std::string_view noun = std::is_integral_v<Scalar> ? "integer" : "number";
    return std::string(noun) + (plural ? "s" : "") + range_text(field);
  }
}

template <class List>
std::string list_type(const OptionField& field) {
  using Traits = ListTraits<List>;
  const std::string count = Traits::kCount > 0 ? " " + std::to_string(Traits::kCount) : "";
  const std::string element = type_text<typename Traits::Element>(field, true);
  const bool described = element.starts_with("one of") || element.starts_with("true");
  return "list of" + count + (described ? " words, each " : " ") + element;
}

std::string type_of(const OptionEnum&, const OptionField& field) { return choice_list(field); }

template <class Value>
std::string type_of(Value*, const OptionField& field) {
  if constexpr (ListTraits<Value>::value) {
    return list_type<Value>(field);
  } else if constexpr (OptionalTraits<Value>::value) {
    return type_text<typename OptionalTraits<Value>::Element>(field, false) + ", or null";
  } else {
    return type_text<Value>(field, false);
  }
}

std::string text_of(const OptionEnum& value, const OptionField& field) {
  const std::int64_t number = value.get(value.value);
  if (number < 0 || number >= static_cast<std::int64_t>(field.choices.size())) {
    return number_text(number);
  }
  return std::string(field.choices[static_cast<std::size_t>(number)]);
}

template <class Value>
std::string text_of(const Value* value, const OptionField&) {
  if constexpr (ListTraits<Value>::value) {
    std::vector<std::string> texts;
    for (const typename ListTraits<Value>::Element& element : *value) {
      texts.push_back(scalar_text<typename ListTraits<Value>::Element>(element));
    }
    return "[" + join(texts, ", ") + "]";
  } else if constexpr (OptionalTraits<Value>::value) {
    return value->has_value() ? scalar_text(**value) : "null";
  } else {
    return scalar_text(*value);
  }
}

bool valid(const OptionEnum& value, const OptionField& field) {
  const std::int64_t number = value.get(value.value);
  return number >= 0 && number < static_cast<std::int64_t>(field.choices.size());
}

template <class Value>
bool valid(const Value* value, const OptionField& field) {
  if constexpr (ListTraits<Value>::value) {
    using Element = typename ListTraits<Value>::Element;
    return std::all_of(value->begin(), value->end(),
                       [&](const Element& element) { return allowed<Element>(element, field); });
  } else if constexpr (OptionalTraits<Value>::value) {
    return !value->has_value() || allowed(**value, field);
  } else {
    return allowed(*value, field);
  }
}

bool store(const OptionEnum& value, const OptionField& field, const OptionInput& input) {
  const auto* text = std::get_if<std::string>(&input);
  if (text == nullptr) return false;
  const auto place = std::find(field.choices.begin(), field.choices.end(), *text);
  if (place == field.choices.end()) return false;
  value.set(value.value, place - field.choices.begin());
  return true;
}

template <class Scalar>
std::optional<Scalar> parse_allowed(const std::string& text, const OptionField& field) {
  std::optional<Scalar> value = parse_scalar<Scalar>(text);
  return value && allowed(*value, field) ? value : std::nullopt;
}

template <class List>
bool store_list(List& list, const OptionField& field, const std::vector<std::string>& texts) {
  using Traits = ListTraits<List>;
  if (Traits::kCount > 0 && texts.size() != Traits::kCount) return false;
  std::vector<typename Traits::Element> parsed;
  for (const std::string& text : texts) {
    const auto element = parse_allowed<typename Traits::Element>(text, field);
    if (!element) return false;
    parsed.push_back(*element);
  }
  if constexpr (Traits::kCount > 0) {
    std::copy(parsed.begin(), parsed.end(), list.begin());
  } else {
    list = std::move(parsed);
  }
  return true;
}

template <class Value>
bool store(Value* value, const OptionField& field, const OptionInput& input) {
  if constexpr (ListTraits<Value>::value) {
    const auto* texts = std::get_if<std::vector<std::string>>(&input);
    return texts != nullptr && store_list(*value, field, *texts);
  } else {
    if constexpr (OptionalTraits<Value>::value) {
      if (std::holds_alternative<std::monostate>(input)) {
        value->reset();
        return true;
      }
    }
    const auto* text = std::get_if<std::string>(&input);
    if (text == nullptr) return false;
    if constexpr (OptionalTraits<Value>::value) {
      const auto parsed = parse_allowed<typename OptionalTraits<Value>::Element>(*text, field);
      if (parsed) *value = *parsed;
      return parsed.has_value();
    } else {
      const auto parsed = parse_allowed<Value>(*text, field);
      if (parsed) *value = *parsed;
      return parsed.has_value();
    }
  }
}

std::string input_text(const OptionInput& input) {
  if (const auto* text = std::get_if<std::string>(&input)) return "'" + *text + "'";
  if (const auto* texts = std::get_if<std::vector<std::string>>(&input)) {
    return "[" + join(*texts, ", ") + "]";
  }
  return "nothing";
}

std::string violation(const BoundOption& option, const std::string& came) {
  std::string text = option.key + ": expected " + option_type(option);
  if (!option.field.unit.empty()) text += " (" + std::string(option.field.unit) + ")";
  return text + ", got " + came;
}

}  // namespace

std::optional<std::string> assign_option(const BoundOption& option, const OptionInput& input) {
  const bool stored =
      std::visit([&](auto value) { return store(value, option.field, input); }, option.value);
  if (stored) return std::nullopt;
  return violation(option, input_text(input));
}

std::string option_text(const BoundOption& option) {
  return std::visit([&](auto value) { return text_of(value, option.field); }, option.value);
}

std::string option_type(const BoundOption& option) {
  return std::visit([&](auto value) { return type_of(value, option.field); }, option.value);
}

bool is_switch(const BoundOption& option) { return std::holds_alternative<bool*>(option.value); }

bool is_list(const BoundOption& option) {
  return std::visit(
      []<class Value>(const Value&) { return ListTraits<std::remove_pointer_t<Value>>::value; },
      option.value);
}

std::vector<std::string> option_violations(const BoundOptions& options) {
  std::vector<std::string> violations;
  for (const BoundOption& option : options.fields) {
    if (!std::visit([&](auto value) { return valid(value, option.field); }, option.value)) {
      violations.push_back(violation(option, option_text(option)));
    }
  }
  return violations;
}

void validate_options(const BoundOptions& options, std::string_view where) {
  const std::vector<std::string> violations = option_violations(options);
  if (!violations.empty()) throw ConfigError(std::string(where) + ": " + join(violations, "; "));
}

}  // namespace arbox
