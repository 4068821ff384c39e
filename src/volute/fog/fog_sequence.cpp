// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_sequence.hpp"

#include <algorithm>
#include <cmath>

namespace volute {

Result<FogSequence> FogSequence::make(std::vector<Frame> frames, const FogProfile& profile,
                                      const FogOptions& options, const Vec3& wind) {
  if (frames.empty())
    return fail(ErrorCode::kInvalidArgument, "a sequence of fog maps needs at least one");
  if (!wind.allFinite())
    return fail(ErrorCode::kInvalidArgument, "the wind over the fog is not finite");
  FogSequence sequence;
  sequence.wind_ = wind;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FogMap& map = frames[i].map;
    const FogMap& first = frames.front().map;
    if (map.coefficients.columns != first.coefficients.columns ||
        map.coefficients.rows != first.coefficients.rows || map.cell != first.cell ||
        map.origin != first.origin) {
      return fail(ErrorCode::kInvalidArgument,
                  "fog map {} is {} x {}, but the first is {} x {}: all need one size and place", i,
                  map.coefficients.columns, map.coefficients.rows, first.coefficients.columns,
                  first.coefficients.rows);
    }
    if (!std::isfinite(frames[i].time) || (i > 0 && !(frames[i].time > frames[i - 1].time))) {
      return fail(ErrorCode::kInvalidArgument, "fog map {} is at {} s, but times must rise", i,
                  frames[i].time);
    }
    VOLUTE_ASSIGN(FogMedium fog, FogMedium::make(map, profile, options));
    sequence.times_.push_back(frames[i].time);
    sequence.fogs_.push_back(std::move(fog));
  }
  return sequence;
}

FogSequence FogSequence::withProfile(const FogProfile& profile) const {
  FogSequence sequence = *this;
  for (FogMedium& fog : sequence.fogs_) fog = fog.withProfile(profile);
  return sequence;
}

FogMedium FogSequence::at(double time) const {
  const Vec3 blown = time * wind_;
  const auto next = std::ranges::upper_bound(times_, time);
  if (next == times_.begin())
    return fogs_.front().shifted(blown);
  const std::size_t i = next - times_.begin() - 1;
  if (next == times_.end() || times_[i] == time)
    return fogs_[i].shifted(blown);
  const double share = (time - times_[i]) / (times_[i + 1] - times_[i]);
  const FogLevels& before = fogs_[i].levels();
  SplinePyramid mixed = before.pyramid().mixed(fogs_[i + 1].levels().pyramid(), share);
  return fogs_[i]
      .withLevels(
          std::make_shared<const FogLevels>(std::move(mixed), before.columns(), before.rows()))
      .shifted(blown);
}

}  // namespace volute
