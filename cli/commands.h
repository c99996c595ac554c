#pragma once

#include <CLI/App.hpp>

/// \file
/// The commands of the `arbox` program, one source file each. A command adds its subcommand with
/// flags and examples (cli/command_line.h); its callback does the work, prints results on standard
/// output and lets exceptions out: run_program turns them into one line on standard error and an
/// exit code (0 done, 1 failed, 2 wrong usage).

namespace arbox::cli {

void add_benchmark(CLI::App& app);
void add_calibrate(CLI::App& app);
void add_config(CLI::App& app);
void add_convert(CLI::App& app);
void add_import(CLI::App& app);
void add_info(CLI::App& app);
void add_init(CLI::App& app);
void add_nms(CLI::App& app);
void add_overlap(CLI::App& app);
void add_detect(CLI::App& app);
void add_pack(CLI::App& app);
void add_quantile_box(CLI::App& app);
void add_evaluate(CLI::App& app);
void add_plugins(CLI::App& app);
void add_simulate(CLI::App& app);
void add_train(CLI::App& app);
void add_view(CLI::App& app);
void add_watch(CLI::App& app);

/// Adds `boxes` to the command `evaluate`.
void add_evaluate_boxes(CLI::App& evaluate);

/// Adds `uncertainty` to the command `evaluate`.
void add_evaluate_uncertainty(CLI::App& evaluate);

/// Adds `kitti` to the command `info`.
void add_info_kitti(CLI::App& info);

/// Adds `fit-bins` to the command `config`.
void add_fit_bins(CLI::App& config);

}  // namespace arbox::cli
