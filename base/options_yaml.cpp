#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <system_error>

#include "arbox/base/error.h"
#include "arbox/base/names.h"
#include "arbox/base/options.h"

namespace arbox {
namespace {

const BoundOption* find_field(const BoundOptions& options, const std::string& key) {
  const auto place = std::find_if(options.fields.begin(), options.fields.end(),
                                  [&](const BoundOption& option) { return option.key == key; });
  return place == options.fields.end() ? nullptr : &*place;
}

bool is_group(const BoundOptions& options, const std::string& key) {
  return std::any_of(options.groups.begin(), options.groups.end(),
                     [&](const OptionGroup& group) { return group.key == key; });
}

// The keys of one level: fields and groups whose key is `prefix` and one more word.
std::vector<std::string> keys_below(const BoundOptions& options, const std::string& prefix) {
  std::vector<std::string> keys;
  const auto add = [&](const std::string& key) {
    if (key.starts_with(prefix) && key.find('.', prefix.size()) == std::string::npos) {
      keys.push_back(key);
    }
  };
  for (const BoundOption& option : options.fields) add(option.key);
  for (const OptionGroup& group : options.groups) add(group.key);
  return keys;
}

std::string unknown_key_text(const BoundOptions& options, const std::string& prefix,
                             const std::string& key) {
  const std::string last_part = "." + key, full_key = prefix + key;
  // A key that is right but stands in another group is the nearest there is.
  for (const BoundOption& option : options.fields) {
    if (option.key.ends_with(last_part) && !option.key.starts_with(full_key)) {
      return "unknown key '" + full_key + "', nearest is '" + option.key + "'";
    }
  }
  return unknown_name_text("key", full_key, keys_below(options, prefix));
}

std::optional<OptionInput> to_input(const YAML::Node& node) {
  if (node.IsNull()) return OptionInput();
  if (node.IsScalar()) return OptionInput(node.Scalar());
  if (!node.IsSequence()) return std::nullopt;
  std::vector<std::string> texts;
  for (const YAML::Node& element : node) {
    if (!element.IsScalar()) return std::nullopt;
    texts.push_back(element.Scalar());
  }
  return OptionInput(texts);
}

class YamlReader {
 public:
  YamlReader(const BoundOptions& options, std::string_view source)
      : options_(options), source_(source) {}

  void read(const YAML::Node& node, const std::string& prefix) {
    if (!node.IsMap()) {
      complain(node, (prefix.empty() ? "" : prefix.substr(0, prefix.size() - 1) + ": ") +
                         "expected keys with values");
      return;
    }
    std::set<std::string> seen;
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) {
        complain(entry.first, "expected a word as key");
      } else if (!seen.insert(entry.first.Scalar()).second) {
        complain(entry.first, "key '" + prefix + entry.first.Scalar() + "' stands twice");
      } else {
        read_entry(entry.first, entry.second, prefix);
      }
    }
  }

  const std::vector<std::string>& violations() const { return violations_; }

 private:
  void read_entry(const YAML::Node& name, const YAML::Node& value, const std::string& prefix) {
    const std::string key = prefix + name.Scalar();
    if (const BoundOption* option = find_field(options_, key)) {
      const auto input = to_input(value);
      const auto violation =
          input ? assign_option(*option, *input)
                : std::optional(key + ": expected " + option_type(*option) + ", got nested keys");
      if (violation) complain(name, *violation);
    } else if (is_group(options_, key)) {
      read(value, key + ".");
    } else {
      complain(name, unknown_key_text(options_, prefix, name.Scalar()));
    }
  }

  void complain(const YAML::Node& node, const std::string& text) {
    violations_.push_back(source_ + ":" + std::to_string(node.Mark().line + 1) + ": " + text);
  }

  const BoundOptions& options_;
  std::string source_;
  std::vector<std::string> violations_;
};

std::vector<YAML::Node> parse(std::string_view yaml, std::string_view source) {
  try {
    return YAML::LoadAll(std::string(yaml));
  } catch (const YAML::Exception& error) {
    throw ConfigError(std::string(source) + ":" + std::to_string(error.mark.line + 1) +
                      ": not YAML: " + error.msg);
  }
}

std::optional<std::string> apply(const BoundOptions& options, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos) return "'" + assignment + "': expected key=value";
  const std::string key = assignment.substr(0, equals);
  const std::string text = assignment.substr(equals + 1);
  const BoundOption* option = find_field(options, key);
  if (option == nullptr) {
    if (is_group(options, key)) return key + ": is a group, expected one of its keys";
    const std::size_t dot = key.rfind('.');
    const std::size_t split = dot == std::string::npos ? 0 : dot + 1;
    const bool in_group = split > 0 && is_group(options, key.substr(0, dot));
    return in_group ? unknown_key_text(options, key.substr(0, split), key.substr(split))
                    : unknown_key_text(options, "", key);
  }
  if (is_list(*option)) {
    const std::vector<YAML::Node> documents = parse(text, key);
    const auto input = documents.size() == 1 ? to_input(documents.front()) : std::nullopt;
    return assign_option(*option, input.value_or(OptionInput(text)));
  }
  if (text == "null" && !assign_option(*option, OptionInput())) return std::nullopt;
  return assign_option(*option, text);
}

std::string cell(std::string text) {
  for (std::size_t place = 0; (place = text.find('|', place)) != std::string::npos; place += 2) {
    text.insert(place, "\\");
  }
  return text;
}

}  // namespace

void assign_yaml(const BoundOptions& options, std::string_view yaml, std::string_view source) {
  const std::vector<YAML::Node> documents = parse(yaml, source);
  if (documents.empty() || (documents.size() == 1 && documents.front().IsNull())) return;
  if (documents.size() > 1) {
    throw ConfigError(std::string(source) + ": expected one YAML document, got " +
                      std::to_string(documents.size()));
  }
  YamlReader reader(options, source);
  reader.read(documents.front(), "");
  if (!reader.violations().empty()) throw ConfigError(join(reader.violations(), "; "));
}

void assign_overrides(const BoundOptions& options, const std::vector<std::string>& overrides) {
  std::vector<std::string> violations;
  for (const std::string& assignment : overrides) {
    if (const auto violation = apply(options, assignment)) violations.push_back(*violation);
  }
  if (!violations.empty()) throw ConfigError(join(violations, "; "));
}

std::string options_yaml(const BoundOptions& options) {
  std::string text;
  std::set<std::string> opened;
  const auto line = [&](std::size_t depth, const std::string& words) {
    text += std::string(2 * depth, ' ') + words + "\n";
  };
  for (const BoundOption& option : options.fields) {
    std::size_t depth = 0;
    std::size_t start = 0;
    for (std::size_t dot = 0; (dot = option.key.find('.', start)) != std::string::npos; ++depth) {
      const std::string group = option.key.substr(0, dot);
      if (opened.insert(group).second) {
        const auto place = std::find_if(options.groups.begin(), options.groups.end(),
                                        [&](const OptionGroup& one) { return one.key == group; });
        line(depth, "# " + std::string(place->help));
        line(depth, group.substr(start) + ":");
      }
      start = dot + 1;
    }
    const std::string unit =
        option.field.unit.empty() ? "" : ", in " + std::string(option.field.unit);
    line(depth, "# " + std::string(option.field.help) + " (" + option_type(option) + unit + ")");
    line(depth, option.key.substr(start) + ": " + option_text(option));
  }
  return text;
}

std::string options_table(const BoundOptions& options) {
  std::string text =
      "| key | values | default | unit | meaning |\n"
      "| --- | --- | --- | --- | --- |\n";
  for (const BoundOption& option : options.fields) {
    text += "| `" + option.key + "` | " + cell(option_type(option)) + " | `" +
            cell(option_text(option)) + "` | " + cell(std::string(option.field.unit)) + " | " +
            cell(std::string(option.field.help)) + " |\n";
  }
  return text;
}

std::string read_options_file(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file)) {
    throw IoError(file.string() + ": expected a YAML file, got a folder");
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    throw IoError(file.string() + ": cannot read: " + std::generic_category().message(errno));
  }
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace arbox
