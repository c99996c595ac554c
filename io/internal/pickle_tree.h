#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/pickle.h"

namespace arbox::io {

/// The values of a pickle, flat: they name each other by number, so that shared and recursive ones
/// need no care. Kept in blocks, so that growth takes no second copy.
struct PickleTree {
  struct Node {
    PickleKind kind = PickleKind::kNone;
    /// Bool and integer: the value. Float: its bits. Bytes, text and big integers: how many bytes.
    /// Object: the number of its Object.
    std::uint64_t value = 0;
    /// Bytes, text and big integers (two's complement): where they are.
    const char* begin = nullptr;
    /// List, tuple, set: the elements. Dictionary: keys and values in turn. Global: module, name.
    /// Persistent: the id.
    std::vector<std::uint32_t> children = {};
  };

  struct Object {
    std::uint32_t callable = 0;
    std::uint32_t arguments = 0;
    std::uint32_t named_arguments = kNothing;
    std::uint32_t state = kNothing;
    std::vector<std::uint32_t> items = {};
    std::vector<std::uint32_t> pairs = {};
  };

  static constexpr std::uint32_t kNothing = UINT32_MAX;

  std::shared_ptr<const std::string> content;
  std::deque<Node> nodes;
  std::deque<Object> objects;
  /// Texts that had escapes.
  std::deque<std::string> decoded;

  std::string_view characters(const Node& node) const {
    return {node.begin, static_cast<std::size_t>(node.value)};
  }
  const Object& object(const Node& node) const { return objects[node.value]; }
  Object& object(const Node& node) { return objects[node.value]; }
  /// The keys and values of a dictionary or of an object.
  const std::vector<std::uint32_t>& pairs(const Node& node) const {
    return node.kind == PickleKind::kObject ? object(node).pairs : node.children;
  }
};

}  // namespace arbox::io
