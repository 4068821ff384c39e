// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/block_codec.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace volute {
namespace {

// A float's exponent and the upper four bits of its mantissa.
constexpr int kDroppedBits = 19;
constexpr std::size_t kBins = std::size_t{1} << (31 - kDroppedBits);

// Coefficients below the dead zone, in steps, are quantised to zero. A bin is narrow against a step
// up to some steps; above that its error is uniform on [-0.4, 0.6] steps.
constexpr double kRounding = 0.4;
constexpr double kDeadZone = 1 - kRounding;
constexpr double kResolved = 4;
constexpr double kMeanSquare = (0.6 * 0.6 * 0.6 + 0.4 * 0.4 * 0.4) / 3;

std::size_t binOf(double magnitude) {
  return std::bit_cast<std::uint32_t>(static_cast<float>(std::min(magnitude, 1e38))) >>
         kDroppedBits;
}

}  // namespace

int BlockShape::levels() const {
  int levels = 1;
  for (int side = *std::ranges::max_element(extents); side > 1; side = (side + 1) / 2) ++levels;
  return levels;
}

ErrorHistogram::ErrorHistogram() : bins_(kBins) {}

void ErrorHistogram::add(double coefficient, double weight) {
  if (coefficient == 0)
    return;
  Bin& bin = bins_[binOf(std::abs(coefficient))];
  bin.count += 1;
  bin.weight += weight;
  bin.energy += weight * coefficient * coefficient;
}

void ErrorHistogram::add(const ErrorHistogram& other) {
  for (std::size_t i = 0; i < kBins; ++i) {
    bins_[i].count += other.bins_[i].count;
    bins_[i].weight += other.bins_[i].weight;
    bins_[i].energy += other.bins_[i].energy;
  }
}

double ErrorHistogram::squaredError(double step) const {
  double sum = 0;
  for (const Bin& bin : bins_) {
    if (bin.weight == 0)
      continue;
    const double steps = std::sqrt(bin.energy / bin.weight) / step;
    const double error = steps - std::floor(steps + kRounding);
    sum += steps < kDeadZone   ? bin.energy
           : steps < kResolved ? bin.weight * error * error * step * step
                               : bin.weight * kMeanSquare * step * step;
  }
  return sum;
}

double ErrorHistogram::survivors(double step) const {
  double sum = 0;
  for (std::size_t i = binOf(kDeadZone * step); i < kBins; ++i) sum += bins_[i].count;
  return sum;
}

const BlockCodec* findCodec(std::uint32_t id) {
  return id == haarCodec().id() ? &haarCodec() : nullptr;
}

}  // namespace volute
