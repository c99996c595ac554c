#include "arbox/io/point_cloud_file.h"

#include <algorithm>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/columns.h"
#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/point_cloud_format.h"
#include "arbox/io/internal/text.h"

namespace arbox::io {
namespace {

constexpr std::pair<std::string_view, PointCloudFormat> kExtensions[] = {
    {".pcd", PointCloudFormat::kPcd},   {".ply", PointCloudFormat::kPly},
    {".bin", PointCloudFormat::kBin},   {".npy", PointCloudFormat::kNpy},
    {".npz", PointCloudFormat::kNpz},   {".csv", PointCloudFormat::kText},
    {".tsv", PointCloudFormat::kText},  {".txt", PointCloudFormat::kText},
    {".xyz", PointCloudFormat::kText},  {".xyzrgb", PointCloudFormat::kText},
    {".xyzn", PointCloudFormat::kText}, {".pts", PointCloudFormat::kText},
    {".asc", PointCloudFormat::kText},
};

// A PCD may start with comments; its first other line is one of three.
bool looks_like_pcd(std::string_view content) {
  internal::LineReader lines(content, "");
  while (lines.next()) {
    const std::string_view line = internal::trimmed(lines.line());
    if (line.starts_with("# .PCD")) return true;
    if (line.empty() || line.front() == '#') continue;
    return line.starts_with("VERSION ") || line.starts_with("FIELDS ") ||
           line.starts_with("COLUMNS ");
  }
  return false;
}

bool looks_like_text(std::string_view content) {
  return std::all_of(content.begin(), content.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x20 || (byte >= '\t' && byte <= '\r');
  });
}

PointCloudFormat format_of_content(std::string_view content, const std::string& name) {
  constexpr std::size_t kLook = 4096;
  const std::string_view head = content.substr(0, kLook);
  if (head.starts_with("\x93NUMPY")) return PointCloudFormat::kNpy;
  if (head.starts_with("PK\3\4")) return PointCloudFormat::kNpz;
  if (head.starts_with("ply\n") || head.starts_with("ply\r\n")) return PointCloudFormat::kPly;
  if (looks_like_pcd(head)) return PointCloudFormat::kPcd;
  if (const auto format = format_of_extension(name)) return *format;
  if (content.empty()) internal::fail(name, "expected a point cloud, got an empty file");
  if (looks_like_text(head)) return PointCloudFormat::kText;
  internal::fail(name, "expected a point cloud (PCD, PLY, .bin, .npy, .npz or text); neither the " +
                           std::string("content nor the extension tells which; first bytes ") +
                           internal::quoted_text(content.substr(0, 8)));
}

}  // namespace

std::string_view name_of(PointCloudFormat format) {
  constexpr std::string_view kNames[] = {"pcd", "ply", "bin", "npy", "npz", "text"};
  return kNames[static_cast<int>(format)];
}

std::optional<PointCloudFormat> format_of_extension(const std::filesystem::path& path) {
  const std::string extension = internal::lower(path.extension().string());
  for (const auto& [known, format] : kExtensions) {
    if (known == extension) return format;
  }
  return std::nullopt;
}

PointCloudFormat internal::format_named(const std::string& word) {
  constexpr PointCloudFormat kAll[] = {PointCloudFormat::kPcd, PointCloudFormat::kPly,
                                       PointCloudFormat::kBin, PointCloudFormat::kNpy,
                                       PointCloudFormat::kNpz, PointCloudFormat::kText};
  for (const PointCloudFormat format : kAll) {
    if (name_of(format) == word) return format;
  }
  throw InvalidArgument("format: expected pcd, ply, bin, npy, npz or text, got " +
                        quoted_text(word));
}

PointCloudFile parse_point_cloud(std::string_view content, const std::string& name,
                                 const ReadOptions& options) {
  const PointCloudFormat format = options.format.empty() ? format_of_content(content, name)
                                                         : internal::format_named(options.format);
  switch (format) {
    case PointCloudFormat::kPcd:
      return internal::parse_pcd(content, name, options);
    case PointCloudFormat::kPly:
      return internal::parse_ply(content, name, options);
    case PointCloudFormat::kBin:
      return internal::parse_bin(content, name, options);
    case PointCloudFormat::kNpy:
      return internal::parse_npy_cloud(content, name, options);
    case PointCloudFormat::kNpz:
      return internal::parse_npz_cloud(content, name, options);
    case PointCloudFormat::kText:
      return internal::parse_text_cloud(content, name, options);
  }
  throw InvalidArgument("parse_point_cloud: unknown format");
}

PointCloudFile read_point_cloud(const std::filesystem::path& path, const ReadOptions& options) {
  return parse_point_cloud(read_file(path), path.string(), options);
}

std::vector<std::filesystem::path> list_point_clouds(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> paths;
  std::filesystem::directory_iterator entries(folder, error);
  if (error) throw IoError(folder.string() + ": cannot be listed: " + error.message());
  for (const auto& entry : entries) {
    const auto& path = entry.path();
    if (format_of_extension(path) && internal::lower(path.extension().string()) != ".txt" &&
        !entry.is_directory(error)) {
      paths.push_back(path);
    }
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace arbox::io
