#include "car_classifier.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "arbox/evaluation/ranking.h"
#include "divergence.h"

namespace arbox::benchmarks {
namespace {

struct Sample {
  double distance;
  Eigen::VectorXd features;
};

std::vector<Sample> cars(const Scans& scans) {
  std::vector<Sample> result;
  for (const ScanFigures* scan : scans) {
    for (const ObjectFigures& object : scan->objects) {
      if (object.type == "Car" && object.truncation < 0.1 && object.features.size() > 0) {
        result.push_back({object.distance, object.features});
      }
    }
  }
  return result;
}

/// For each of `wanted` the `count` unused samples whose distance is nearest.
std::vector<Sample> matched(const std::vector<Sample>& wanted, std::vector<Sample> from,
                            int count) {
  std::vector<Sample> result;
  for (int round = 0; round < count; ++round) {
    for (const Sample& one : wanted) {
      if (from.empty()) return result;
      const auto best =
          std::min_element(from.begin(), from.end(), [&](const auto& a, const auto& b) {
            return std::abs(a.distance - one.distance) < std::abs(b.distance - one.distance);
          });
      result.push_back(*best);
      from.erase(best);
    }
  }
  return result;
}

/// Ridge logistic regression on standardised features and their squares; classes weigh the same.
Eigen::VectorXd fit_logistic(const Eigen::MatrixXd& rows, const Eigen::VectorXd& labels) {
  const double positives = labels.sum(), n = static_cast<double>(labels.size());
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(rows.cols());
  for (int step = 0; step < 25; ++step) {
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Identity(rows.cols(), rows.cols());
    Eigen::VectorXd gradient = weights;
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      const double p = 1 / (1 + std::exp(-rows.row(i).dot(weights)));
      const double share = 0.5 * n / (labels[i] > 0.5 ? positives : n - positives);
      gradient += share * (p - labels[i]) * rows.row(i).transpose();
      hessian += share * p * (1 - p) * rows.row(i).transpose() * rows.row(i);
    }
    weights -= hessian.ldlt().solve(gradient);
  }
  return weights;
}

/// Area under the ROC curve of a classifier of the two sets, five-fold cross-validated.
double classifier_auc(const std::vector<Sample>& first, const std::vector<Sample>& second) {
  const auto count = static_cast<Eigen::Index>(first.size() + second.size());
  if (first.size() < 10 || second.size() < 10) return std::nan("");
  const Eigen::Index width = first[0].features.size();
  Eigen::MatrixXd rows(count, 2 * width + 1);
  Eigen::VectorXd labels(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool is_first = k < first.size();
    rows.row(i).head(width) = (is_first ? first[k] : second[k - first.size()]).features;
    labels[i] = is_first;
  }
  for (Eigen::Index j = 0; j < width; ++j) {
    rows.col(j).array() -= rows.col(j).mean();
    rows.col(j) /= std::sqrt(rows.col(j).squaredNorm() / static_cast<double>(count)) + 1e-9;
    rows.col(j) = rows.col(j).cwiseMin(3.0).cwiseMax(-3.0).eval();
    rows.col(width + j) = 0.5 * rows.col(j).cwiseAbs2();
  }
  rows.col(2 * width).setOnes();
  std::vector<double> scores(static_cast<std::size_t>(count));
  std::vector<bool> positive;
  for (Eigen::Index i = 0; i < count; ++i) positive.push_back(labels[i] > 0.5);
  for (int fold = 0; fold < 5; ++fold) {
    std::vector<Eigen::Index> train, test;
    for (Eigen::Index i = 0; i < count; ++i) (i % 5 == fold ? test : train).push_back(i);
    const Eigen::VectorXd weights = fit_logistic(rows(train, Eigen::all), labels(train));
    for (const Eigen::Index i : test) scores[static_cast<std::size_t>(i)] = rows.row(i) * weights;
  }
  return evaluation::roc_auc(scores, positive).value_or(std::nan(""));
}

}  // namespace

void print_classifier(const std::vector<ScanFigures>& real,
                      const std::vector<ScanFigures>& simulated) {
  const std::vector<Sample> wanted = cars(all_of(real));
  const std::vector<Sample> others = matched(wanted, cars(all_of(simulated)), 3);
  std::vector<double> band, draws;
  for (int i = 0; i < 50; ++i) {
    const auto [a, b] = halves(real, static_cast<std::uint64_t>(1000 + i));
    const double auc = classifier_auc(cars(a), cars(b));
    if (std::isfinite(auc)) band.push_back(auc);
    const Scans some = halves(simulated, static_cast<std::uint64_t>(i)).first;
    draws.push_back(classifier_auc(wanted, matched(wanted, cars(some), 3)));
  }
  std::printf(
      "| classifier AUC, %zu real and %zu simulated cars at matched range: median of 50 draws of "
      "the "
      "simulated ones (5..95 %%: %.3f .. %.3f) | %.3f | %.3f .. %.3f | |\n",
      wanted.size(), others.size(), quantile(draws, .05), quantile(draws, .95), quantile(draws, .5),
      quantile(band, 0.05), quantile(band, 0.95));
  std::printf("\n| feature of cars | real 10/50/90 %% | simulated 10/50/90 %% |\n|---|---|---|\n");
  for (Eigen::Index j = 0; j < 9; ++j) {
    std::printf("| %s |", kFeatureNames[j]);
    for (const std::vector<Sample>* set : {&wanted, &others}) {
      std::vector<double> values;
      for (const Sample& sample : *set) values.push_back(sample.features[j]);
      std::printf(" %.2f / %.2f / %.2f |", quantile(values, .1), quantile(values, .5),
                  quantile(values, .9));
    }
    std::printf("\n");
  }
}

}  // namespace arbox::benchmarks
