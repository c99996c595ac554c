#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"

namespace {

void add_commands(CLI::App& app) {
  using namespace arbox::cli;
  add_benchmark(app);
  add_calibrate(app);
  add_config(app);
  add_convert(app);
  add_detect(app);
  add_import(app);
  add_info(app);
  add_init(app);
  add_nms(app);
  add_overlap(app);
  add_pack(app);
  add_quantile_box(app);
  add_evaluate(app);
  add_plugins(app);
  add_simulate(app);
  add_train(app);
  add_view(app);
  add_watch(app);
  add_examples(app, {{"arbox detect scan.pcd --view boxes.png", "Boxes as JSON, and a picture"},
                     {"arbox evaluate kitti --labels label_2 --predictions results",
                      "The numbers of the KITTI benchmark"},
                     {"arbox quantile-box --samples ensemble.csv --quantile 0.1",
                      "What the boxes of an ensemble agree on"},
                     {"arbox detect --help", "All about one command, with examples"}});
}

}  // namespace

int main(int argc, char** argv) { return arbox::cli::run_program(argc, argv, add_commands); }
