#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/internal/torch_storages.h"

namespace arbox::io::internal {
namespace {

class ZipStorages : public TorchCheckpoint::Storages {
 public:
  ZipStorages(std::shared_ptr<const std::string> content, const std::string& name)
      : content_(std::move(content)), zip_(*content_, name, "a PyTorch checkpoint") {
    file_size = content_->size();
    constexpr std::uint64_t kLeastLimit = 64 << 20, kRatio = 8;
    const std::uint64_t limit = std::max(kLeastLimit, kRatio * file_size);
    std::uint64_t total = 0;
    for (std::size_t i = 0; i < zip_.entries().size(); ++i) {
      const auto& entry = zip_.entries()[i];
      total += std::min(entry.size, limit);
      if (total > limit || entry.size > limit) {
        fail(name, "unpacks to more than the limit of " + std::to_string(limit) + " bytes (" +
                       std::to_string(file_size) + " bytes are packed)");
      }
      entries_.emplace(entry.name, i);
      const std::size_t slash = entry.name.find('/');
      if (slash != std::string::npos && entry.name.substr(slash) == "/data.pkl") {
        folder_ = entry.name.substr(0, slash + 1);
      }
    }
    if (folder_.empty()) {
      fail(name, "expected a PyTorch checkpoint, got a zip archive without data.pkl");
    }
  }

  bool has(const std::string& entry) const { return entries_.contains(folder_ + entry); }

  std::string read(const std::string& entry, const std::string& place) const {
    const auto found = entries_.find(folder_ + entry);
    if (found == entries_.end()) {
      fail(place, "expected the entry " + quoted_text(folder_ + entry) + ", which is missing");
    }
    return zip_.read(found->second, zip_.entries()[found->second].size,
                     place + ": entry " + quoted_text(folder_ + entry));
  }

  std::string_view bytes(const std::string& key, const std::string& place) override {
    const auto held = storages_.find(key);
    if (held != storages_.end()) return held->second;
    return storages_[key] = read("data/" + key, place);
  }

 private:
  std::shared_ptr<const std::string> content_;
  ZipReader zip_;
  std::map<std::string, std::size_t> entries_;
  std::string folder_;
  std::map<std::string, std::string> storages_;
};

class StreamStorages : public TorchCheckpoint::Storages {
 public:
  explicit StreamStorages(std::shared_ptr<const std::string> content)
      : content_(std::move(content)) {
    file_size = content_->size();
  }

  /// Takes the storage that begins at byte `at` with the number of its elements, and moves on.
  void take(const std::string& key, std::size_t element_bytes, std::size_t& at,
            const std::string& name) {
    std::uint64_t count = 0;
    const bool counted = content_->size() - at >= sizeof count;
    if (counted) std::memcpy(&count, content_->data() + at, sizeof count);
    const std::size_t left = counted ? content_->size() - at - sizeof count : 0;
    if (!counted || count > left / element_bytes) {
      fail(name, "the file ends within storage " + quoted_text(key));
    }
    at += sizeof count;
    const std::size_t size = static_cast<std::size_t>(count) * element_bytes;
    storages_[key] = std::string_view(*content_).substr(at, size);
    at += size;
  }

  std::string_view bytes(const std::string& key, const std::string& place) override {
    const auto found = storages_.find(key);
    if (found == storages_.end()) {
      fail(place, "expected the storage " + quoted_text(key) + ", which is missing");
    }
    return found->second;
  }

 private:
  std::shared_ptr<const std::string> content_;
  std::map<std::string, std::string_view> storages_;
};

bool is_stream(const PickleValue& first) {
  // 0x1950a86a20f9469cfc6c
  constexpr std::string_view kMagic = "\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19";
  return first.is(PickleKind::kBigInteger) && first.bytes() == kMagic;
}

/// The bytes of one element of each storage, which the ids in the value tell.
std::map<std::string, std::size_t> element_sizes(const PickleValue& value) {
  std::map<std::string, std::size_t> sizes;
  for (const PickleValue& persistent : value.persistent_values()) {
    const TorchStorage storage = read_torch_storage(persistent);
    sizes[storage.key] = storage.number ? storage.number->bytes() : 1;
  }
  return sizes;
}

}  // namespace

TorchCheckpoint parse_torch_zip(std::shared_ptr<const std::string> bytes, const std::string& name) {
  const auto storages = std::make_shared<ZipStorages>(std::move(bytes), name);
  if (storages->has("constants.pkl")) {
    fail(name, "expected the tensors of a checkpoint, got a TorchScript module");
  }
  if (storages->has("byteorder") && storages->read("byteorder", name) != "little") {
    fail(name, "expected little-endian numbers");
  }
  return {parse_pickle(storages->read("data.pkl", name), name), storages};
}

TorchCheckpoint parse_torch_stream(std::shared_ptr<const std::string> bytes,
                                   const std::string& name) {
  std::size_t at = 0;
  if (!is_stream(parse_pickle(bytes, at, name))) {
    fail(name,
         "expected a PyTorch checkpoint, got a pickle of something else (or a file of PyTorch "
         "before 0.1.10)");
  }
  constexpr std::int64_t kProtocol = 1001;
  const PickleValue protocol = parse_pickle(bytes, at, name + ": protocol");
  if (protocol.integer() != kProtocol) protocol.refuse("1001");
  const PickleValue system = parse_pickle(bytes, at, name + ": system");
  if (!system.at("little_endian").boolean()) fail(name, "expected little-endian numbers");
  PickleValue value = parse_pickle(bytes, at, name);
  const PickleValue keys = parse_pickle(bytes, at, name + ": storages");
  const auto sizes = element_sizes(value);
  const auto storages = std::make_shared<StreamStorages>(bytes);
  for (const PickleValue& key : keys.elements()) {
    const std::string text(key.text());
    const auto size = sizes.find(text);
    if (size == sizes.end()) key.refuse("the key of a storage that the checkpoint uses");
    storages->take(text, size->second, at, name);
  }
  return {std::move(value), storages};
}

}  // namespace arbox::io::internal
