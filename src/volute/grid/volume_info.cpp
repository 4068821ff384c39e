// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/volume_info.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace volute {
namespace {

constexpr std::string_view kBasisNames[] = {"box", "trilinear", "cubic"};

}  // namespace

std::string_view basisName(Basis basis) {
  return kBasisNames[static_cast<std::size_t>(basis)];
}

std::optional<Basis> basisNamed(std::string_view name) {
  for (const Basis basis : {Basis::kBox, Basis::kTrilinear, Basis::kCubic}) {
    if (basisName(basis) == name)
      return basis;
  }
  return std::nullopt;
}

int VolumeInfo::frameAt(double time) const {
  const auto after = std::upper_bound(times.begin(), times.end(), time);
  return std::max(0, static_cast<int>(after - times.begin()) - 1);
}

void VolumeInfo::setRate(double framesPerSecond) {
  times.clear();
  for (const int number : frameNumbers) {
    const double elapsed = static_cast<double>(number) - frameNumbers.front();
    times.push_back(elapsed / (framesPerSecond * frameScale.unit()));
  }
  timesAssumed = false;
}

/// More would take memory for numbers and times alone; validate() refuses them.
static constexpr int kMaxFrames = 1 << 24;

void VolumeInfo::fillDefaults() {
  constexpr double kFramesPerSecond = 25;
  if (frames < 0 || frames > kMaxFrames)
    return;
  if (frameNumbers.empty()) {
    frameNumbers.resize(frames);
    std::iota(frameNumbers.begin(), frameNumbers.end(), 0);
  }
  if (times.empty()) {
    setRate(kFramesPerSecond);
    timesAssumed = true;
  }
  if (bounds.empty()) {
    const Vec3 voxels(x, y, z);
    bounds = {Vec3::Zero(), voxels / std::max(1.0, voxels.maxCoeff())};
  }
}

Status VolumeInfo::validate(const std::string& where) const {
  constexpr double kMaxVoxels = 0x1p58;  // so that bytes of a frame can be counted
  if (frames < 1)
    return fail(ErrorCode::kInvalidData, "{}: the sequence is empty; expected at least one frame",
                where);
  if (frames > kMaxFrames) {
    return fail(ErrorCode::kTooLarge, "{}: {} frames; expected at most {}: take a part of them",
                where, frames, kMaxFrames);
  }
  if (x < 1 || y < 1 || z < 1) {
    return fail(ErrorCode::kInvalidData, "{}: a volume of {} x {} x {} voxels has no values", where,
                x, y, z);
  }
  if (static_cast<double>(x) * y * z > kMaxVoxels) {
    return fail(ErrorCode::kTooLarge, "{}: {} x {} x {} voxels is beyond what a volume can hold",
                where, x, y, z);
  }
  if (channels != 1 && channels != 3) {
    return fail(ErrorCode::kInvalidData, "{}: {} channels; expected 1 (scalar) or 3 (RGB)", where,
                channels);
  }
  if (!bounds.min.allFinite() || !bounds.max.allFinite() || bounds.empty()) {
    return fail(ErrorCode::kInvalidData,
                "{}: the bounds are empty or not finite; expected min < max on every axis", where);
  }
  constexpr double kFarthest = 1e15;  // [m]; lengths, volumes and depths stay far from overflow
  if (bounds.min.cwiseAbs().maxCoeff() > kFarthest ||
      bounds.max.cwiseAbs().maxCoeff() > kFarthest) {
    return fail(
        ErrorCode::kInvalidData,
        "{}: the bounds reach to {:g} m; expected at most {:g} m: is the file damaged, or of "
        "another unit?",
        where, std::max(bounds.min.cwiseAbs().maxCoeff(), bounds.max.cwiseAbs().maxCoeff()),
        kFarthest);
  }
  if (static_cast<int>(frameNumbers.size()) != frames || static_cast<int>(times.size()) != frames) {
    return fail(ErrorCode::kInvalidData, "{}: {} frames, but {} frame numbers and {} times", where,
                frames, frameNumbers.size(), times.size());
  }
  for (int i = 0; i < frames; ++i) {
    const bool ascending =
        i == 0 || (frameNumbers[i] > frameNumbers[i - 1] && times[i] > times[i - 1]);
    if (!ascending || !std::isfinite(times[i])) {
      return fail(ErrorCode::kInvalidData,
                  "{}: frame numbers and times must be finite and ascend; frame {} does not", where,
                  i);
    }
  }
  return {};
}

}  // namespace volute
