#include <algorithm>
#include <cmath>
#include <cstring>

#include "arbox/io/internal/columns.h"
#include "arbox/io/internal/parse.h"

// A .bin file is float32 rows and says nothing else.

namespace arbox::io::internal {
namespace {

constexpr std::size_t kFewest = 3, kMost = 6, kUsual = 4;

float number(std::string_view content, std::size_t i) {
  float value;
  std::memcpy(&value, content.data() + i * sizeof(float), sizeof value);
  return value;
}

bool is_byte(float value) { return value >= 0.0F && value <= 255.0F && value == std::floor(value); }

// True if every row's numbers in [first, width) are whole numbers of 0..255, not all zero: what
// laser rings and colours look like and nothing else does.
bool ends_in_bytes(std::string_view content, std::size_t width, std::size_t first) {
  const std::size_t count = content.size() / sizeof(float);
  bool any = false;
  for (std::size_t row = 0; row < count; row += width) {
    for (std::size_t c = first; c < width; ++c) {
      const float value = number(content, row + c);
      if (!is_byte(value)) return false;
      any = any || value != 0.0F;
    }
  }
  return any;
}

// Reflectance is not negative; a tenth of the rows is more than noise.
bool fourth_is_no_intensity(std::string_view content) {
  const std::size_t rows = content.size() / (kUsual * sizeof(float));
  std::size_t negative = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    if (!(number(content, kUsual * i + 3) >= 0.0F)) ++negative;
  }
  return negative * 10 > rows;
}

[[noreturn]] void refuse_ambiguous(const std::string& name, std::size_t size,
                                   const std::vector<std::size_t>& candidates,
                                   const std::string& reason) {
  std::vector<std::string> words;
  for (const std::size_t width : candidates) words.push_back(std::to_string(width));
  fail(name, "the number of columns is not certain: " + std::to_string(size) +
                 " bytes are whole rows of " + listed(words, " or ") + " float32" + reason +
                 "; say which with the option channels");
}

std::size_t columns_of(std::string_view content, const std::string& name) {
  std::vector<std::size_t> candidates;
  for (std::size_t width = kFewest; width <= kMost; ++width) {
    if (content.size() % (width * sizeof(float)) == 0) candidates.push_back(width);
  }
  const auto fits = [&](std::size_t width) {
    return std::find(candidates.begin(), candidates.end(), width) != candidates.end();
  };
  if (candidates.empty()) {
    fail(name, "expected rows of 3, 4, 5 or 6 float32, got " + std::to_string(content.size()) +
                   " bytes, which are whole rows of none (truncated?)");
  }
  if (candidates.size() == 1) return candidates.front();
  if (!fits(kUsual)) refuse_ambiguous(name, content.size(), candidates, "");
  if (fits(6) && ends_in_bytes(content, 6, 3)) {
    refuse_ambiguous(name, content.size(), candidates,
                     ", and the last three of six look like colours");
  }
  if (fits(5) && ends_in_bytes(content, 5, 4)) {
    refuse_ambiguous(name, content.size(), candidates, ", and the last of five looks like a ring");
  }
  if (fourth_is_no_intensity(content)) {
    refuse_ambiguous(name, content.size(), candidates,
                     ", and the last of four is often negative, so no intensity");
  }
  return kUsual;
}

}  // namespace

PointCloudFile parse_bin(std::string_view content, const std::string& name,
                         const ReadOptions& options) {
  PointCloudFile file{.format = PointCloudFormat::kBin, .encoding = "float32"};
  const std::size_t asked = columns_asked(options);
  if (content.empty()) fail(name, "expected rows of float32, got an empty file");
  const std::size_t width = asked > 0 ? asked : columns_of(content, name);
  const std::size_t row_bytes = width * sizeof(float);
  if (content.size() % row_bytes != 0) {
    fail(name, "expected rows of " + std::to_string(width) + " float32 (" +
                   std::to_string(row_bytes) + " bytes), got " + std::to_string(content.size()) +
                   " bytes; the last row starts at byte " +
                   std::to_string(content.size() / row_bytes * row_bytes));
  }
  file.points_in_file = file.width = content.size() / row_bytes;
  std::vector<Column> columns(width);
  for (std::size_t c = 0; c < width; ++c) {
    columns[c].data = reinterpret_cast<const std::byte*>(content.data()) + c * sizeof(float);
    columns[c].stride = row_bytes;
  }
  const auto names =
      column_names(width, has_negative_tail(columns, file.points_in_file), name, options);
  for (std::size_t c = 0; c < width; ++c) columns[c].name = names[c];
  return assemble(std::move(columns), std::move(file), name, options);
}

}  // namespace arbox::io::internal
