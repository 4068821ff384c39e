// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <array>
#include <cmath>

#include "volute/tomography/lattice_field.hpp"
#include "volute/tomography/prior.hpp"

namespace volute {
namespace {

/// The proximal step by accelerated projected gradient on its dual (Beck and Teboulle 2009, "Fast
/// gradient-based algorithms for constrained total variation"), with all channels under one root.
class TotalVariation final : public Prior {
 public:
  TotalVariation(std::shared_ptr<const Support> support, double strength, bool nonNegative)
      : support_(std::move(support)),
        strength_(strength),
        nonNegative_(nonNegative),
        inside_(support_->latticeSize()),
        weight_(support_->latticeSize()),
        target_(*support_),
        primal_(*support_),
        dual_(support_->latticeSize(), kZero),
        ahead_(dual_) {
    for (std::int32_t node : support_->nodes()) inside_[node] = 1;
    const std::ptrdiff_t margin = support_->stride()[2] + support_->stride()[1] + 1;
    first_ = margin;
    last_ = static_cast<std::ptrdiff_t>(support_->latticeSize()) - margin;
  }

  void proximal(std::span<float> a, std::span<const float> step) override {
    constexpr int kIterations = 10;  // the dual goes on from the call before
    const auto nodes = support_->nodes();
    const auto strength = static_cast<float>(strength_);
    float largest = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      weight_[nodes[i]] = step[i] * strength;
      largest = std::max(largest, weight_[nodes[i]]);
    }
    target_.fill(a);
    ahead_ = dual_;
    double momentum = 1;
    for (int k = 0; k < kIterations; ++k) {
      updatePrimal(ahead_);
      const double next = 0.5 * (1 + std::sqrt(1 + 4 * momentum * momentum));
      updateDual(1 / (12 * largest), static_cast<float>((momentum - 1) / next));
      momentum = next;
    }
    updatePrimal(dual_);
    primal_.copyTo(a);
  }

 private:
  using Dual = std::array<Colour, 3>;  // one for the difference along each axis
  inline static const Dual kZero{Colour::Zero(), Colour::Zero(), Colour::Zero()};

  template <class Body>
  void forNodes(Body&& body) const {
    forElements(static_cast<std::size_t>(last_ - first_),
                [&](std::size_t i) { body(first_ + static_cast<std::ptrdiff_t>(i)); });
  }

  /// primal = the constraint's nearest point to target - weight * D' dual.
  void updatePrimal(const std::vector<Dual>& dual) {
    const auto& stride = support_->stride();
    forNodes([&](std::ptrdiff_t n) {
      if (!inside_[n])
        return;
      Colour sum = Colour::Zero();
      for (int a = 0; a < 3; ++a) sum += dual[n - stride[a]][a] - dual[n][a];
      const Colour value = target_[n] - weight_[n] * sum;
      primal_[n] = nonNegative_ ? Colour(value.max(0.0F)) : value;
    });
  }

  /// dual = ahead + rate D primal, no longer than 1; ahead = dual + beta (dual - the dual before).
  void updateDual(float rate, float beta) {
    const auto& stride = support_->stride();
    forNodes([&](std::ptrdiff_t n) {
      Dual next;
      float squared = 0;
      for (int a = 0; a < 3; ++a) {
        next[a] = ahead_[n][a] + rate * (primal_[n + stride[a]] - primal_[n]);
        squared += next[a].square().sum();
      }
      const float scale = squared > 1 ? 1 / std::sqrt(squared) : 1;
      for (int a = 0; a < 3; ++a) {
        next[a] *= scale;
        ahead_[n][a] = next[a] + beta * (next[a] - dual_[n][a]);
        dual_[n][a] = next[a];
      }
    });
  }

  std::shared_ptr<const Support> support_;
  double strength_;
  bool nonNegative_;
  std::ptrdiff_t first_ = 0, last_ = 0;
  std::vector<std::uint8_t> inside_;
  std::vector<float> weight_;
  LatticeField target_, primal_;
  std::vector<Dual> dual_, ahead_;
};

}  // namespace

std::unique_ptr<Prior> makeTotalVariation(std::shared_ptr<const Support> support, double strength,
                                          bool nonNegative) {
  if (!(strength > 0))
    return makeNoPrior(nonNegative);
  return std::make_unique<TotalVariation>(std::move(support), strength, nonNegative);
}

}  // namespace volute
