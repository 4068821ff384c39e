// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_profile.hpp"

#include <algorithm>
#include <cmath>

namespace volute {

double FogProfile::Zone::operator()(double z) const {
  if (slope != 0)
    return value + slope * (z - reference);
  return decay != 0 ? value * std::exp(-decay * (z - reference)) : value;
}

Result<FogProfile> FogProfile::slab(double bottom, double top) {
  if (!(bottom < top && bottom < kFarthest && top > -kFarthest)) {
    return fail(ErrorCode::kInvalidArgument,
                "the fog's slab is from {} to {} m, but its top must be above its bottom", bottom,
                top);
  }
  return FogProfile(
      {Zone{.bottom = std::max(bottom, -kFarthest), .top = std::min(top, kFarthest)}});
}

Result<FogProfile> FogProfile::linear(std::span<const Knot> knots) {
  if (knots.size() < 2)
    return fail(ErrorCode::kInvalidArgument, "the fog's profile has {} knots, but needs two",
                knots.size());
  std::vector<Zone> zones;
  for (std::size_t i = 0; i < knots.size(); ++i) {
    const auto [height, value] = knots[i];
    if (!(std::isfinite(height) && value >= 0 && value <= 1)) {
      return fail(
          ErrorCode::kInvalidArgument,
          "knot {} of the fog's profile is [{}, {}], but expected is a height in metres and "
          "a share from 0 to 1",
          i, height, value);
    }
    if (i == 0)
      continue;
    const Knot& below = knots[i - 1];
    if (height < below.height) {
      return fail(ErrorCode::kInvalidArgument,
                  "knot {} of the fog's profile is at {} m, below the one before it at {} m", i,
                  height, below.height);
    }
    if (height > below.height && (value > 0 || below.value > 0)) {
      zones.push_back({.bottom = below.height,
                       .top = height,
                       .reference = below.height,
                       .value = below.value,
                       .slope = (value - below.value) / (height - below.height)});
    }
  }
  return FogProfile(std::move(zones));
}

Result<FogProfile> FogProfile::exponential(double bottom, double scaleHeight) {
  if (!(std::isfinite(bottom) && std::isfinite(scaleHeight) && scaleHeight > 0)) {
    return fail(
        ErrorCode::kInvalidArgument,
        "the fog's profile has the bottom {} m and the scale height {} m, but expected are a "
        "height and a length above 0",
        bottom, scaleHeight);
  }
  return FogProfile({Zone{.top = bottom}, Zone{.bottom = bottom,
                                               .top = bottom + kScaleHeights * scaleHeight,
                                               .reference = bottom,
                                               .decay = 1 / scaleHeight}});
}

Result<FogProfile> FogProfile::layers(std::span<const Layer> layers) {
  std::vector<double> borders;
  for (const Layer& layer : layers) {
    if (!(layer.bottom < layer.top) || !(layer.share >= 0 && std::isfinite(layer.share))) {
      return fail(
          ErrorCode::kInvalidArgument,
          "a layer of the fog is from {} to {} m with the share {}, but its top must be above "
          "its bottom and its share not negative",
          layer.bottom, layer.top, layer.share);
    }
    borders.insert(borders.end(), {layer.bottom, layer.top});
  }
  std::ranges::sort(borders);
  borders.erase(std::ranges::unique(borders).begin(), borders.end());
  std::vector<Zone> zones;
  for (std::size_t i = 0; i + 1 < borders.size(); ++i) {
    double share = 0;
    for (const Layer& layer : layers) {
      if (layer.bottom <= borders[i] && borders[i + 1] <= layer.top)
        share += layer.share;
    }
    const double bottom = std::max(borders[i], -kFarthest);
    const double top = std::min(borders[i + 1], kFarthest);
    if (share > 0 && bottom < top)
      zones.push_back({.bottom = bottom, .top = top, .value = share});
  }
  return FogProfile(std::move(zones));
}

double FogProfile::operator()(double z) const {
  for (const Zone& zone : zones_) {
    if (z >= zone.bottom && (z < zone.top || (z == zone.top && &zone == &zones_.back())))
      return zone(z);
  }
  return 0;
}

Interval FogProfile::heights() const {
  return zones_.empty() ? Interval{} : Interval{zones_.front().bottom, zones_.back().top};
}

Interval FogProfile::seenHeights() const {
  constexpr double kSeenScales = 5;
  Interval seen = heights();
  if (!zones_.empty() && zones_.back().decay > 0) {
    const Zone& last = zones_.back();
    seen = {std::max(seen.begin, last.bottom),
            std::min(seen.end, last.bottom + kSeenScales / last.decay)};
  }
  return seen;
}

}  // namespace volute
