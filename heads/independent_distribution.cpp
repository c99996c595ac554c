#include "arbox/heads/independent_distribution.h"

#include <ATen/ops/zeros.h>

#include <algorithm>
#include <string>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/heads/internal/component_math.h"

namespace arbox::heads {

using at::Tensor;

IndependentDistribution::IndependentDistribution(std::shared_ptr<const BoxCodec> codec,
                                                 const References& references)
    : codec_(std::move(codec)), references_(references.detached()) {}

bool IndependentDistribution::is_known(int component) const {
  if (!sizes_.defined()) return false;
  const auto fixed = codec_->size_components();
  return std::find(fixed.begin(), fixed.end(), component) != fixed.end();
}

Tensor IndependentDistribution::with_known(const Tensor& values) const {
  return sizes_.defined() ? internal::with_sizes(values, *codec_, sizes_) : values;
}

Tensor IndependentDistribution::of_known(const Tensor& values, const Tensor& mask) const {
  return sizes_.defined() ? internal::of_sizes(values, mask, *codec_, sizes_) : mask;
}

std::unique_ptr<BoxDistribution> IndependentDistribution::select(const Tensor& index) const {
  auto result = clone();
  result->references_ = references_.select(index);
  if (sizes_.defined()) result->sizes_ = sizes_.index_select(0, index);
  result->keep_rows(index);
  return result;
}

Tensor IndependentDistribution::values_of(const Tensor& sizes, const char* where) const {
  if (codec_->size_components().size() != 3) {
    throw NotAvailable(std::string(where) + ": this codec does not describe all three sizes");
  }
  require_sizes(sizes, size());
  return internal::size_values(sizes, *codec_, references_);
}

std::unique_ptr<BoxDistribution> IndependentDistribution::given_sizes(const Tensor& sizes) const {
  auto result = clone();
  result->sizes_ = values_of(sizes, "given_sizes");
  return result;
}

Tensor IndependentDistribution::log_size_density(const Tensor& sizes) const {
  const Tensor known = values_of(sizes, "log_size_density");
  const Tensor values = at::zeros({size(), 1, std::ssize(codec_->components())}, known.options());
  return density_of(internal::with_sizes(values, *codec_, known), codec_->size_components());
}

}  // namespace arbox::heads
