#include "arbox/io/torch_checkpoint.h"

#include <cstring>
#include <utility>
#include <vector>

#include "arbox/io/file.h"
#include "arbox/io/internal/npy_description.h"
#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/internal/torch_storages.h"
#include "arbox/io/npy.h"

namespace arbox::io {
namespace internal {

std::optional<TorchNumber> torch_number(std::string_view name) {
  struct Known {
    std::string_view type, storage;
    TorchNumber number;
  };
  static constexpr Known kKnown[] = {
      {"float32", "FloatStorage", {NumberType::kFloat32, false}},
      {"float64", "DoubleStorage", {NumberType::kFloat64, false}},
      {"float16", "HalfStorage", {NumberType::kFloat16, false}},
      {"bfloat16", "BFloat16Storage", {NumberType::kFloat16, true}},
      {"int64", "LongStorage", {NumberType::kInt64, false}},
      {"int32", "IntStorage", {NumberType::kInt32, false}},
      {"int16", "ShortStorage", {NumberType::kInt16, false}},
      {"int8", "CharStorage", {NumberType::kInt8, false}},
      {"uint8", "ByteStorage", {NumberType::kUint8, false}},
      {"bool", "BoolStorage", {NumberType::kBool, false}},
  };
  for (const Known& known : kKnown) {
    if (name == known.type || name == known.storage) return known.number;
  }
  return std::nullopt;
}

TorchStorage read_torch_storage(const PickleValue& persistent) {
  const PickleValue id = persistent.id();
  if (!id.is(PickleKind::kTuple) || id.size() < 5 || id[0].text() != "storage") {
    id.refuse("the id of a storage");
  }
  const PickleValue type = id[1];
  TorchStorage storage{.key = std::string(id[2].text()), .number = torch_number(type.name())};
  const bool untyped = type.name() == "UntypedStorage";
  if (!type.is(PickleKind::kGlobal) || !type.module().starts_with("torch") ||
      (!storage.number && !untyped)) {
    type.refuse("a storage of bools, integers or floats");
  }
  if (id.size() > 5 && !id[5].is_none()) id.refuse("a storage of its own, not a view of one");
  return storage;
}

}  // namespace internal

namespace {

using internal::TorchNumber;

bool is_call(const PickleValue& value, std::string_view name) {
  return value.is(PickleKind::kObject) && value.is("torch._utils", name);
}

bool is_plain_tensor(const PickleValue& value) {
  return is_call(value, "_rebuild_tensor_v2") || is_call(value, "_rebuild_tensor_v3") ||
         is_call(value, "_rebuild_tensor");
}

bool is_parameter(const PickleValue& value) {
  return is_call(value, "_rebuild_parameter") || is_call(value, "_rebuild_parameter_with_state");
}

std::vector<std::size_t> read_lengths(const PickleValue& tuple) {
  constexpr std::size_t kMostAxes = 64;
  if (!tuple.is(PickleKind::kTuple) || tuple.size() > kMostAxes) tuple.refuse("a shape or strides");
  std::vector<std::size_t> lengths;
  for (const PickleValue& length : tuple.elements()) lengths.push_back(length.length());
  return lengths;
}

/// How the numbers of a tensor lie in its storage, in elements.
struct StoredLayout {
  std::size_t offset = 0;
  std::vector<std::size_t> shape, strides;

  bool empty() const { return NpyHeader{.shape = shape}.count() == 0; }

  bool contiguous() const {
    std::size_t stride = 1;
    for (std::size_t axis = shape.size(); axis-- > 0;) {
      if (shape[axis] != 1 && strides[axis] != stride) return false;
      stride *= shape[axis];
    }
    return true;
  }

  /// The element after the last one that the tensor reads; nothing beyond 2^63. Not for empty ones.
  std::optional<std::size_t> end() const {
    constexpr auto kMost = static_cast<unsigned __int128>(INT64_MAX);
    unsigned __int128 last = offset;
    for (std::size_t axis = 0; axis < shape.size(); ++axis) {
      last += static_cast<unsigned __int128>(shape[axis] - 1) * strides[axis];
      if (last >= kMost) return std::nullopt;
    }
    return static_cast<std::size_t>(last) + 1;
  }
};

/// The numbers in C order.
std::string gathered(std::string_view storage, const StoredLayout& layout, std::size_t element) {
  const std::size_t count = NpyHeader{.shape = layout.shape}.count();
  if (count == 0) return {};
  if (layout.contiguous()) {
    return std::string(storage.substr(layout.offset * element, count * element));
  }
  std::string data(count * element, '\0');
  std::vector<std::size_t> index(layout.shape.size());
  std::size_t at = layout.offset;
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(data.data() + i * element, storage.data() + at * element, element);
    for (std::size_t axis = index.size(); axis-- > 0;) {
      at += layout.strides[axis];
      if (++index[axis] < layout.shape[axis]) break;
      at -= layout.strides[axis] * layout.shape[axis];
      index[axis] = 0;
    }
  }
  return data;
}

/// bfloat16 is the upper half of a float32.
std::string widened(const std::string& halves) {
  std::string data(2 * halves.size(), '\0');
  for (std::size_t i = 0; i < halves.size(); i += 2) {
    std::memcpy(data.data() + 2 * i + 2, halves.data() + i, 2);
  }
  return data;
}

}  // namespace

bool is_torch_tensor(const PickleValue& value) {
  return is_plain_tensor(value) || is_parameter(value);
}

TorchCheckpoint::TorchCheckpoint(PickleValue value, std::shared_ptr<Storages> storages)
    : value_(std::move(value)), storages_(std::move(storages)) {}

const PickleValue& TorchCheckpoint::value() const { return value_; }

ModelRecord TorchCheckpoint::tensor(const PickleValue& value) const {
  std::optional<PickleValue> plain = value;
  if (is_parameter(value)) {
    if (value.arguments().size() == 0) value.refuse("a parameter with its tensor");
    plain = value.arguments()[0];
  }
  if (!is_plain_tensor(*plain)) plain->refuse("a tensor");
  const PickleValue arguments = plain->arguments();
  const bool named_type = is_call(*plain, "_rebuild_tensor_v3");
  if (arguments.size() < (named_type ? 7 : 4)) arguments.refuse("the parts of a tensor");
  const internal::TorchStorage storage = internal::read_torch_storage(arguments[0]);
  const auto number = named_type ? internal::torch_number(arguments[6].name()) : storage.number;
  if (!number) arguments.refuse("a tensor of bools, integers or floats");
  const StoredLayout layout{.offset = arguments[1].length(),
                            .shape = read_lengths(arguments[2]),
                            .strides = read_lengths(arguments[3])};
  if (layout.shape.size() != layout.strides.size()) arguments.refuse("a stride for each axis");
  const std::size_t element = number->bytes();
  internal::require_array_bytes(layout.shape, element, "a tensor", storages_->file_size,
                                value.place());
  const std::string_view bytes = storages_->bytes(storage.key, value.place());
  if (!layout.empty()) {
    const auto end = layout.end();
    if (!end || *end > bytes.size() / element) {
      internal::fail(value.place(), "expected numbers within their storage of " +
                                        std::to_string(bytes.size()) + " bytes, got some beyond");
    }
  }
  std::string data = gathered(bytes, layout, element);
  if (!number->bfloat16) {
    return {.type = number->type, .shape = layout.shape, .data = std::move(data)};
  }
  return {.type = NumberType::kFloat32, .shape = layout.shape, .data = widened(data)};
}

std::map<std::string, ModelRecord> TorchCheckpoint::tensors(const PickleValue& dictionary) const {
  std::map<std::string, ModelRecord> result;
  std::size_t total = 0;
  for (std::size_t i = 0; i < dictionary.size(); ++i) {
    const PickleValue key = dictionary.key(i), value = dictionary.value(i);
    if (!key.is(PickleKind::kText) && !key.is(PickleKind::kBytes)) continue;
    if (!is_torch_tensor(value)) continue;
    ModelRecord record = tensor(value);
    total += record.data.size();
    if (total / 4 > storages_->file_size) {
      dictionary.refuse("tensors that together are not far larger than the file");
    }
    result.insert_or_assign(std::string(key.text()), std::move(record));
  }
  return result;
}

TorchCheckpoint parse_torch_checkpoint(std::string bytes, const std::string& name) {
  if (bytes.empty()) internal::fail(name, "expected a PyTorch checkpoint, got an empty file");
  const bool zip = bytes.starts_with("PK");
  auto content = std::make_shared<const std::string>(std::move(bytes));
  return zip ? internal::parse_torch_zip(std::move(content), name)
             : internal::parse_torch_stream(std::move(content), name);
}

TorchCheckpoint read_torch_checkpoint(const std::filesystem::path& path) {
  return parse_torch_checkpoint(read_file(path), path.string());
}

}  // namespace arbox::io
