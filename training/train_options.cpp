#include "arbox/training/train_options.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "arbox/base/error.h"
#include "arbox/base/names.h"
#include "arbox/base/options.h"

namespace arbox::training {
namespace {

constexpr std::array<std::string_view, 10> kFree = {"initial",
                                                    "initial_except",
                                                    "max_skipped",
                                                    "validation_interval",
                                                    "checkpoint_interval",
                                                    "checkpoint_seconds",
                                                    "time_limit",
                                                    "threads",
                                                    "loader_threads",
                                                    "process_timeout"};

}  // namespace

std::int64_t total_steps(const TrainOptions& options, std::int64_t scenes) {
  validate_options(options, "train");
  if (options.steps > 0) return options.steps;
  const double steps = std::ceil(options.epochs * static_cast<double>(scenes) /
                                 static_cast<double>(options.batch_size));
  if (steps < 1) throw ConfigError("train: expected steps or epochs above 0, got neither");
  return static_cast<std::int64_t>(steps);
}

void require_resumable(const TrainOptions& begun, const TrainOptions& options) {
  TrainOptions before = begun;
  TrainOptions now = options;
  const BoundOptions old_fields = bind_options(before);
  const BoundOptions new_fields = bind_options(now);
  std::vector<std::string> changes;
  for (std::size_t i = 0; i < old_fields.fields.size(); ++i) {
    const std::string& key = old_fields.fields[i].key;
    if (std::find(kFree.begin(), kFree.end(), key) != kFree.end()) continue;
    const std::string from = option_text(old_fields.fields[i]);
    const std::string to = option_text(new_fields.fields[i]);
    if (from != to) changes.push_back(key + " was " + from + ", is now " + to);
  }
  if (!changes.empty()) {
    throw ConfigError("resume: " + join(changes, "; ") +
                      "; begin a new run, with initial: for its first weights");
  }
}

}  // namespace arbox::training
