// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/temporal_prior.hpp"

#include <utility>

#include "volute/tomography/vector_ops.hpp"

namespace volute {
namespace {

class TemporalPrior final : public Prior {
 public:
  TemporalPrior(std::unique_ptr<Prior> other, double strength, std::vector<float> expected)
      : other_(std::move(other)), strength_(strength), expected_(std::move(expected)) {}

  void proximal(std::span<float> a, std::span<const float> step) override {
    other_->proximal(a, step);
  }

  bool takesSteps() const override { return other_->takesSteps(); }

  void addGradient(std::span<const float> a, std::span<float> gradient) const override {
    other_->addGradient(a, gradient);
    const auto strength = static_cast<float>(strength_);
    forElements(a.size(), [&](std::size_t i) { gradient[i] += strength * (a[i] - expected_[i]); });
  }

  double curvature() const override { return other_->curvature() + strength_; }

 private:
  std::unique_ptr<Prior> other_;
  double strength_;
  std::vector<float> expected_;
};

}  // namespace

std::unique_ptr<Prior> makeTemporalPrior(std::unique_ptr<Prior> other, double strength,
                                         std::vector<float> expected) {
  return std::make_unique<TemporalPrior>(std::move(other), strength, std::move(expected));
}

}  // namespace volute
