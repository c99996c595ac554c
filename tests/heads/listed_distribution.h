#pragma once

#include <ATen/ops/full.h>
#include <ATen/ops/zeros.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
#include "arbox/heads/box_distribution.h"
#include "arbox/heads/box_tensor.h"

namespace arbox::testing {

struct ListedBox {
  geometry::Box box;
  double probability = 0.0;
};

/// A distribution that lists its boxes, for each object.
class ListedDistribution : public heads::BoxDistribution {
 public:
  explicit ListedDistribution(std::vector<std::vector<ListedBox>> objects,
                              heads::Measure measure = heads::Measure::kDensity)
      : objects_(std::move(objects)), measure_(measure) {}

  std::int64_t size() const override { return std::ssize(objects_); }
  heads::Measure measure() const override { return measure_; }

  heads::Draws mode(const heads::ModeOptions& options) const override {
    auto lists = objects_;
    for (auto& list : lists) {
      std::stable_sort(list.begin(), list.end(), [](const ListedBox& a, const ListedBox& b) {
        return a.probability > b.probability;
      });
    }
    return rows(options.beam_width, [&](std::int64_t object, std::int64_t k) {
      return k < std::ssize(lists[object]) ? &lists[object][k] : nullptr;
    });
  }

  heads::Draws sample(int count, const heads::Streams& streams, double) const override {
    return rows(count, [&](std::int64_t object, std::int64_t k) {
      const RandomStream random(streams.seed, streams.object_ids[object].item<std::int64_t>(), 0);
      double left = random.uniform(static_cast<std::uint32_t>(k));
      const auto& list = objects_[object];
      std::size_t i = 0;
      while (i + 1 < list.size() && left >= list[i].probability) left -= list[i++].probability;
      return &list[i];
    });
  }

  at::Tensor mean() const override { return mode({.beam_width = 1}).boxes.select(1, 0); }
  at::Tensor log_density(const at::Tensor&) const override {
    throw NotAvailable("ListedDistribution has no density of other boxes");
  }
  std::unique_ptr<heads::BoxDistribution> select(const at::Tensor& index) const override {
    std::vector<std::vector<ListedBox>> chosen;
    for (std::int64_t i = 0; i < index.size(0); ++i) {
      chosen.push_back(objects_[index[i].item<std::int64_t>()]);
    }
    return std::make_unique<ListedDistribution>(chosen, measure_);
  }

  std::unique_ptr<heads::BoxDistribution> given_sizes(const at::Tensor& sizes) const override {
    auto lists = objects_;
    for (std::size_t i = 0; i < lists.size(); ++i) {
      const double total = of_size(i, sizes);
      std::erase_if(lists[i], [&](const ListedBox& one) { return !has_size(one, i, sizes); });
      for (ListedBox& one : lists[i]) one.probability /= total;
    }
    return std::make_unique<ListedDistribution>(lists, measure_);
  }

  at::Tensor log_size_density(const at::Tensor& sizes) const override {
    at::Tensor result = at::zeros({size()}, at::kDouble);
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      result.data_ptr<double>()[i] = std::log(of_size(i, sizes));
    }
    return result;
  }

 private:
  static bool has_size(const ListedBox& one, std::size_t object, const at::Tensor& sizes) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto size = sizes[static_cast<std::int64_t>(object)][axis].item<double>();
      if (std::abs(one.box.size[axis] - size) > 1e-6) return false;
    }
    return true;
  }

  double of_size(std::size_t object, const at::Tensor& sizes) const {
    double sum = 0.0;
    for (const ListedBox& one : objects_[object]) {
      if (has_size(one, object, sizes)) sum += one.probability;
    }
    return sum;
  }

  template <class At>
  heads::Draws rows(int count, const At& at) const {
    heads::Draws draws;
    draws.boxes = at::full({size(), count, 10}, std::nan(""), at::kDouble);
    draws.log_density =
        at::full({size(), count}, -std::numeric_limits<double>::infinity(), at::kDouble);
    for (std::int64_t object = 0; object < size(); ++object) {
      for (std::int64_t k = 0; k < count; ++k) {
        const ListedBox* one = at(object, k);
        if (one == nullptr) continue;
        draws.boxes[object][k] = heads::to_tensor(std::vector{one->box}, at::kDouble)[0];
        draws.log_density[object][k] = std::log(one->probability);
      }
    }
    return draws;
  }

  std::vector<std::vector<ListedBox>> objects_;
  heads::Measure measure_;
};

}  // namespace arbox::testing
