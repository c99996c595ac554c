#include "count_tables.h"

#include <cstdio>
#include <utility>

namespace arbox::benchmarks {
namespace {

constexpr double kDistances[] = {5, 10, 15, 20, 30, 40, 50, 80};
constexpr int kRows = 7;
/// Firings of a beam in a turn of the scanner (lidar_model.h).
constexpr double kFirings = 2156.4;

/// Shares of the firings that gave no return; real scans have them outside of the own vehicle's
/// blind spots too.
void print_lost(const std::vector<ScanFigures>& real, const std::vector<ScanFigures>& simulated) {
  std::printf(
      "\n| firings without return, rings from the top | real | simulated |\n|---|---|---|\n");
  for (int first = 0; first < 64; first += 8) {
    std::printf("| %d to %d |", first, first + 7);
    for (const auto* scans : {&real, &simulated}) {
      double returns = 0;
      for (const ScanFigures& scan : *scans) {
        for (int ring = first; ring < first + 8; ++ring) {
          returns += scan.ring[static_cast<std::size_t>(ring)];
        }
      }
      std::printf(" %.3f |", 1 - returns / (8 * kFirings * static_cast<double>(scans->size())));
    }
    std::printf("\n");
  }
}

}  // namespace

void print_counts(const std::vector<ScanFigures>& real, const std::vector<ScanFigures>& simulated) {
  std::printf("\n| quantity | real 10/50/90 %% | simulated 10/50/90 %% |\n|---|---|---|\n");
  for (const auto& [name, member] : {std::pair{"points a scan", &ScanFigures::points},
                                     std::pair{"points in the image", &ScanFigures::in_image}}) {
    std::printf("| %s |", name);
    for (const auto* scans : {&real, &simulated}) {
      std::vector<double> values;
      for (const ScanFigures& scan : *scans) values.push_back(scan.*member);
      std::printf(" %.0f / %.0f / %.0f |", quantile(values, .1), quantile(values, .5),
                  quantile(values, .9));
    }
    std::printf("\n");
  }
  for (const char* type : {"Car", "Pedestrian", "Cyclist"}) {
    for (int row = 0; row < kRows; ++row) {
      std::printf("| points, %s, %.0f-%.0f m, occlusion 0 |", type, kDistances[row],
                  kDistances[row + 1]);
      for (const auto* scans : {&real, &simulated}) {
        std::vector<double> values;
        for (const ScanFigures& scan : *scans) {
          for (const ObjectFigures& object : scan.objects) {
            if (object.type == type && object.clear() && object.distance >= kDistances[row] &&
                object.distance < kDistances[row + 1]) {
              values.push_back(object.points);
            }
          }
        }
        if (values.empty()) {
          std::printf(" - |");
        } else {
          std::printf(" %.0f / %.0f / %.0f (n=%zu) |", quantile(values, .1), quantile(values, .5),
                      quantile(values, .9), values.size());
        }
      }
      std::printf("\n");
    }
  }
  print_lost(real, simulated);
}

}  // namespace arbox::benchmarks
