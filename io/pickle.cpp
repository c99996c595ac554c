#include "arbox/io/pickle.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/pickle_machine.h"
#include "arbox/io/internal/pickle_text.h"

namespace arbox::io {
namespace {

using internal::quoted_text;
using Node = PickleTree::Node;

bool is_module_of_built_ins(std::string_view module) {
  return module == "builtins" || module == "__builtin__";
}

/// A set as protocols 0 to 3 write it, or nothing: the list that it would be made of.
std::optional<PickleValue> list_of_set(const PickleValue& value) {
  if (!value.is(PickleKind::kObject) || !is_module_of_built_ins(value.module())) return {};
  if (value.name() != "set" && value.name() != "frozenset") return {};
  const PickleValue arguments = value.arguments();
  if (!arguments.is(PickleKind::kTuple) || arguments.size() != 1) return {};
  const PickleValue list = arguments[0];
  if (!list.is(PickleKind::kList)) return {};
  return list;
}

/// The bytes of _codecs.encode(text, "latin1"), or nothing.
std::optional<std::string> encoded_bytes(const PickleValue& value) {
  if (!value.is(PickleKind::kObject) || !value.is("_codecs", "encode")) return {};
  const PickleValue arguments = value.arguments();
  if (!arguments.is(PickleKind::kTuple) || arguments.size() != 2) return {};
  if (!arguments[0].is(PickleKind::kText) || !arguments[1].is(PickleKind::kText)) return {};
  const std::string_view encoding = arguments[1].text();
  if (encoding != "latin1" && encoding != "latin-1") return {};
  return internal::to_latin1(arguments[0].text());
}

/// The bytes that such a call, or one of bytes or bytearray, would make, or nothing.
std::optional<std::string> called_bytes(const PickleValue& value) {
  if (!is_module_of_built_ins(value.module())) return encoded_bytes(value);
  const PickleValue arguments = value.arguments();
  const bool made = value.name() == "bytes" || value.name() == "bytearray";
  if (!made || !arguments.is(PickleKind::kTuple) || arguments.size() > 1) return {};
  if (arguments.size() == 0) return "";
  if (arguments[0].is(PickleKind::kBytes)) return arguments[0].bytes();
  return encoded_bytes(arguments[0]);
}

const Node& node_of(const PickleTree& tree, std::uint32_t number) { return tree.nodes[number]; }

}  // namespace

std::string_view name_of(PickleKind kind) {
  constexpr std::string_view kNames[] = {"None",  "bool",   "integer", "big integer",  "float",
                                         "bytes", "text",   "list",    "tuple",        "dictionary",
                                         "set",   "global", "object",  "persistent id"};
  return kNames[static_cast<int>(kind)];
}

PickleValue::PickleValue(std::shared_ptr<const PickleTree> tree, std::uint32_t node,
                         std::string place)
    : tree_(std::move(tree)), node_(node), place_(std::move(place)) {}

PickleValue PickleValue::child(std::uint32_t node, const std::string& step) const {
  return {tree_, node, place_ + step};
}

PickleKind PickleValue::kind() const { return node_of(*tree_, node_).kind; }

void PickleValue::refuse(const std::string& expected) const {
  const Node& node = node_of(*tree_, node_);
  std::string came(name_of(node.kind));
  if (node.kind == PickleKind::kText || node.kind == PickleKind::kBytes) {
    came += " " + quoted_text(tree_->characters(node));
  } else if (node.kind == PickleKind::kBool) {
    came = node.value != 0 ? "True" : "False";
  } else if (node.kind == PickleKind::kInteger) {
    came = std::to_string(static_cast<std::int64_t>(node.value));
  } else if (node.kind == PickleKind::kFloat) {
    came = std::to_string(std::bit_cast<double>(node.value));
  } else if (!module().empty()) {
    came += " " + quoted_text(std::string(module()) + "." + std::string(name()));
  }
  throw FormatError(place_ + ": expected " + expected + ", got " + came);
}

bool PickleValue::boolean() const {
  if (!is(PickleKind::kBool)) refuse("True or False");
  return node_of(*tree_, node_).value != 0;
}

std::int64_t PickleValue::integer() const {
  const Node& node = node_of(*tree_, node_);
  if (node.kind != PickleKind::kInteger && node.kind != PickleKind::kBool) refuse("an integer");
  return static_cast<std::int64_t>(node.value);
}

std::size_t PickleValue::length() const {
  const std::int64_t value = integer();
  if (value < 0) refuse("a number from 0");
  return static_cast<std::size_t>(value);
}

double PickleValue::number() const {
  const Node& node = node_of(*tree_, node_);
  if (node.kind == PickleKind::kFloat) return std::bit_cast<double>(node.value);
  if (node.kind != PickleKind::kInteger && node.kind != PickleKind::kBool) refuse("a number");
  return static_cast<double>(integer());
}

std::string_view PickleValue::text() const {
  const Node& node = node_of(*tree_, node_);
  if (node.kind != PickleKind::kText && node.kind != PickleKind::kBytes) refuse("text");
  return tree_->characters(node);
}

std::string PickleValue::bytes() const {
  const Node& node = node_of(*tree_, node_);
  if (node.kind == PickleKind::kBytes || node.kind == PickleKind::kBigInteger) {
    return std::string(tree_->characters(node));
  }
  if (node.kind != PickleKind::kObject) refuse("bytes");
  auto called = called_bytes(*this);
  if (!called) refuse("bytes");
  return std::move(*called);
}

std::size_t PickleValue::size() const {
  const Node& node = node_of(*tree_, node_);
  switch (node.kind) {
    case PickleKind::kList:
    case PickleKind::kTuple:
    case PickleKind::kSet:
      return node.children.size();
    case PickleKind::kDict:
      return node.children.size() / 2;
    case PickleKind::kObject: {
      const auto list = list_of_set(*this);
      return list ? list->size() : tree_->object(node).pairs.size() / 2;
    }
    default:
      refuse("a list, tuple, set or dictionary");
  }
}

PickleValue PickleValue::operator[](std::size_t index) const {
  const Node& node = node_of(*tree_, node_);
  if (const auto list = list_of_set(*this)) return (*list)[index];
  if (node.kind != PickleKind::kList && node.kind != PickleKind::kTuple &&
      node.kind != PickleKind::kSet) {
    refuse("a list, tuple or set");
  }
  if (index >= node.children.size()) {
    throw FormatError(place_ + ": expected at least " + std::to_string(index + 1) +
                      " elements, got " + std::to_string(node.children.size()));
  }
  return child(node.children[index], "[" + std::to_string(index) + "]");
}

std::vector<PickleValue> PickleValue::elements() const {
  const Node& node = node_of(*tree_, node_);
  if (node.kind == PickleKind::kDict) refuse("a list, tuple or set");
  std::vector<PickleValue> result;
  const std::size_t count = size();
  result.reserve(count);
  for (std::size_t i = 0; i < count; ++i) result.push_back((*this)[i]);
  return result;
}

std::vector<double> PickleValue::numbers() const {
  const auto is_sequence = [&](const Node& node) {
    return node.kind == PickleKind::kList || node.kind == PickleKind::kTuple;
  };
  const Node& top = node_of(*tree_, node_);
  if (!is_sequence(top)) refuse("a list or tuple of numbers");
  std::vector<double> result;
  struct Level {
    const Node* node;
    std::size_t next;
  };
  std::vector<Level> levels = {{&top, 0}};
  const std::size_t limit = tree_->content->size();
  std::size_t steps = 0;
  while (!levels.empty()) {
    Level& level = levels.back();
    if (level.next == level.node->children.size()) {
      levels.pop_back();
      continue;
    }
    // What a list holds takes a byte at least, unless it is shared or holds itself.
    if (++steps > limit) refuse("numbers that are not shared over and over");
    const std::uint32_t number = level.node->children[level.next++];
    const Node& node = node_of(*tree_, number);
    if (is_sequence(node)) {
      levels.push_back({&node, 0});
    } else if (node.kind == PickleKind::kFloat) {
      result.push_back(std::bit_cast<double>(node.value));
    } else {
      result.push_back(child(number, "[...]").number());
    }
  }
  return result;
}

PickleValue PickleValue::key(std::size_t index) const {
  const Node& node = node_of(*tree_, node_);
  if (node.kind != PickleKind::kDict && node.kind != PickleKind::kObject) refuse("a dictionary");
  const auto& pairs = tree_->pairs(node);
  if (index >= pairs.size() / 2) {
    throw FormatError(place_ + ": expected more than " + std::to_string(index) + " pairs, got " +
                      std::to_string(pairs.size() / 2));
  }
  return child(pairs[2 * index], ".keys[" + std::to_string(index) + "]");
}

PickleValue PickleValue::value(std::size_t index) const {
  const PickleValue name = key(index);
  const bool named = name.is(PickleKind::kText) || name.is(PickleKind::kBytes);
  return child(
      tree_->pairs(node_of(*tree_, node_))[2 * index + 1],
      named ? "[" + quoted_text(name.text()) + "]" : ".values[" + std::to_string(index) + "]");
}

std::optional<PickleValue> PickleValue::find(std::string_view wanted) const {
  const Node& node = node_of(*tree_, node_);
  if (node.kind != PickleKind::kDict && node.kind != PickleKind::kObject) refuse("a dictionary");
  const auto& pairs = tree_->pairs(node);
  for (std::size_t i = pairs.size() / 2; i-- > 0;) {
    const Node& name = node_of(*tree_, pairs[2 * i]);
    if (name.kind != PickleKind::kText && name.kind != PickleKind::kBytes) continue;
    if (tree_->characters(name) == wanted) return value(i);
  }
  return std::nullopt;
}

PickleValue PickleValue::at(std::string_view wanted) const {
  if (auto found = find(wanted)) return std::move(*found);
  constexpr std::size_t kShown = 20;
  std::vector<std::string> names;
  const std::size_t count = tree_->pairs(node_of(*tree_, node_)).size() / 2;
  for (std::size_t i = 0; i < std::min(count, kShown); ++i) {
    const PickleValue name = key(i);
    names.push_back(name.is(PickleKind::kText) || name.is(PickleKind::kBytes)
                        ? quoted_text(name.text())
                        : std::string(io::name_of(name.kind())));
  }
  throw FormatError(place_ + ": expected the key " + quoted_text(wanted) + ", got " +
                    (names.empty() ? "none" : internal::listed(names, ", ")) +
                    (count > kShown ? ", ..." : ""));
}

std::string_view PickleValue::module() const {
  const Node& node = node_of(*tree_, node_);
  const Node& global =
      node.kind == PickleKind::kObject ? node_of(*tree_, tree_->object(node).callable) : node;
  if (global.kind != PickleKind::kGlobal) return {};
  return tree_->characters(node_of(*tree_, global.children[0]));
}

std::string_view PickleValue::name() const {
  const Node& node = node_of(*tree_, node_);
  const Node& global =
      node.kind == PickleKind::kObject ? node_of(*tree_, tree_->object(node).callable) : node;
  if (global.kind != PickleKind::kGlobal) return {};
  return tree_->characters(node_of(*tree_, global.children[1]));
}

bool PickleValue::is(std::string_view module, std::string_view name) const {
  return this->module() == module && this->name() == name;
}

PickleValue PickleValue::callable() const {
  if (!is(PickleKind::kObject)) refuse("an object");
  return child(tree_->object(node_of(*tree_, node_)).callable, ".callable");
}

PickleValue PickleValue::arguments() const {
  if (!is(PickleKind::kObject)) refuse("an object");
  return child(tree_->object(node_of(*tree_, node_)).arguments, ".arguments");
}

std::optional<PickleValue> PickleValue::named_arguments() const {
  if (!is(PickleKind::kObject)) refuse("an object");
  const std::uint32_t named = tree_->object(node_of(*tree_, node_)).named_arguments;
  if (named == PickleTree::kNothing) return std::nullopt;
  return child(named, ".named_arguments");
}

std::optional<PickleValue> PickleValue::state() const {
  if (!is(PickleKind::kObject)) refuse("an object");
  const std::uint32_t state = tree_->object(node_of(*tree_, node_)).state;
  if (state == PickleTree::kNothing) return std::nullopt;
  return child(state, ".state");
}

std::vector<PickleValue> PickleValue::items() const {
  if (!is(PickleKind::kObject)) refuse("an object");
  std::vector<PickleValue> result;
  for (const std::uint32_t item : tree_->object(node_of(*tree_, node_)).items) {
    result.push_back(child(item, ".items[" + std::to_string(result.size()) + "]"));
  }
  return result;
}

PickleValue PickleValue::id() const {
  if (!is(PickleKind::kPersistent)) refuse("a persistent id");
  return child(node_of(*tree_, node_).children[0], ".id");
}

std::vector<PickleValue> PickleValue::persistent_values() const {
  std::vector<PickleValue> result;
  for (std::uint32_t i = 0; i < tree_->nodes.size(); ++i) {
    if (node_of(*tree_, i).kind == PickleKind::kPersistent) {
      result.push_back({tree_, i, "persistent value " + std::to_string(result.size())});
    }
  }
  return result;
}

PickleValue parse_pickle(std::shared_ptr<const std::string> content, std::size_t& begin,
                         const std::string& name) {
  if (begin >= content->size()) {
    internal::fail(name, content->empty() ? "expected a pickle, got an empty file"
                                          : "expected a pickle, but the file ends before it");
  }
  const auto tree = std::make_shared<PickleTree>();
  tree->content = std::move(content);
  internal::PickleMachine machine(*tree, begin, name);
  const std::uint32_t root = machine.run();
  begin = machine.end();
  return {tree, root, name};
}

PickleValue parse_pickle(std::string bytes, const std::string& name) {
  std::size_t begin = 0;
  return parse_pickle(std::make_shared<const std::string>(std::move(bytes)), begin, name);
}

PickleValue read_pickle(const std::filesystem::path& path) {
  return parse_pickle(read_file(path), path.string());
}

}  // namespace arbox::io
