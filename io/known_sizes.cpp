#include "arbox/io/known_sizes.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "arbox/io/file.h"
#include "arbox/io/internal/box_columns.h"
#include "arbox/io/internal/text.h"

namespace arbox::io {
namespace {

using internal::quoted_text;
using internal::refuse;
using internal::TextPlace;

constexpr std::array<std::string_view, 5> kSizeNames = {"class", "l", "w", "h", "name"};
constexpr std::size_t kRequiredNames = 4;

/// Where each of kSizeNames stands in a row; kSizeNames.size() for a name that the file does not
/// have.
struct SizeColumns {
  std::array<std::size_t, kSizeNames.size()> place;
  std::size_t count = 0;
};

SizeColumns named_columns(const std::vector<std::string_view>& fields, const TextPlace& place) {
  SizeColumns columns{.place = {}, .count = fields.size()};
  columns.place.fill(fields.size());
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string name = internal::unquoted(fields[i]);
    const auto known = std::find(kSizeNames.begin(), kSizeNames.end(), name);
    if (known == kSizeNames.end()) {
      refuse(place, "columns among " + internal::joined(kSizeNames, ", "), quoted_text(name));
    }
    std::size_t& column = columns.place[static_cast<std::size_t>(known - kSizeNames.begin())];
    if (column != fields.size()) refuse(place, "each column once", quoted_text(name) + " twice");
    column = i;
  }
  for (std::size_t i = 0; i < kRequiredNames; ++i) {
    if (columns.place[i] < fields.size()) continue;
    refuse(place, "the columns class, l, w, h", "none for " + quoted_text(kSizeNames[i]));
  }
  return columns;
}

SizeColumns unnamed_columns(std::size_t fields) {
  return {.place = {0, 1, 2, 3, 4},
          .count = fields == kSizeNames.size() ? kSizeNames.size() : kRequiredNames};
}

double extent(std::string_view field, std::string_view name, const TextPlace& place) {
  const double value = internal::parse_number(field, name, place);
  if (value >= kLeastKnownExtent && value <= kMostKnownExtent) return value;
  refuse(place, std::string(name) + " from 0.01 to 100 metres", quoted_text(field));
}

void add_row(const std::vector<std::string_view>& fields, const SizeColumns& columns,
             const TextPlace& place, KnownSizeTable& table) {
  if (fields.size() != columns.count) {
    refuse(place,
           std::to_string(columns.count) + " fields (class l w h" +
               (columns.count > kRequiredNames ? " name)" : ")"),
           std::to_string(fields.size()));
  }
  const std::string label = internal::unquoted(fields[columns.place[0]]);
  if (label.empty()) refuse(place, "the name of a class", "none");
  geometry::KnownSize& known = table.sizes[label].emplace_back();
  for (std::size_t i = 0; i < 3; ++i) {
    known.size[static_cast<Eigen::Index>(i)] =
        extent(fields[columns.place[i + 1]], kSizeNames[i + 1], place);
  }
  if (columns.place[4] < columns.count) known.name = internal::unquoted(fields[columns.place[4]]);
  table.lines.emplace(label, place.line);
}

}  // namespace

KnownSizeTable parse_known_sizes(std::string_view text, std::string_view source) {
  KnownSizeTable table;
  internal::LineReader lines(text, source);
  if (lines.next_filled()) {
    std::string_view first = internal::trimmed(lines.line());
    if (first.starts_with('#')) first.remove_prefix(1);
    const auto fields = internal::split_fields(first);
    const bool header = internal::is_header(fields);
    const SizeColumns columns =
        header ? named_columns(fields, lines.place()) : unnamed_columns(fields.size());
    if (!header) add_row(fields, columns, lines.place(), table);
    while (lines.next_filled()) {
      add_row(internal::split_fields(lines.line()), columns, lines.place(), table);
    }
  }
  if (table.sizes.empty()) refuse({source}, "rows of class, l, w, h", "none");
  return table;
}

KnownSizeTable read_known_sizes(const std::filesystem::path& path) {
  return parse_known_sizes(read_file(path), path.string());
}

}  // namespace arbox::io
