#include <algorithm>
#include <optional>

#include "arbox/io/internal/columns.h"
#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/text.h"

// Delimited text: comma, semicolon, or runs of spaces and tabs.

namespace arbox::io::internal {
namespace {

constexpr char kBlanks = ' ';

char delimiter_of(std::string_view line) {
  for (const char delimiter : {';', ','}) {
    if (line.find(delimiter) != std::string_view::npos) return delimiter;
  }
  return kBlanks;
}

// The next field of a line; false at its end. A delimiter at the very end starts no field.
bool next_field(std::string_view& rest, char delimiter, std::string_view& field) {
  if (delimiter == kBlanks) {
    while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
    if (rest.empty()) return false;
    std::size_t end = 0;
    while (end < rest.size() && !is_blank(rest[end])) ++end;
    field = rest.substr(0, end);
    rest.remove_prefix(end);
    return true;
  }
  if (rest.empty()) return false;
  const std::size_t end = rest.find(delimiter);
  field = trimmed(rest.substr(0, end));
  rest = end == std::string_view::npos ? std::string_view() : trimmed(rest.substr(end + 1));
  return true;
}

std::vector<std::string_view> fields_of(std::string_view line, char delimiter) {
  std::vector<std::string_view> fields;
  std::string_view rest = trimmed(line), field;
  while (next_field(rest, delimiter, field)) fields.push_back(field);
  return fields;
}

bool is_comment(std::string_view line) { return line.starts_with('#') || line.starts_with("//"); }

std::vector<std::string> names_of(std::string_view line, char delimiter) {
  std::vector<std::string> names;
  for (std::string_view field : fields_of(line, delimiter)) {
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') {
      field = field.substr(1, field.size() - 2);
    }
    names.emplace_back(field.empty() ? "_" : field);
  }
  return names;
}

bool names_coordinates(const std::vector<std::string>& names) {
  const auto has = [&](std::string_view axis) {
    return std::any_of(names.begin(), names.end(),
                       [&](const std::string& name) { return lower(name) == axis; });
  };
  return has("x") && has("y") && has("z");
}

bool all_numbers(const std::vector<std::string_view>& fields) {
  return std::all_of(fields.begin(), fields.end(), [](std::string_view field) {
    double ignored = 0.0;
    return to_number(field, ignored);
  });
}

class TextCloud {
 public:
  TextCloud(std::string_view content, const std::string& name) : lines_(content, name) {}

  void read() {
    while (lines_.next_filled()) {
      const std::string_view line = trimmed(lines_.line());
      if (is_comment(line)) {
        comment_ = line.substr(std::min(line.find_first_not_of("#/"), line.size()));
      } else if (width_ == 0) {
        first_line(line);
      } else {
        row(line);
      }
    }
    if (announced_ && *announced_ != rows()) {
      refuse(lines_.place(), std::to_string(*announced_) + " points as the first line says",
             std::to_string(rows()));
    }
  }

  std::size_t rows() const { return width_ == 0 ? 0 : values.size() / width_; }
  char delimiter() const { return delimiter_; }
  const std::vector<std::string>& names() const { return names_; }
  std::size_t width() const { return width_; }

  std::vector<double> values;

 private:
  // The first line is a header, a number of points (.pts) or a row.
  void first_line(std::string_view line) {
    delimiter_ = delimiter_of(line);
    const auto fields = fields_of(line, delimiter_);
    std::size_t count = 0;
    if (fields.size() == 1 && !announced_ && to_number(fields[0], count)) {
      announced_ = count;
      return;
    }
    if (fields.size() > kMostColumns) {
      refuse(lines_.place(), "at most " + std::to_string(kMostColumns) + " columns",
             std::to_string(fields.size()));
    }
    if (!all_numbers(fields)) {
      names_ = names_of(line, delimiter_);
      if (!names_coordinates(names_)) {
        refuse(lines_.place(), "a row of numbers or a header that names x, y and z",
               quoted_text(line));
      }
      width_ = names_.size();
      return;
    }
    width_ = fields.size();
    const auto commented = names_of(comment_, delimiter_of(comment_));
    if (commented.size() == width_ && names_coordinates(commented)) names_ = commented;
    row(line);
  }

  void row(std::string_view line) {
    std::string_view field;
    std::size_t count = 0;
    const std::size_t begin = values.size();
    values.resize(begin + width_);
    while (next_field(line, delimiter_, field)) {
      if (count < width_ && !to_number(field, values[begin + count])) {
        refuse(lines_.place(),
               "a number as " +
                   (names_.empty() ? "column " + std::to_string(count + 1) : names_[count]),
               quoted_text(field));
      }
      ++count;
    }
    if (count != width_) {
      refuse(lines_.place(), std::to_string(width_) + " numbers", std::to_string(count));
    }
  }

  LineReader lines_;
  std::string_view comment_;
  std::vector<std::string> names_;
  std::optional<std::size_t> announced_;
  std::size_t width_ = 0;
  char delimiter_ = kBlanks;
};

}  // namespace

PointCloudFile parse_text_cloud(std::string_view content, const std::string& name,
                                const ReadOptions& options) {
  if (content.empty()) fail(name, "expected a text of points, got an empty file");
  TextCloud text(content, name);
  text.read();
  if (text.width() == 0) fail(name, "expected rows of numbers, got none");
  if (!text.names().empty()) require_no_channels(name, options);
  // Columns of a header without rows point into memory too.
  text.values.reserve(text.width());
  std::vector<Column> columns(text.width());
  for (std::size_t c = 0; c < columns.size(); ++c) {
    columns[c].type = NumberType::kFloat64;
    columns[c].data = reinterpret_cast<const std::byte*>(text.values.data() + c);
    columns[c].stride = columns.size() * sizeof(double);
  }
  const auto names =
      !text.names().empty()
          ? text.names()
          : column_names(columns.size(), has_negative_tail(columns, text.rows()), name, options);
  for (std::size_t c = 0; c < columns.size(); ++c) columns[c].name = names[c];
  const char delimiter = text.delimiter();
  return assemble(std::move(columns),
                  {.format = PointCloudFormat::kText,
                   .encoding = delimiter == kBlanks ? "blank-separated"
                               : delimiter == ','   ? "comma-separated"
                                                    : "semicolon-separated",
                   .points_in_file = text.rows(),
                   .width = text.rows()},
                  name, options);
}

}  // namespace arbox::io::internal
