// Compares simulated street scans with real ones: tables as Markdown on standard output, plots of
// aggregate figures as PNG.
//
//     simulation_report REAL SIMULATED FIGURES [REAL_LABELS]
//
// REAL and SIMULATED are folders in the KITTI object benchmark's layout, FIGURES is a folder for
// the plots, REAL_LABELS a folder of label files for the label statistics (default: REAL's).

#include <cstdio>

#include "car_classifier.h"
#include "count_tables.h"
#include "divergence.h"
#include "label_figures.h"
#include "plots.h"

int main(int argc, char** argv) {
  using namespace arbox::benchmarks;
  if (argc < 4) {
    std::fprintf(stderr, "usage: simulation_report REAL SIMULATED FIGURES [REAL_LABELS]\n");
    return 2;
  }
  const std::filesystem::path real_root = argv[1], simulated_root = argv[2], figures = argv[3];
  const std::vector<ScanFigures> real = read_scans(real_root),
                                 simulated = read_scans(simulated_root);
  const LabelFigures real_labels =
      read_labels(argc > 4 ? argv[4] : real_root / "training" / "label_2");
  const LabelFigures simulated_labels = read_labels(simulated_root / "training" / "label_2");
  std::printf("%zu real and %zu simulated scans\n\n", real.size(), simulated.size());
  print_divergences(real, simulated);
  print_classifier(real, simulated);
  print_counts(real, simulated);
  print_labels(real_labels, simulated_labels);
  std::filesystem::create_directories(figures);
  draw_scans(real, simulated, figures / "simulation_scans.png");
  draw_objects(real, simulated, figures / "simulation_objects.png");
  draw_labels(real_labels, simulated_labels, figures / "simulation_labels.png");
  return 0;
}
