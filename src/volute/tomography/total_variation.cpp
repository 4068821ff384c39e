// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <array>
#include <cmath>

#include "volute/tomography/lattice_field.hpp"
#include "volute/tomography/momentum.hpp"
#include "volute/tomography/prior.hpp"
#include "volute/tomography/singular_values.hpp"

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
        inside_(support_->latticeSize()),
        weight_(support_->latticeSize()),
        target_(*support_),
        primal_(*support_),
        dual_(support_->latticeSize(), kZero),
        ahead_(dual_) {
    for (std::int32_t node : support_->nodes()) inside_[node] = 1;
    const auto& stride = support_->stride();
    std::vector<std::uint8_t> reached(inside_);
    for (std::int32_t node : support_->nodes())
      for (std::int32_t step : stride) reached[node - step] = 1;
    for (std::size_t node = 0; node < reached.size(); ++node) {
      if (reached[node])
        reached_.push_back(static_cast<std::int32_t>(node));
    }
    rate_.resize(reached_.size());
  }

  void proximal(std::span<float> a, std::span<const float> step) override {
    constexpr int kIterations = 5;  // the dual goes on from the call before
    setSteps(step);
    target_.fill(a);
    ahead_ = dual_;
    Momentum momentum;
    for (int k = 0; k < kIterations; ++k) {
      updatePrimal(ahead_);
      updateDual(momentum.next());
    }
    updatePrimal(dual_);
    primal_.copyTo(a);
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
  using Dual = ColourSlopes;
  inline static const Dual kZero{Colour::Zero(), Colour::Zero(), Colour::Zero()};

  /// Each dual vector has a rate of its own (Pock and Chambolle 2011, lemma 2), so that one unknown
  /// with a large step does not slow all the others down.
  void setSteps(std::span<const float> step) {
    const auto nodes = support_->nodes();
    const auto strength = static_cast<float>(strength_);
    for (std::size_t i = 0; i < nodes.size(); ++i) weight_[nodes[i]] = step[i] * strength;
    for (std::size_t i = 0; i < reached_.size(); ++i) {
      const std::int32_t n = reached_[i];
      float next = 0;
      for (std::int32_t stride : support_->stride()) next = std::max(next, weight_[n + stride]);
      rate_[i] = 1 / (6 * (weight_[n] + next));
    }
  }

  /// primal = the constraint's nearest point to target - weight * D' dual.
  void updatePrimal(const std::vector<Dual>& dual) {
    const auto& stride = support_->stride();
    const auto nodes = support_->nodes();
    forElements(nodes.size(), [&](std::size_t i) {
      const std::ptrdiff_t n = nodes[i];
      Colour sum = Colour::Zero();
      for (int a = 0; a < 3; ++a) sum += dual[n - stride[a]][a] - dual[n][a];
      const Colour value = target_[n] - weight_[n] * sum;
      primal_[n] = nonNegative_ ? Colour(value.max(0.0F)) : value;
    });
  }

  /// dual = ahead + rate D primal, no singular value above 1; ahead = dual + beta (dual - the dual
  /// before).
  void updateDual(float beta) {
    const auto& stride = support_->stride();
    constexpr std::size_t kBlock = 64;
    parallelRanges(reached_.size(), kVectorBlock, [&](std::size_t begin, std::size_t end) {
      std::array<Dual, kBlock> next;
      for (std::size_t first = begin; first < end; first += kBlock) {
        const std::size_t count = std::min(kBlock, end - first);
        for (std::size_t k = 0; k < count; ++k) {
          const std::ptrdiff_t n = reached_[first + k];
          for (int a = 0; a < 3; ++a)
            next[k][a] = ahead_[n][a] + rate_[first + k] * (primal_[n + stride[a]] - primal_[n]);
        }
        clipSingularValues({next.data(), count});
        for (std::size_t k = 0; k < count; ++k) {
          const std::ptrdiff_t n = reached_[first + k];
          for (int a = 0; a < 3; ++a) {
            ahead_[n][a] = next[k][a] + beta * (next[k][a] - dual_[n][a]);
            dual_[n][a] = next[k][a];
          }
        }
      }
    });
  }

  std::shared_ptr<const Support> support_;
  double strength_;
  Sparsity sparsity_;
  bool nonNegative_;
  std::vector<std::int32_t> reached_;  // nodes with a difference to an unknown
  std::vector<std::uint8_t> inside_;
  std::vector<float> weight_;
  std::vector<float> rate_;  // of each in reached_
  LatticeField target_, primal_;
  std::vector<Dual> dual_, ahead_;
};

}  // namespace

std::unique_ptr<Prior> makeTotalVariation(std::shared_ptr<const Support> support, double strength,
                                          const Sparsity& sparsity, bool nonNegative) {
  if (!(strength > 0))
    return makeNoPrior(nonNegative);
  return std::make_unique<TotalVariation>(std::move(support), strength, sparsity, nonNegative);
}

}  // namespace volute
