#include "arbox/io/internal/pcd_header.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>

#include "arbox/io/internal/columns.h"
#include "arbox/io/internal/parse.h"

namespace arbox::io::internal {
namespace {

struct Entry {
  std::vector<std::string_view> words;
  TextPlace place;
};

using Entries = std::map<std::string, Entry, std::less<>>;

Entries read_entries(LineReader& lines) {
  Entries entries;
  while (lines.next()) {
    const auto words = split_white_space(lines.line());
    if (words.empty() || words[0].front() == '#') continue;
    std::string key(words[0] == "COLUMNS" ? "FIELDS" : words[0]);
    static constexpr std::string_view kKeys[] = {"VERSION", "FIELDS", "SIZE",   "TYPE",
                                                 "COUNT",   "WIDTH",  "HEIGHT", "VIEWPOINT",
                                                 "POINTS",  "DATA"};
    if (std::find(std::begin(kKeys), std::end(kKeys), key) == std::end(kKeys)) {
      refuse(lines.place(), "a PCD header line (VERSION, FIELDS, ..., DATA)",
             quoted_text(words[0]));
    }
    if (entries.contains(key)) refuse(lines.place(), key + " once", "it a second time");
    const bool last = key == "DATA";
    entries[std::move(key)] = {{words.begin() + 1, words.end()}, lines.place()};
    if (last) return entries;
  }
  refuse(lines.place(), "a PCD header that ends with DATA", "the end of the file");
}

const Entry& required(const Entries& entries, const std::string& key, const TextPlace& end) {
  const auto found = entries.find(key);
  if (found == entries.end()) refuse(end, "a header line " + key + " before DATA", "none");
  return found->second;
}

std::size_t whole(const Entry& entry, std::size_t i, const std::string& key) {
  std::size_t value = 0;
  if (i >= entry.words.size() || !to_number(entry.words[i], value)) {
    refuse(entry.place, "a whole number as " + key,
           i < entry.words.size() ? quoted_text(entry.words[i]) : "nothing");
  }
  return value;
}

std::optional<NumberType> number_type(std::string_view letter, std::size_t size) {
  static constexpr struct {
    char letter;
    std::size_t size;
    NumberType type;
  } kTypes[] = {
      {'F', 4, NumberType::kFloat32}, {'F', 8, NumberType::kFloat64}, {'U', 1, NumberType::kUint8},
      {'U', 2, NumberType::kUint16},  {'U', 4, NumberType::kUint32},  {'U', 8, NumberType::kUint64},
      {'I', 1, NumberType::kInt8},    {'I', 2, NumberType::kInt16},   {'I', 4, NumberType::kInt32},
      {'I', 8, NumberType::kInt64},
  };
  for (const auto& known : kTypes) {
    if (letter.size() == 1 && letter[0] == known.letter && size == known.size) return known.type;
  }
  return std::nullopt;
}

void read_fields(const Entries& entries, const TextPlace& end, PcdHeader& header) {
  const Entry& names = required(entries, "FIELDS", end);
  const Entry& sizes = required(entries, "SIZE", end);
  const Entry& types = required(entries, "TYPE", end);
  const auto counts = entries.find("COUNT");
  const auto require_one_each = [&](const Entry& entry, const std::string& key) {
    if (entry.words.size() == names.words.size()) return;
    refuse(entry.place,
           std::to_string(names.words.size()) + " words after " + key + " (one a field)",
           std::to_string(entry.words.size()));
  };
  require_one_each(sizes, "SIZE");
  require_one_each(types, "TYPE");
  if (counts != entries.end()) require_one_each(counts->second, "COUNT");
  for (std::size_t i = 0; i < names.words.size(); ++i) {
    PcdField field{.name = std::string(names.words[i]), .offset = header.stride};
    const std::size_t size = whole(sizes, i, "SIZE");
    const auto type = number_type(types.words[i], size);
    if (!type) {
      refuse(types.place, "types F (size 4, 8), I or U (size 1, 2, 4, 8)",
             quoted_text(types.words[i]) + " of size " + std::to_string(size));
    }
    field.type = *type;
    if (counts != entries.end()) field.count = whole(counts->second, i, "COUNT");
    if (field.count > kMostColumns - header.numbers) {
      refuse(counts != entries.end() ? counts->second.place : names.place,
             "at most " + std::to_string(kMostColumns) + " numbers a point", "more");
    }
    header.numbers += field.count;
    header.stride += field.count * size;
    header.fields.push_back(std::move(field));
  }
}

void read_size(const Entries& entries, const TextPlace& end, PcdHeader& header) {
  const auto points = entries.find("POINTS");
  const auto height = entries.find("HEIGHT");
  if (points != entries.end() && !entries.contains("WIDTH")) {
    header.width = whole(points->second, 0, "POINTS");
  } else {
    header.width = whole(required(entries, "WIDTH", end), 0, "WIDTH");
  }
  if (height != entries.end()) header.height = whole(height->second, 0, "HEIGHT");
  if (header.height > 0 && header.width > std::numeric_limits<std::size_t>::max() / header.height) {
    refuse(end, "WIDTH times HEIGHT points", "a product above 2^64");
  }
  header.points = header.width * header.height;
  if (points == entries.end()) return;
  const std::size_t said = whole(points->second, 0, "POINTS");
  if (said != header.points) {
    refuse(points->second.place,
           "POINTS to be WIDTH times HEIGHT, " + std::to_string(header.points),
           std::to_string(said));
  }
}

}  // namespace

PcdHeader parse_pcd_header(LineReader& lines) {
  const Entries entries = read_entries(lines);
  const TextPlace end = lines.place();
  PcdHeader header;
  read_fields(entries, end, header);
  read_size(entries, end, header);
  if (const auto found = entries.find("VIEWPOINT"); found != entries.end()) {
    const Entry& entry = found->second;
    if (entry.words.size() != header.viewpoint.size()) {
      refuse(entry.place, "7 numbers after VIEWPOINT", std::to_string(entry.words.size()));
    }
    for (std::size_t i = 0; i < header.viewpoint.size(); ++i) {
      header.viewpoint[i] = parse_number(entry.words[i], "VIEWPOINT", entry.place);
    }
  }
  const Entry& data = entries.find("DATA")->second;
  header.data = data.words.empty() ? "" : std::string(data.words[0]);
  if (header.data != "ascii" && header.data != "binary" && header.data != "binary_compressed") {
    refuse(data.place, "DATA ascii, binary or binary_compressed", quoted_text(header.data));
  }
  return header;
}

}  // namespace arbox::io::internal
