#include "arbox/io/model_archive.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <set>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/internal/zip_archive.h"
#include "arbox/io/json.h"
#include "arbox/io/npy.h"

namespace arbox::io {
namespace {

using internal::fail;
using internal::quoted_text;

constexpr char kArchiveFormat[] = "arbox model";
constexpr int kArchiveVersion = 1;

constexpr char kManifest[] = "arbox.json";
constexpr char kConfiguration[] = "configuration.yaml";
constexpr char kCalibrationMember[] = "calibration.json";
constexpr char kCard[] = "card.md";

std::string text_entry(const std::string& name) { return "texts/" + name; }
std::string record_entry(const std::string& name) { return "records/" + name + ".npy"; }

std::uint64_t unpacked_limit(std::uint64_t file_size) {
  constexpr std::uint64_t kLeast = 256 << 20, kRatio = 64;
  return std::max(kLeast, kRatio * file_size);
}

bool is_name(std::string_view name) {
  constexpr std::size_t kLongest = 255;
  if (name.empty() || name.size() > kLongest) return false;
  while (true) {
    const std::string_view part = name.substr(0, name.find('/'));
    const bool plain = std::all_of(part.begin(), part.end(), [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
             c == '_' || c == '-' || c == '.';
    });
    if (!plain || part.empty() || part == "." || part == "..") return false;
    if (part.size() == name.size()) return true;
    name.remove_prefix(part.size() + 1);
  }
}

void require_names(const ModelArchive& archive) {
  const auto require = [](bool good, const std::string& what) {
    if (!good) throw InvalidArgument("encode_model_archive: " + what);
  };
  require(!archive.kind.empty(), "expected a kind, got none");
  std::set<std::string> seen;
  for (const std::string& label : archive.classes) {
    require(!label.empty() && seen.insert(label).second,
            "expected different class names, got " + quoted_text(label) + " twice or empty");
  }
  const auto require_name = [&](const std::string& name, const char* what) {
    require(is_name(name), std::string("expected a ") + what +
                               " name of letters, digits and _ - . between single /, got " +
                               quoted_text(name));
  };
  for (const auto& [name, ignored] : archive.texts) require_name(name, "text");
  for (const auto& [name, record] : archive.records) {
    require_name(name, "record");
    require(record.data.size() % size_of(record.type) == 0 &&
                record.count() == record.data.size() / size_of(record.type),
            "record '" + name + "': expected " + std::to_string(record.count()) + " numbers of " +
                std::string(name_of(record.type)) + ", got " + std::to_string(record.data.size()) +
                " bytes");
  }
}

template <class Map>
Json keys_of(const Map& map) {
  Json keys = Json::array();
  for (const auto& [key, ignored] : map) keys.push_back(key);
  return keys;
}

std::string encode_manifest(const ModelArchive& archive) {
  const Json manifest = {{"format", kArchiveFormat},
                         {"version", kArchiveVersion},
                         {"kind", archive.kind},
                         {"classes", archive.classes},
                         {"texts", keys_of(archive.texts)},
                         {"records", keys_of(archive.records)}};
  return dump_json(manifest, 1) + "\n";
}

/// Gives the entries of an archive once each and tells those that nobody asked for.
class ModelEntries {
 public:
  ModelEntries(std::string_view bytes, const std::string& name)
      : name_(name), zip_(bytes, name, "an Arbox model") {
    const std::uint64_t limit = unpacked_limit(bytes.size());
    std::uint64_t total = 0;
    for (std::size_t i = 0; i < zip_.entries().size(); ++i) {
      const auto& entry = zip_.entries()[i];
      total += std::min(entry.size, limit);
      if (total > limit || entry.size > limit) {
        fail(name, "unpacks to more than the limit of " + std::to_string(limit) + " bytes (" +
                       std::to_string(bytes.size()) + " bytes are packed)");
      }
      if (!left_.emplace(entry.name, i).second) {
        fail(name, "holds the entry " + quoted_text(entry.name) + " twice");
      }
    }
  }

  bool has(const std::string& entry) const { return left_.contains(entry); }

  std::string take(const std::string& entry) {
    const auto found = left_.find(entry);
    if (found == left_.end()) fail(name_, "expected the entry '" + entry + "', which is missing");
    const std::size_t index = found->second;
    left_.erase(found);
    return zip_.read(index, zip_.entries()[index].size, place(entry));
  }

  std::string place(const std::string& entry) const { return name_ + ": entry '" + entry + "'"; }

  void require_all_taken() const {
    if (left_.empty()) return;
    fail(name_, "holds " + quoted_text(left_.begin()->first) +
                    ", which is not among the entries that its manifest names");
  }

 private:
  std::string name_;
  internal::ZipReader zip_;
  std::map<std::string, std::size_t> left_;
};

ModelRecord parse_record(std::string bytes, const std::string& place) {
  const NpyHeader header = parse_npy_header(bytes, place);
  if (header.big_endian || header.fortran_order) {
    fail(place, "expected little-endian numbers in C order");
  }
  const std::size_t size = header.count() * size_of(header.type);
  if (bytes.size() - header.data_offset != size) {
    fail(place, "expected " + std::to_string(size) + " bytes of numbers, got " +
                    std::to_string(bytes.size() - header.data_offset));
  }
  bytes.erase(0, header.data_offset);
  return {.type = header.type, .shape = header.shape, .data = std::move(bytes)};
}

std::vector<std::string> read_names(const JsonCursor& list, bool as_entries) {
  std::vector<std::string> names;
  std::set<std::string> seen;
  for (const JsonCursor& element : list.elements()) {
    names.push_back(element.text());
    if (names.back().empty() || !seen.insert(names.back()).second) {
      element.refuse("names that are different and not empty");
    }
    if (as_entries && !is_name(names.back())) element.refuse("the name of an entry");
  }
  return names;
}

struct Manifest {
  std::string kind;
  std::vector<std::string> classes, texts, records;
};

Manifest parse_manifest(const std::string& text, const std::string& place) {
  const auto values = parse_json_values(text, place);
  if (values.size() != 1) fail(place, "expected one JSON object");
  const JsonCursor root(values[0], place);
  root.require_object();
  if (root.at("format").text() != kArchiveFormat) root.at("format").refuse(kArchiveFormat);
  if (root.at("version").number() != kArchiveVersion) {
    root.at("version").refuse(
        "version 1, the only one that this build of Arbox reads (files of "
        "later versions need a later Arbox)");
  }
  root.require_object({"format", "version", "kind", "classes", "texts", "records"});
  Manifest manifest{.kind = root.at("kind").text(),
                    .classes = read_names(root.at("classes"), false),
                    .texts = read_names(root.at("texts"), true),
                    .records = read_names(root.at("records"), true)};
  if (manifest.kind.empty()) root.at("kind").refuse("a kind");
  return manifest;
}

}  // namespace

std::string encode_model_archive(const ModelArchive& archive, bool deflate) {
  require_names(archive);
  std::vector<std::string> kept;  // The contents that the archive itself does not hold.
  kept.reserve(archive.records.size() + 1);
  std::vector<internal::ZipMember> members;
  members.push_back({kManifest, kept.emplace_back(encode_manifest(archive))});
  const auto add_text = [&](const std::string& entry, const std::string& text) {
    if (!text.empty()) members.push_back({entry, text});
  };
  add_text(kConfiguration, archive.configuration);
  add_text(kCalibrationMember, archive.calibration);
  add_text(kCard, archive.card);
  for (const auto& [name, text] : archive.texts) members.push_back({text_entry(name), text});
  std::uint64_t size = 0;
  for (const auto& [name, record] : archive.records) {
    kept.push_back(encode_npy(record.type, record.shape, record.data));
    members.push_back({record_entry(name), kept.back()});
  }
  for (const auto& member : members) size += member.content.size();
  std::string bytes = internal::encode_zip(members, deflate, "encode_model_archive");
  // What would be refused as a bomb (records of zeros) is not packed.
  if (size <= unpacked_limit(bytes.size())) return bytes;
  return internal::encode_zip(members, false, "encode_model_archive");
}

void write_model_archive(const std::filesystem::path& path, const ModelArchive& archive,
                         bool deflate) {
  write_file(path, encode_model_archive(archive, deflate));
}

ModelArchive parse_model_archive(std::string_view bytes, const std::string& name) {
  ModelEntries entries(bytes, name);
  if (!entries.has(kManifest)) {
    fail(name, std::string("expected an Arbox model, got a zip archive without ") + kManifest);
  }
  Manifest manifest = parse_manifest(entries.take(kManifest), entries.place(kManifest));
  ModelArchive archive{.kind = std::move(manifest.kind), .classes = std::move(manifest.classes)};
  if (entries.has(kConfiguration)) archive.configuration = entries.take(kConfiguration);
  if (entries.has(kCalibrationMember)) archive.calibration = entries.take(kCalibrationMember);
  if (entries.has(kCard)) archive.card = entries.take(kCard);
  for (const std::string& text : manifest.texts) {
    archive.texts[text] = entries.take(text_entry(text));
  }
  for (const std::string& record : manifest.records) {
    const std::string entry = record_entry(record);
    archive.records[record] = parse_record(entries.take(entry), entries.place(entry));
  }
  entries.require_all_taken();
  return archive;
}

ModelArchive read_model_archive(const std::filesystem::path& path) {
  return parse_model_archive(read_file(path), path.string());
}

bool is_model_archive(std::string_view bytes) {
  constexpr std::size_t kNameOffset = 30;  // In the header before the first entry of a zip file.
  return bytes.starts_with("PK\3\4") && bytes.size() > kNameOffset &&
         bytes.substr(kNameOffset).starts_with(kManifest);
}

}  // namespace arbox::io
