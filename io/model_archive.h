#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/number_type.h"

/// \file
/// A model, or the state of a training run, as one file (.arbox): a zip archive of a manifest,
/// texts and named arrays. docs/formats.md tells every entry. Nothing of a file is ever run.
///
///     io::ModelArchive archive;
///     archive.kind = "pv_rcnn";
///     archive.configuration = options_yaml(options);
///     archive.classes = {"Car", "Pedestrian"};
///     archive.records["backbone_3d.conv_input.0.weight"] = io::make_record<float>(values, shape);
///     io::write_model_archive("car.arbox", archive);
///
/// The archive is also what numpy.load("car.arbox") reads.

namespace arbox::io {

/// A named array of a model.
struct ModelRecord {
  NumberType type = NumberType::kFloat32;
  /// Empty for one number.
  std::vector<std::size_t> shape = {};
  /// The numbers in C order (last index fastest), little-endian: size_of(type) bytes each.
  std::string data = {};

  /// Numbers in the record: the product of the shape.
  std::size_t count() const;

  /// The numbers as T: float, double, int32_t, int64_t, uint8_t or uint32_t. Throws InvalidArgument
  /// for a number that an integer T cannot hold, and if `data` does not fit the shape.
  template <class T>
  std::vector<T> values() const;

  bool operator==(const ModelRecord&) const = default;
};

/// A record of T as above. Throws InvalidArgument if the number of values is not the product of the
/// shape.
template <class T>
ModelRecord make_record(std::span<const T> values, const std::vector<std::size_t>& shape);

/// What a file holds. Only `kind` has to be given.
struct ModelArchive {
  /// What made it and can load it: the name of a detector, "training_checkpoint", ...
  std::string kind = {};
  /// The whole configuration as YAML, among it the codec's component order and ranges.
  std::string configuration = {};
  /// In the order of the network's labels.
  std::vector<std::string> classes = {};
  /// A confidence calibration as JSON (evaluation/confidence_calibration.h); empty if there is
  /// none.
  std::string calibration = {};
  /// For people, in Markdown: what it was trained on, how good it is, what it must not be used for.
  std::string card = {};
  /// Further texts by name.
  std::map<std::string, std::string> texts = {};
  std::map<std::string, ModelRecord> records = {};

  bool operator==(const ModelArchive&) const = default;
};

/// The bytes of a file: equal archives give equal bytes. With `deflate` smaller and slower to write
/// (weights shrink by about a tenth). Throws InvalidArgument, naming the record or text, for: an
/// empty kind; a class that is empty or named twice; names that are not letters, digits, '_', '-',
/// '.' in parts between single '/'; data that do not fit their shape.
std::string encode_model_archive(const ModelArchive& archive, bool deflate = false);

/// Writes them; a reader sees the old file or the new one, never a part. Throws IoError too.
void write_model_archive(const std::filesystem::path& path, const ModelArchive& archive,
                         bool deflate = false);

/// Reads such bytes; `name` begins messages. Names, sizes, shapes and check sums of all entries are
/// checked. Unpacks at most 256 MiB or 64 times the size of the file, whichever is more. Throws
/// FormatError for everything that is not an intact archive of the version that this build knows.
ModelArchive parse_model_archive(std::string_view bytes, const std::string& name);

/// Throws IoError, FormatError.
ModelArchive read_model_archive(const std::filesystem::path& path);

/// True if a file that begins with these bytes (64 are enough) is a model, intact or not.
bool is_model_archive(std::string_view bytes);

}  // namespace arbox::io
