// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_end.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/base/plain_number.hpp"

namespace volute {
namespace {

/// The last frame lasts as long as the one before. A lone one lasts for ever.
double endOf(const MediumInfo& medium) {
  const std::size_t n = medium.times.size();
  return n < 2 || medium.loops || medium.endless ? std::numeric_limits<double>::infinity()
                                                 : 2 * medium.times[n - 1] - medium.times[n - 2];
}

}  // namespace

Status checkSceneTime(const Scene& scene, double time) {
  constexpr double kRounding = 1e-9;
  const auto rounding = [](double at) { return kRounding * (1 + std::abs(at)); };
  const MediumInfo* longest = nullptr;
  double begin = 0;
  for (const auto& medium : scene.media()) {
    const MediumInfo& info = medium->info();
    if (info.endless)
      return {};
    if (!info.times.empty())
      begin = std::min(begin,
                       info.loops ? -std::numeric_limits<double>::infinity() : info.times.front());
    if (info.times.size() > 1 && (!longest || endOf(info) > endOf(*longest)))
      longest = &info;
  }
  if (longest && time < begin - rounding(begin)) {
    return failFor("time", ErrorCode::kInvalidArgument,
                   "{} s is before the begin: {} has {} frames from {} to {} s", plainNumber(time),
                   longest->file, longest->times.size(), plainNumber(longest->times.front()),
                   plainNumber(longest->times.back()));
  }
  if (!longest || time <= endOf(*longest) + rounding(endOf(*longest)))
    return {};
  return failFor("time", ErrorCode::kInvalidArgument,
                 "{} s is past the end: {} has {} frames from {} to {} s", plainNumber(time),
                 longest->file, longest->times.size(), plainNumber(longest->times.front()),
                 plainNumber(longest->times.back()));
}

}  // namespace volute
