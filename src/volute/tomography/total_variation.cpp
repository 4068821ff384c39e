// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>

#include "volute/tomography/momentum.hpp"
#include "volute/tomography/prior.hpp"
#include "volute/tomography/variation_kernels.hpp"
#include "volute/tomography/vector_ops.hpp"

namespace volute {
namespace {

/// The proximal step by accelerated projected gradient on its dual (Beck and Teboulle 2009, "Fast
/// gradient-based algorithms for constrained total variation"), with the nuclear norm of each
/// voxel's differences (Rigie and La Riviere 2015, "Joint reconstruction of multi-channel, spectral
/// CT data via constrained total nuclear variation minimization").
class TotalVariation final : public Prior {
 public:
  TotalVariation(std::shared_ptr<const Support> support, double strength, const Sparsity& sparsity,
                 bool nonNegative)
      : support_(std::move(support)),
        strength_(strength),
        sparsity_(sparsity),
        nonNegative_(nonNegative),
        planes_(support_->latticeSize()) {
    planes_.stride = support_->stride();
    std::vector<std::uint8_t> reached(support_->latticeSize());
    for (const std::int32_t node : support_->nodes()) {
      reached[node] = 1;
      for (const std::int32_t step : planes_.stride) reached[node - step] = 1;
    }
    std::int32_t end = 0;  // of the last block
    for (std::size_t node = 0; node < reached.size(); ++node) {
      if (!reached[node])
        continue;
      reached_.push_back(static_cast<std::int32_t>(node));
      if (reached_.back() < end)
        continue;
      planes_.blocks.push_back(reached_.back());
      end = reached_.back() + static_cast<std::int32_t>(VariationPlanes::kBlock);
    }
  }

  void proximal(std::span<float> a, std::span<const float> step) override {
    constexpr int kIterations = 2;  // the dual goes on from the call before
    setSteps(step);
    const auto nodes = support_->nodes();
    forElements(nodes.size(), [&](std::size_t i) {
      for (std::size_t c = 0; c < 3; ++c) planes_.target[c][nodes[i]] = a[4 * i + c];
    });
    planes_.ahead = planes_.dual;
    Momentum momentum;
    for (int k = 0; k < kIterations; ++k) {
      updatePrimal(planes_.ahead);
      const float beta = momentum.next();
      forBlocks([&](std::size_t begin, std::size_t end) { planes_.updateDual(beta, begin, end); });
    }
    updatePrimal(planes_.dual);
    forElements(nodes.size(), [&](std::size_t i) {
      for (std::size_t c = 0; c < 3; ++c) a[4 * i + c] = planes_.primal[c][nodes[i]];
    });
  }

  // Concave, so that it adds nothing to the curvature.
  void addGradient(std::span<const float> a, std::span<float> gradient) const override {
    if (!nonNegative_ || !(sparsity_.strength > 0))
      return;
    const auto scale = static_cast<float>(sparsity_.scale);
    const auto most = static_cast<float>(sparsity_.strength);
    forElements(a.size() / 4, [&](std::size_t i) {
      const float brightest = std::max({a[4 * i], a[4 * i + 1], a[4 * i + 2], 0.0F});
      const float price = most * scale / (scale + brightest);
      for (std::size_t c = 0; c < 3; ++c) gradient[4 * i + c] += price;
    });
  }

 private:
  /// Each dual vector has a rate of its own (Pock and Chambolle 2011, lemma 2), so that one unknown
  /// with a large step does not slow all the others down.
  void setSteps(std::span<const float> step) {
    const auto nodes = support_->nodes();
    const auto strength = static_cast<float>(strength_);
    for (std::size_t i = 0; i < nodes.size(); ++i) planes_.weight[nodes[i]] = step[i] * strength;
    for (const std::int32_t n : reached_) {
      float next = 0;
      for (const std::int32_t stride : planes_.stride)
        next = std::max(next, planes_.weight[n + stride]);
      planes_.rate[n] = 1 / (6 * (planes_.weight[n] + next));
    }
  }

  template <class Body>
  void forBlocks(Body&& body) {
    parallelRanges(planes_.blocks.size(), kVectorBlock / VariationPlanes::kBlock, body);
  }

  /// primal = the constraint's nearest point to target - weight * D' slopes.
  void updatePrimal(const SlopePlanes& slopes) {
    forBlocks([&](std::size_t begin, std::size_t end) {
      planes_.updatePrimal(slopes, nonNegative_, begin, end);
    });
  }

  std::shared_ptr<const Support> support_;
  double strength_;
  Sparsity sparsity_;
  bool nonNegative_;
  std::vector<std::int32_t> reached_;  // nodes with a difference to an unknown
  VariationPlanes planes_;
};

}  // namespace

std::unique_ptr<Prior> makeTotalVariation(std::shared_ptr<const Support> support, double strength,
                                          const Sparsity& sparsity, bool nonNegative) {
  if (!(strength > 0))
    return makeNoPrior(nonNegative);
  return std::make_unique<TotalVariation>(std::move(support), strength, sparsity, nonNegative);
}

}  // namespace volute
