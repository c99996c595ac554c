#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file
/// Python's pickles (protocols 0 to 5), read as data. A pickle is a program for a small machine
/// that may import modules and call functions; here it imports nothing and calls nothing: what
/// would be imported is a name, what would be called is an object that tells the name and the
/// arguments.
///
///     const auto infos = io::read_pickle("scannet_infos_val.pkl");
///     for (const auto& info : infos.elements()) {
///       const auto boxes = io::numpy_array(info.at("annos").at("gt_boxes_upright_depth"));
///     }
///
/// Safe for files of unknown origin: memory is at most about 100 times the size of the file, values
/// that the file names many times are stored once, nothing is read or freed recursively, lengths
/// are compared with the bytes that are there. NumPy's arrays: io/numpy_pickle.h.

namespace arbox::io {

enum class PickleKind {
  kNone,
  kBool,
  kInteger,
  /// An integer that 64 bits cannot hold.
  kBigInteger,
  kFloat,
  kBytes,
  kText,
  kList,
  kTuple,
  kDict,
  kSet,
  /// What Python would import: a module and a name in it.
  kGlobal,
  /// What Python would make by calling something.
  kObject,
  /// What Python would ask the program for, by an id.
  kPersistent
};

/// A word for messages: "list", "object".
std::string_view name_of(PickleKind kind);

struct PickleTree;

/// A value in a pickle; cheap to copy, keeps the whole pickle alive. Accessors of one kind throw
/// FormatError "PLACE: expected a list, got text 'x'" for another one.
class PickleValue {
 public:
  PickleValue(std::shared_ptr<const PickleTree> tree, std::uint32_t node, std::string place);

  PickleKind kind() const;
  bool is(PickleKind kind) const { return this->kind() == kind; }
  bool is_none() const { return is(PickleKind::kNone); }

  /// The file and the way to this value: "infos.pkl[3]['annos']".
  const std::string& place() const { return place_; }
  /// Throws FormatError "PLACE: expected EXPECTED, got <this value>".
  [[noreturn]] void refuse(const std::string& expected) const;

  bool boolean() const;
  /// Integers and booleans.
  std::int64_t integer() const;
  /// integer(); refuses numbers below 0.
  std::size_t length() const;
  /// Floats, integers and booleans.
  double number() const;
  /// Text, and the byte strings of Python 2.
  std::string_view text() const;
  /// Bytes, the two's complement (little-endian) of a big integer, and what Python 3 writes for
  /// bytes in protocols 0 to 2, a call of _codecs.encode.
  std::string bytes() const;

  /// Elements of a list, tuple or set; pairs of a dictionary or of an object's dictionary items.
  std::size_t size() const;
  /// Element of a list, tuple or set. Refuses indices that are too large.
  PickleValue operator[](std::size_t index) const;
  std::vector<PickleValue> elements() const;
  /// The numbers of a list or tuple and of the lists and tuples in it, in order. Refuses other
  /// values, and more numbers than the file has bytes.
  std::vector<double> numbers() const;

  /// Pair number `index` of a dictionary, in the order of the file.
  PickleValue key(std::size_t index) const;
  PickleValue value(std::size_t index) const;
  /// The value of a text key; the last one if there are several. O(size).
  std::optional<PickleValue> find(std::string_view key) const;
  bool has(std::string_view key) const { return find(key).has_value(); }
  /// As find; refuses a dictionary without that key, naming those that it has.
  PickleValue at(std::string_view key) const;

  /// Of a global, or of the global that an object would be made by; empty if it is made by
  /// something else.
  std::string_view module() const;
  std::string_view name() const;
  /// True for that global, or an object made by it.
  bool is(std::string_view module, std::string_view name) const;
  /// What an object would be made by.
  PickleValue callable() const;
  /// Its positional arguments: a tuple as a rule.
  PickleValue arguments() const;
  /// Its arguments by name: a dictionary.
  std::optional<PickleValue> named_arguments() const;
  /// What it would be changed by afterwards (BUILD).
  std::optional<PickleValue> state() const;
  /// What would be appended to it.
  std::vector<PickleValue> items() const;

  /// The id of a persistent value.
  PickleValue id() const;
  /// All persistent values of the pickle that this value is in.
  std::vector<PickleValue> persistent_values() const;

  /// True if both are one value of the file.
  bool same(const PickleValue& other) const { return tree_ == other.tree_ && node_ == other.node_; }

 private:
  PickleValue child(std::uint32_t node, const std::string& step) const;

  std::shared_ptr<const PickleTree> tree_;
  std::uint32_t node_;
  std::string place_;
};

/// The value of a pickle; bytes after its end are ignored, as Python does. `name` begins messages.
/// Throws FormatError for what is not a whole pickle, with the byte.
PickleValue parse_pickle(std::string bytes, const std::string& name);

/// The pickle that begins at byte `begin` of a longer content; `begin` becomes the byte after it.
PickleValue parse_pickle(std::shared_ptr<const std::string> content, std::size_t& begin,
                         const std::string& name);

/// Throws IoError, FormatError.
PickleValue read_pickle(const std::filesystem::path& path);

}  // namespace arbox::io
