#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "arbox/base/option_field.h"

/// \file
/// What can be done with any options struct that has a `describe` (base/option_field.h): read it
/// from YAML, change single keys, validate it, write it with its help, print its documentation.
///
///     const auto options = arbox::read_options<NmsOptions>("nms.yaml");
///     arbox::validate_options(options, "my_nms");
///
/// Keys of nested structs are written with dots: `nms.threshold`. Nothing falls back silently: an
/// unknown or repeated key, a wrong type, a number out of range or a word that is no choice is a
/// violation. All violations of a text are listed in one ConfigError, separated by "; ".

namespace arbox {

/// Access to an enum field by the number of its value.
struct OptionEnum {
  void* value;
  std::int64_t (*get)(const void*);
  void (*set)(void*, std::int64_t);
};

template <class... Scalars>
using OptionPointerOf =
    std::variant<OptionEnum, Scalars*..., std::optional<Scalars>*..., std::vector<Scalars>*...,
                 std::array<Scalars, 2>*..., std::array<Scalars, 3>*..., std::array<Scalars, 4>*...,
                 std::array<Scalars, 6>*...>;

/// A pointer to one field of an options struct.
using OptionPointer =
    OptionPointerOf<bool, int, std::int64_t, std::uint64_t, float, double, std::string>;

/// One field of a struct, its description and its place in memory.
struct BoundOption {
  std::string key;
  OptionField field;
  OptionPointer value;
};

/// A nested struct: its key and what it is.
struct OptionGroup {
  std::string key;
  std::string_view help;
};

/// Every field of one struct in the order of its description. Valid as long as the struct.
struct BoundOptions {
  std::vector<BoundOption> fields;
  std::vector<OptionGroup> groups;
};

/// What a text gives a field: nothing (YAML null), one value or a list.
using OptionInput = std::variant<std::monostate, std::string, std::vector<std::string>>;

/// Parses and stores. Gives the violation ("score: expected a number from 0 to 1, got '2'"), or
/// nothing when the value is stored; after a violation the field is unchanged.
std::optional<std::string> assign_option(const BoundOption& option, const OptionInput& input);

/// The field's present value as YAML writes it: `0.5`, `[1, 2]`, `null`.
std::string option_text(const BoundOption& option);

/// What values a field takes: "number from 0 to 1", "list of 3 integers", "one of iou, iog".
std::string option_type(const BoundOption& option);

/// True for a field that is true or false.
bool is_switch(const BoundOption& option);
/// True for std::vector and std::array fields.
bool is_list(const BoundOption& option);

/// Violations of the struct's present values; empty means valid.
std::vector<std::string> option_violations(const BoundOptions& options);

/// Throws ConfigError that begins with `where` and lists every violation.
void validate_options(const BoundOptions& options, std::string_view where);

/// Stores what a YAML document says; keys it does not name keep their values, an empty document
/// changes nothing. Throws ConfigError: "FILE:LINE: unknown key 'treshold', nearest is 'threshold';
/// FILE:LINE: ...". Fields before a violation may be changed by then: use parse_options.
void assign_yaml(const BoundOptions& options, std::string_view yaml, std::string_view source);

/// Stores `key=value` assignments in order; lists as `key=[1, 2]`. Throws ConfigError as above.
void assign_overrides(const BoundOptions& options, const std::vector<std::string>& overrides);

/// A YAML document that assign_yaml reads back to equal values, each field below its help.
std::string options_yaml(const BoundOptions& options);

/// A Markdown table of key, values, default, unit and help.
std::string options_table(const BoundOptions& options);

/// The whole of a text file. Throws IoError.
std::string read_options_file(const std::filesystem::path& file);

/// The visitor of `describe` that binds fields to the memory of a struct.
template <class Options>
class OptionBinder {
 public:
  OptionBinder(Options& options, std::string prefix, BoundOptions& bound)
      : options_(options), prefix_(std::move(prefix)), bound_(bound) {}

  template <class Value, class Owner>
  void field(std::string_view name, Value Owner::*member, OptionField field) {
    bound_.fields.push_back(
        {prefix_ + std::string(name), std::move(field), pointer(options_.*member)});
  }

  template <class Group, class Owner>
  void group(std::string_view name, Group Owner::*member, std::string_view help) {
    const std::string key = prefix_ + std::string(name);
    bound_.groups.push_back({key, help});
    OptionBinder<Group> inner(options_.*member, key + ".", bound_);
    Group::describe(inner);
  }

 private:
  template <class Value>
  static OptionPointer pointer(Value& value) {
    if constexpr (std::is_enum_v<Value>) {
      return OptionEnum{&value,
                        [](const void* place) {
                          return static_cast<std::int64_t>(*static_cast<const Value*>(place));
                        },
                        [](void* place, std::int64_t number) {
                          *static_cast<Value*>(place) = static_cast<Value>(number);
                        }};
    } else {
      return &value;
    }
  }

  Options& options_;
  std::string prefix_;
  BoundOptions& bound_;
};

template <class Options>
BoundOptions bind_options(Options& options) {
  BoundOptions bound;
  OptionBinder<Options> binder(options, "", bound);
  Options::describe(binder);
  return bound;
}

struct OptionsInstance;

/// Makes instances of one options struct: how a list of all of them is kept.
using OptionsMaker = OptionsInstance (*)();

/// A default-made struct of a type that only its maker knows.
struct OptionsInstance {
  std::shared_ptr<void> storage;
  BoundOptions fields;
  OptionsMaker maker = nullptr;
};

template <class Options>
OptionsInstance make_options() {
  const auto storage = std::make_shared<Options>();
  return {storage, bind_options(*storage), &make_options<Options>};
}

/// `defaults` changed by a YAML text; `source` names it in errors. Throws ConfigError.
template <class Options>
Options parse_options(std::string_view yaml, std::string_view source, Options defaults = {}) {
  assign_yaml(bind_options(defaults), yaml, source);
  return defaults;
}

/// `defaults` changed by a YAML file. Throws IoError, ConfigError.
template <class Options>
Options read_options(const std::filesystem::path& file, Options defaults = {}) {
  return parse_options(read_options_file(file), file.string(), std::move(defaults));
}

/// `options` changed by `key=value` assignments. Throws ConfigError.
template <class Options>
Options override_options(Options options, const std::vector<std::string>& overrides) {
  assign_overrides(bind_options(options), overrides);
  return options;
}

/// Throws ConfigError that begins with `where` and lists every violation of a struct in memory.
template <class Options>
requires requires(OptionBinder<Options>& binder) { Options::describe(binder); }
void validate_options(const Options& options, std::string_view where) {
  Options copy = options;
  validate_options(bind_options(copy), where);
}

/// The struct as YAML with its help.
template <class Options>
requires requires(OptionBinder<Options>& binder) { Options::describe(binder); }
std::string options_yaml(const Options& options) {
  Options copy = options;
  return options_yaml(bind_options(copy));
}

}  // namespace arbox
