#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/evaluation/indoor_protocol.h"

/// \file
/// Truth and predictions of scenes from files.

namespace arbox::evaluation {

/// Reads truth and predictions, each in the form that its path shows:
///
/// - a file `.json` or `.jsonl`: detections of many scenes (io/detection_json.h); a scene's name is
///   the file name of its source, without folders and extension;
/// - a folder of such files; a scene without a source takes the file's name;
/// - a folder of box tables `.csv` (io/box_table.h), one a scene, named as the file, with a header
///   that has the column `class` and, for predictions, `score`;
/// - a folder of the text that VoteNet's evaluation writes (read_votenet_boxes); truth and
///   predictions may share it.
///
/// Every scene of the truth needs predictions, if only an empty list, and every prediction's scene
/// truth. Scenes come sorted by name. Throws IoError for missing paths, folders without such files
/// or with several kinds, FormatError for what the readers refuse, missing columns or classes, and
/// scenes that stand twice or on one side only.
/// `classes` names the numbers that VoteNet's files have in place of names. `read` is called once a
/// file.
std::vector<IndoorScene> read_indoor_scenes(const std::filesystem::path& truth,
                                            const std::filesystem::path& predictions,
                                            const std::vector<std::string>& classes = {},
                                            const std::function<void()>& read = {});

/// How many files read_indoor_scenes would read. Throws IoError as it does.
std::int64_t count_indoor_files(const std::filesystem::path& truth,
                                const std::filesystem::path& predictions);

/// Reads SCENE_gt_map_cls.txt (with_scores false) or SCENE_pred_map_cls.txt (true).
///
/// A line is `CLASS x,y,z,...` with 8 corners in the upright camera frame (x right, y down,
/// z forward, metres), then the score if with_scores. CLASS is a number, the place of a name in
/// `classes`; with no names given the label is the number itself. Boxes come out with z up: x
/// stays, y is the camera's z, z is minus the camera's y. The edge from corner 2 to corner 1 is the
/// box's own x axis (length), 1 to 0 its width, 0 to 4 its height; so the yaw is VoteNet's heading
/// with its sign turned.
///
/// Throws FormatError with file and line for anything else than such lines, corners that are not
/// those of an upright box, and a class number without a name.
std::vector<LabeledBox> read_votenet_boxes(const std::filesystem::path& file, bool with_scores,
                                           const std::vector<std::string>& classes = {});

/// read_votenet_boxes of a text in memory; `source` is its name in messages.
std::vector<LabeledBox> parse_votenet_boxes(std::string_view text, std::string_view source,
                                            bool with_scores,
                                            const std::vector<std::string>& classes = {});

}  // namespace arbox::evaluation
