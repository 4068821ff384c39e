// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/prior.hpp"

#include <algorithm>

#include "volute/tomography/lattice_field.hpp"

namespace volute {
namespace {

void clampNegative(std::span<float> a) {
  forElements(a.size(), [&](std::size_t i) { a[i] = std::max(a[i], 0.0F); });
}

class NoPrior final : public Prior {
 public:
  explicit NoPrior(bool nonNegative) : nonNegative_(nonNegative) {}

  void proximal(std::span<float> a, std::span<const float>) override {
    if (nonNegative_)
      clampNegative(a);
  }

 private:
  bool nonNegative_;
};

class Smoothness final : public Prior {
 public:
  Smoothness(std::shared_ptr<const Support> support, double strength, bool nonNegative)
      : support_(std::move(support)), strength_(strength), nonNegative_(nonNegative) {}

  void proximal(std::span<float> a, std::span<const float>) override {
    if (nonNegative_)
      clampNegative(a);
  }

  void addGradient(std::span<const float> a, std::span<float> gradient) const override {
    LatticeField field(*support_);
    field.fill(a);
    const auto nodes = support_->nodes();
    forElements(nodes.size(), [&](std::size_t i) {
      const std::ptrdiff_t node = nodes[i];
      Colour laplacian = 6 * field[node];
      for (std::ptrdiff_t stride : support_->stride())
        laplacian -= field[node - stride] + field[node + stride];
      Eigen::Map<Colour>(&gradient[4 * i]) += static_cast<float>(strength_) * laplacian;
    });
  }

  double curvature() const override { return 12 * strength_; }

 private:
  std::shared_ptr<const Support> support_;
  double strength_;
  bool nonNegative_;
};

}  // namespace

std::unique_ptr<Prior> makeNoPrior(bool nonNegative) {
  return std::make_unique<NoPrior>(nonNegative);
}

std::unique_ptr<Prior> makeSmoothness(std::shared_ptr<const Support> support, double strength,
                                      bool nonNegative) {
  return std::make_unique<Smoothness>(std::move(support), strength, nonNegative);
}

}  // namespace volute
