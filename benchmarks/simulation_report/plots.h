#pragma once

#include "label_figures.h"
#include "scan_figures.h"

namespace arbox::benchmarks {

/// Range, ring, intensity and azimuth of returns.
void draw_scans(const std::vector<ScanFigures>& real, const std::vector<ScanFigures>& simulated,
                const std::filesystem::path& file);
/// Points an object by distance for each class, and the shape of the ground.
void draw_objects(const std::vector<ScanFigures>& real, const std::vector<ScanFigures>& simulated,
                  const std::filesystem::path& file);
/// Counts, distances, headings, occlusion and truncation of labels.
void draw_labels(const LabelFigures& real, const LabelFigures& simulated,
                 const std::filesystem::path& file);

}  // namespace arbox::benchmarks
