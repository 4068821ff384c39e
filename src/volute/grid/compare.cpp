// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/compare.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace volute {
namespace {

double errorBetween(float a, float b) {
  if (a == b || (std::isnan(a) && std::isnan(b)))
    return 0;
  const double error = std::abs(static_cast<double>(b) - a);
  return std::isnan(error) ? std::numeric_limits<double>::infinity() : error;
}

std::string sizeText(const VolumeInfo& info) {
  return fmt::format("{} frame{} of {} x {} x {} voxels with {} channel{}", info.frames,
                     info.frames == 1 ? "" : "s", info.x, info.y, info.z, info.channels,
                     info.channels == 1 ? "" : "s");
}

}  // namespace

void Difference::add(std::span<const float> a, std::span<const float> b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double error = errorBetween(a[i], b[i]);
    sumOfSquares += error * error;
    maxError = std::max(maxError, error);
    if (values + i == 0)
      minA = maxA = a[i];
    minA = std::min<double>(minA, a[i]);
    maxA = std::max<double>(maxA, a[i]);
  }
  values += a.size();
}

double Difference::rms() const {
  return values == 0 ? 0 : std::sqrt(sumOfSquares / static_cast<double>(values));
}

double Difference::relativeRms() const {
  if (rms() == 0)
    return 0;
  return maxA > minA ? rms() / (maxA - minA) : std::numeric_limits<double>::infinity();
}

double Difference::psnr() const {
  return relativeRms() == 0 ? std::numeric_limits<double>::infinity()
                            : -20 * std::log10(relativeRms());
}

Result<Difference> compare(FrameSource& a, FrameSource& b, Progress& progress,
                           std::vector<Difference>* byFrame) {
  const VolumeInfo& infoA = a.info();
  const VolumeInfo& infoB = b.info();
  const bool sameSize = infoA.frames == infoB.frames && infoA.x == infoB.x && infoA.y == infoB.y &&
                        infoA.z == infoB.z && infoA.channels == infoB.channels;
  if (!sameSize) {
    return fail(ErrorCode::kInvalidData,
                "the sizes differ: the first has {}, the second {}; volumes of the same size can "
                "be compared",
                sizeText(infoA), sizeText(infoB));
  }
  Difference difference;
  std::vector<float> valuesA(infoA.frameValues());
  std::vector<float> valuesB(infoB.frameValues());
  for (int frame = 0; frame < infoA.frames; ++frame) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: comparing frame {}", frame);
    VOLUTE_TRY(a.readFrame(frame, valuesA));
    VOLUTE_TRY(b.readFrame(frame, valuesB));
    difference.add(valuesA, valuesB);
    if (byFrame)
      byFrame->emplace_back().add(valuesA, valuesB);
    progress.report("comparing", frame + 1, infoA.frames);
  }
  return difference;
}

}  // namespace volute
