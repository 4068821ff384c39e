// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string>
#include <vector>

#include "volute/image/image.hpp"
#include "volute/visibility/eyes.hpp"
#include "volute/visibility/survey.hpp"

namespace volute {

/// What a point of a plan shows.
enum class PlanMark : unsigned char {
  kValue,  ///< its value's colour
  kSolid,  ///< nobody stands here
  kHidden,
  kLost,
  kKept,
  kFloor,  ///< nothing to say
};

/// A map over a floor plan as a picture: axes in metres, a colour bar, the signs, a legend.
struct PlanPicture {
  std::string title, subtitle;
  std::string barLabel;         ///< empty: no colour bar
  double low = 0, high = 1;     ///< the bar's ends
  bool highIsMore = false;      ///< what is above `high` has its colour: "30+"
  /// Where there are some, a value is the place of its colour (as displays show it) and its words
  /// here, and there is no bar.
  std::vector<std::pair<Rgb, std::string>> kinds;
  std::vector<double> values;   ///< shape (y, x) of the plan
  std::vector<PlanMark> marks;  ///< the same
  /// What a mark stands for, in the legend under the map; marks without words are left out.
  std::vector<std::pair<PlanMark, std::string>> words;
};

/// Draws it in linear RGB.
Image drawPlan(const FloorPlan& plan, const PlanPicture& picture,
               std::span<const SightTarget> signs, std::span<const Route> routes = {});

}  // namespace volute
