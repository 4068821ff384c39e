// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "volute/base/view.hpp"
#include "volute/tomography/lattice_field.hpp"
#include "volute/tomography/prior.hpp"
#include "volute/wavelet/transform4d.hpp"

namespace volute {
namespace {

constexpr int kLevels = 3;
constexpr int kShifts = 1 << kLevels;

class WaveletSparsity final : public Prior {
 public:
  WaveletSparsity(std::shared_ptr<const Support> support, Wavelet wavelet, double strength,
                  bool nonNegative, std::uint32_t seed)
      : support_(std::move(support)),
        wavelet_(wavelet),
        strength_(strength),
        nonNegative_(nonNegative),
        random_(seed) {
    for (int a = 0; a < 3; ++a) size_[a] = support_->boxSize()[a] + kShifts;
    for (auto& channel : channels_) channel.resize(size_[0] * size_[1] * size_[2]);
    place_.reserve(support_->size());
    const auto& stride = support_->stride();
    for (std::int32_t node : support_->nodes()) {
      const std::int32_t at = node - support_->firstVoxel();
      place_.push_back((at / stride[2] * size_[1] + at % stride[2] / stride[1]) * size_[0] +
                       at % stride[1]);
    }
  }

  bool takesSteps() const override { return false; }

  void proximal(std::span<float> a, std::span<const float> steps) override {
    const float step = steps.empty() ? 0 : steps[0];
    std::ptrdiff_t shift = 0;
    for (int axis = 3; axis-- > 0;)
      shift = shift * size_[axis] + static_cast<std::ptrdiff_t>(random_() % kShifts);
    const std::array<int, 4> levels{0, kLevels, kLevels, kLevels};
    parallelFor(3, [&](std::size_t c) {
      std::ranges::fill(channels_[c], 0.0F);
      for (std::size_t i = 0; i < place_.size(); ++i)
        channels_[c][place_[i] + shift] = a[4 * i + c];
      transformForward(view(c), wavelet_, levels);
    });
    shrink(static_cast<float>(step * strength_));
    parallelFor(3, [&](std::size_t c) {
      transformInverse(view(c), wavelet_, levels);
      for (std::size_t i = 0; i < place_.size(); ++i) {
        const float value = channels_[c][place_[i] + shift];
        a[4 * i + c] = nonNegative_ ? std::max(value, 0.0F) : value;
      }
    });
  }

 private:
  View<float, 4> view(std::size_t channel) {
    return {std::span<float>(channels_[channel]), {1, size_[2], size_[1], size_[0]}};
  }

  /// Shortens each coefficient, a colour, by `amount`; the coarsest scaling coefficients stay.
  void shrink(float amount) {
    parallelFor(static_cast<std::size_t>(size_[2]), [&](std::size_t z) {
      for (std::ptrdiff_t y = 0; y < size_[1]; ++y) {
        for (std::ptrdiff_t x = 0; x < size_[0]; ++x) {
          if ((z | y | x) % kShifts == 0)
            continue;
          const std::size_t i = (z * size_[1] + y) * size_[0] + x;
          const float length = std::hypot(channels_[0][i], channels_[1][i], channels_[2][i]);
          const float scale = length > amount ? 1 - amount / length : 0;
          for (auto& channel : channels_) channel[i] *= scale;
        }
      }
    });
  }

  std::shared_ptr<const Support> support_;
  Wavelet wavelet_;
  double strength_;
  bool nonNegative_;
  std::mt19937 random_;
  std::array<std::ptrdiff_t, 3> size_{};  // the box and room to shift it, on x, y, z
  std::vector<std::ptrdiff_t> place_;     // of each unknown, without a shift
  std::array<std::vector<float>, 3> channels_;
};

}  // namespace

std::unique_ptr<Prior> makeWaveletSparsity(std::shared_ptr<const Support> support, Wavelet wavelet,
                                           double strength, bool nonNegative, std::uint32_t seed) {
  if (!(strength > 0))
    return makeNoPrior(nonNegative);
  return std::make_unique<WaveletSparsity>(std::move(support), wavelet, strength, nonNegative,
                                           seed);
}

}  // namespace volute
