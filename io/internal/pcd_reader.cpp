#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>

#include "arbox/io/internal/columns.h"
#include "arbox/io/internal/lzf.h"
#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/pcd_header.h"
#include "arbox/io/internal/record_text.h"

namespace arbox::io::internal {
namespace {

// Uninitialised on purpose: every byte is written before it is read.
using Buffer = std::unique_ptr<std::byte[]>;

// Room for one point at least, so that columns of an empty cloud point into it.
Buffer allocated(const PcdHeader& header, std::size_t bytes) {
  return std::make_unique_for_overwrite<std::byte[]>(std::max(bytes, header.stride));
}

std::string field_name(const PcdField& field, std::size_t i) {
  return field.count == 1 || field.name == "_" ? field.name : field.name + "_" + std::to_string(i);
}

// Adds the columns of a field whose numbers for point i start at data + i * stride.
void add_columns(const PcdField& field, const std::byte* data, std::size_t stride,
                 std::vector<Column>& columns) {
  const bool packed_color =
      (field.name == "rgb" || field.name == "rgba") && field.count == 1 && size_of(field.type) == 4;
  if (packed_color) {
    constexpr std::pair<const char*, std::size_t> kBytes[] = {{"r", 2}, {"g", 1}, {"b", 0}};
    for (const auto& [name, offset] : kBytes) {
      columns.push_back({name, NumberType::kUint8, data + offset, stride});
    }
    return;
  }
  const std::size_t size = size_of(field.type);
  for (std::size_t i = 0; i < field.count; ++i) {
    columns.push_back({field_name(field, i), field.type, data + i * size, stride});
  }
}

std::vector<Column> record_columns(const PcdHeader& header, const std::byte* records) {
  std::vector<Column> columns;
  for (const PcdField& field : header.fields) {
    add_columns(field, records + field.offset, header.stride, columns);
  }
  return columns;
}

std::vector<Column> block_columns(const PcdHeader& header, const std::byte* blocks) {
  std::vector<Column> columns;
  for (const PcdField& field : header.fields) {
    add_columns(field, blocks + field.offset * header.points, field.count * size_of(field.type),
                columns);
  }
  return columns;
}

std::size_t body_bytes(const PcdHeader& header, const std::string& name) {
  if (header.stride > 0 &&
      header.points > std::numeric_limits<std::size_t>::max() / header.stride) {
    fail(name, "the header claims " + std::to_string(header.points) + " points of " +
                   std::to_string(header.stride) + " bytes, more than 2^64 bytes");
  }
  return header.points * header.stride;
}

Buffer parse_records(const PcdHeader& header, LineReader& lines, const std::string& name) {
  // The shortest line is a digit and a blank a number.
  const std::size_t most = lines.rest().size() / (2 * std::max<std::size_t>(header.numbers, 1)) + 1;
  if (header.points > most) {
    fail(name, "the header claims " + std::to_string(header.points) + " points, but " +
                   std::to_string(lines.rest().size()) + " bytes of text hold at most " +
                   std::to_string(most));
  }
  std::vector<RecordElement> elements;
  for (const PcdField& field : header.fields) {
    for (std::size_t i = 0; i < field.count; ++i) {
      elements.push_back(
          {field_name(field, i), field.type, field.offset + i * size_of(field.type)});
    }
  }
  auto records = allocated(header, body_bytes(header, name));
  std::size_t count = 0;
  while (lines.next_filled()) {
    if (count == header.points) {
      refuse(lines.place(), std::to_string(header.points) + " points as the header says", "more");
    }
    store_line(lines.line(), elements, records.get() + count * header.stride, lines.place());
    ++count;
  }
  if (count < header.points) {
    refuse(lines.place(), std::to_string(header.points) + " points as the header says",
           std::to_string(count) + " before the end of the file");
  }
  return records;
}

Buffer decompress(const PcdHeader& header, std::string_view body, std::size_t offset,
                  const std::string& name, std::size_t& used) {
  constexpr std::size_t kSizes = 2 * sizeof(std::uint32_t);
  const std::size_t wanted = body_bytes(header, name);
  used = 0;
  if (header.points == 0 && body.size() < kSizes) return allocated(header, 0);
  if (body.size() < kSizes) {
    fail_at_byte(name, offset,
                 "expected 8 bytes with the compressed and the uncompressed size, got " +
                     std::to_string(body.size()));
  }
  std::uint32_t compressed = 0, uncompressed = 0;
  std::memcpy(&compressed, body.data(), sizeof compressed);
  std::memcpy(&uncompressed, body.data() + sizeof compressed, sizeof uncompressed);
  if (compressed > body.size() - kSizes) {
    fail_at_byte(name, offset,
                 "expected " + std::to_string(compressed) + " bytes of compressed data, got " +
                     std::to_string(body.size() - kSizes));
  }
  if (uncompressed != wanted) {
    fail_at_byte(name, offset + sizeof compressed,
                 "expected " + std::to_string(wanted) + " uncompressed bytes for " +
                     std::to_string(header.points) + " points, got " +
                     std::to_string(uncompressed));
  }
  if (wanted / kLzfHighestRatio > compressed) {
    fail_at_byte(name, offset,
                 std::to_string(compressed) + " bytes of compressed data cannot hold " +
                     std::to_string(wanted));
  }
  auto blocks = allocated(header, wanted);
  if (!lzf_decompress(body.substr(kSizes, compressed), reinterpret_cast<char*>(blocks.get()),
                      wanted)) {
    fail_at_byte(name, offset + kSizes, "the compressed data is damaged");
  }
  used = kSizes + compressed;
  return blocks;
}

}  // namespace

PointCloudFile parse_pcd(std::string_view content, const std::string& name,
                         const ReadOptions& options) {
  require_no_channels(name, options);
  if (content.empty()) fail(name, "expected a PCD file, got an empty file");
  LineReader lines(content, name);
  const PcdHeader header = parse_pcd_header(lines);
  PointCloudFile file{.format = PointCloudFormat::kPcd,
                      .encoding = header.data,
                      .points_in_file = header.points,
                      .width = header.width,
                      .height = header.height,
                      .viewpoint = header.viewpoint};
  const std::string_view body = lines.rest();
  const std::size_t offset = content.size() - body.size();
  std::vector<Column> columns;
  Buffer owned;
  if (header.data == "ascii") {
    owned = parse_records(header, lines, name);
    columns = record_columns(header, owned.get());
  } else if (header.data == "binary") {
    const std::size_t wanted = body_bytes(header, name);
    if (body.size() < wanted) {
      fail_at_byte(name, offset,
                   "expected " + std::to_string(wanted) + " bytes for " +
                       std::to_string(header.points) + " points of " +
                       std::to_string(header.stride) + " bytes, got " +
                       std::to_string(body.size()));
    }
    file.unused_bytes = body.size() - wanted;
    columns = record_columns(header, reinterpret_cast<const std::byte*>(body.data()));
  } else {
    std::size_t used = 0;
    owned = decompress(header, body, offset, name, used);
    file.unused_bytes = body.size() - used;
    columns = block_columns(header, owned.get());
  }
  return assemble(std::move(columns), std::move(file), name, options);
}

}  // namespace arbox::io::internal
