#pragma once

#include <bit>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/pickle_tree.h"
#include "arbox/io/internal/text.h"

namespace arbox::io::internal {

/// The values that a pickle has given a number, to name them again.
class PickleMemo {
 public:
  void put(std::uint64_t index, std::uint32_t value) {
    if (index < dense_.size()) {
      dense_[index] = value;
    } else if (index == dense_.size()) {
      dense_.push_back(value);
      if (!sparse_.empty()) sparse_.erase(index);
    } else {
      sparse_[index] = value;
    }
  }

  /// What MEMOIZE takes as the next index.
  std::uint64_t size() const { return dense_.size() + sparse_.size(); }

  const std::uint32_t* find(std::uint64_t index) const {
    if (index < dense_.size()) return &dense_[index];
    const auto found = sparse_.find(index);
    return found == sparse_.end() ? nullptr : &found->second;
  }

 private:
  std::vector<std::uint32_t> dense_;
  std::unordered_map<std::uint64_t, std::uint32_t> sparse_;
};

/// The stack machine that a pickle is written for, without the instructions' effects on the world.
class PickleMachine {
 public:
  using Node = PickleTree::Node;
  /// Of a node.
  using Number = std::uint32_t;

  PickleMachine(PickleTree& tree, std::size_t begin, const std::string& name)
      : tree_(tree), bytes_(*tree.content), at_(begin), name_(name) {
    add({.kind = PickleKind::kNone});
    add({.kind = PickleKind::kBool, .value = 0});
    add({.kind = PickleKind::kBool, .value = 1});
  }

  /// Runs to the end of the pickle and gives its value.
  Number run();

  /// The byte after it.
  std::size_t end() const { return at_; }

 private:
  static constexpr Number kNone = 0, kFalse = 1, kTrue = 2;

  [[noreturn]] void refuse(const std::string& what) const {
    fail_at_byte(name_, instruction_, "pickle: " + what);
  }

  // Reading.

  std::string_view take(std::uint64_t count) {
    if (count > bytes_.size() - at_) {
      refuse("expected " + std::to_string(count) + " bytes more, but the file ends after " +
             std::to_string(bytes_.size() - at_));
    }
    const std::string_view result = bytes_.substr(at_, count);
    at_ += count;
    return result;
  }

  std::string_view take_line() {
    const std::size_t end = bytes_.find('\n', at_);
    if (end == std::string_view::npos) refuse("expected a line, but the file ends within it");
    std::string_view line = take(end + 1 - at_);
    line.remove_suffix(1);
    return line;
  }

  std::uint64_t unsigned_number(std::size_t count) {
    std::uint64_t value = 0;
    const std::string_view digits = take(count);
    for (std::size_t i = 0; i < count; ++i) {
      value |= static_cast<std::uint64_t>(static_cast<unsigned char>(digits[i])) << (8 * i);
    }
    return value;
  }

  template <class T>
  T number_of(std::string_view line) const {
    T value{};
    if (!to_number(line, value)) refuse("expected a number, got " + quoted_text(line));
    return value;
  }

  // The stack. A mark is a position in it.

  Number add(Node node) {
    if (tree_.nodes.size() >= PickleTree::kNothing) refuse("expected fewer than 2^32 values");
    tree_.nodes.push_back(std::move(node));
    return static_cast<Number>(tree_.nodes.size() - 1);
  }

  void push(Number value) { stack_.push_back(value); }
  void push_new(Node node) { push(add(std::move(node))); }

  Number pop() {
    require_above_mark(1);
    const Number value = stack_.back();
    stack_.pop_back();
    return value;
  }

  Number top() const {
    require_above_mark(1);
    return stack_.back();
  }

  void require_above_mark(std::size_t count) const {
    if (stack_.size() < count + (marks_.empty() ? 0 : marks_.back())) {
      refuse("expected a value on the stack, which is empty");
    }
  }

  std::vector<Number> pop_last(std::size_t count) {
    require_above_mark(count);
    const auto begin = stack_.end() - static_cast<std::ptrdiff_t>(count);
    std::vector<Number> values(begin, stack_.end());
    stack_.erase(begin, stack_.end());
    return values;
  }

  std::vector<Number> pop_to_mark() {
    if (marks_.empty()) refuse("expected a mark on the stack, which has none");
    const std::size_t mark = marks_.back();
    marks_.pop_back();
    std::vector<Number> values(stack_.begin() + static_cast<std::ptrdiff_t>(mark), stack_.end());
    stack_.resize(mark);
    return values;
  }

  Node& node(Number number) { return tree_.nodes[number]; }

  // Making values.

  void push_characters(PickleKind kind, std::string_view characters) {
    push_new({.kind = kind, .value = characters.size(), .begin = characters.data()});
  }

  void push_decoded(PickleKind kind, std::optional<std::string> text, std::string_view line) {
    if (!text) refuse("expected text with Python's escapes, got " + quoted_text(line));
    tree_.decoded.push_back(std::move(*text));
    push_characters(kind, tree_.decoded.back());
  }

  void push_integer(std::int64_t value) {
    push_new({.kind = PickleKind::kInteger, .value = static_cast<std::uint64_t>(value)});
  }

  void push_float(double value) {
    push_new({.kind = PickleKind::kFloat, .value = std::bit_cast<std::uint64_t>(value)});
  }

  /// Two's complement, little-endian.
  void push_long(std::string_view digits) {
    if (digits.size() > sizeof(std::int64_t)) {
      push_characters(PickleKind::kBigInteger, digits);
      return;
    }
    const bool negative = !digits.empty() && (digits.back() & 0x80) != 0;
    std::int64_t value = negative ? -1 : 0;
    std::memcpy(&value, digits.data(), digits.size());
    push_integer(value);
  }

  void push_sequence(PickleKind kind, std::vector<Number> children) {
    push_new({.kind = kind, .children = std::move(children)});
  }

  void push_object(Number callable, Number arguments) {
    tree_.objects.push_back({.callable = callable, .arguments = arguments});
    push_new({.kind = PickleKind::kObject, .value = tree_.objects.size() - 1});
  }

  Number new_tuple(std::vector<Number> children) {
    return add({.kind = PickleKind::kTuple, .children = std::move(children)});
  }

  void push_global(Number module, Number name) {
    if (node(module).kind != PickleKind::kText || node(name).kind != PickleKind::kText) {
      refuse("expected module and name as text");
    }
    push_sequence(PickleKind::kGlobal, {module, name});
  }

  Number new_text(std::string_view text) {
    return add({.kind = PickleKind::kText, .value = text.size(), .begin = text.data()});
  }

  void push_named_global(std::string_view module, std::string_view name) {
    const Number first = new_text(module);
    push_global(first, new_text(name));
  }

  // Changing values.

  void append(Number target, const std::vector<Number>& values) {
    Node& changed = node(target);
    std::vector<Number>* list = &changed.children;
    if (changed.kind == PickleKind::kObject) {
      list = &tree_.object(changed).items;
    } else if (changed.kind != PickleKind::kList && changed.kind != PickleKind::kSet) {
      refuse("expected a list, set or object to add to, got " + std::string(name_of(changed.kind)));
    }
    list->insert(list->end(), values.begin(), values.end());
  }

  void set_items(Number target, const std::vector<Number>& values) {
    Node& changed = node(target);
    if (values.size() % 2 != 0) refuse("expected keys with values, got an odd number");
    std::vector<Number>* pairs = &changed.children;
    if (changed.kind == PickleKind::kObject) {
      pairs = &tree_.object(changed).pairs;
    } else if (changed.kind != PickleKind::kDict) {
      refuse("expected a dictionary or object to set items of, got " +
             std::string(name_of(changed.kind)));
    }
    pairs->insert(pairs->end(), values.begin(), values.end());
  }

  void build() {
    const Number state = pop();
    const Node& target = node(top());
    if (target.kind != PickleKind::kObject) {
      refuse("expected an object to give a state to, got " + std::string(name_of(target.kind)));
    }
    PickleTree::Object& object = tree_.object(target);
    if (object.state != PickleTree::kNothing) refuse("an object is given a state twice");
    object.state = state;
  }

  void reduce(Number callable, Number arguments) {
    if (node(arguments).kind != PickleKind::kTuple) {
      refuse("expected a tuple of arguments, got " + std::string(name_of(node(arguments).kind)));
    }
    push_object(callable, arguments);
  }

  void get(std::uint64_t index) {
    const Number* value = memo_.find(index);
    if (value == nullptr) {
      refuse("expected a value with the number " + std::to_string(index) + ", got none so far");
    }
    push(*value);
  }

  void append_values(const std::vector<Number>& values) { append(top(), values); }
  void set_values(const std::vector<Number>& values) { set_items(top(), values); }

  double big_endian_double() {
    std::uint64_t bits = 0;
    for (const char byte : take(8)) bits = bits << 8 | static_cast<unsigned char>(byte);
    return std::bit_cast<double>(bits);
  }

  void protocol(std::uint64_t number) const {
    if (number > 5) refuse("expected pickle protocol 0 to 5, got " + std::to_string(number));
  }

  void frame(std::uint64_t length) const {
    if (length > bytes_.size() - at_) {
      refuse("expected a frame of " + std::to_string(length) + " bytes, but the file ends after " +
             std::to_string(bytes_.size() - at_));
    }
  }

  // Instructions; false for a code that is not among them.
  bool step(char code);
  bool step_numbers(char code);
  bool step_characters(char code);
  bool step_object(char code);
  bool step_old(char code);

  PickleTree& tree_;
  std::string_view bytes_;
  std::size_t at_;
  std::size_t instruction_ = 0;
  const std::string& name_;
  std::vector<Number> stack_;
  std::vector<std::size_t> marks_;
  PickleMemo memo_;
};

}  // namespace arbox::io::internal
