// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/image/image.hpp"
#include "volute/math/vec.hpp"
#include "volute/visibility/eyes.hpp"
#include "volute/visibility/plan_underlay.hpp"
#include "volute/visibility/survey.hpp"

namespace volute {

/// The kind of a point of a plan. Each has a style of its own, in grey or hatched, so that it is no
/// value's colour and no two are alike to the colour-blind.
enum class PlanMark : unsigned char {
  kValue,    ///< its value's colour
  kSolid,    ///< nobody stands here: dark grey
  kHidden,   ///< nearly white
  kLost,     ///< grey
  kKept,     ///< blue hatches on white
  kFloor,    ///< nothing to say
  kUnknown,  ///< no data: grey lines both ways on white
};

/// The initial map of a plan: kSolid in solids, else kUnknown.
std::vector<PlanMark> emptyMarks(const FloorPlan& plan);

/// What the legend says of marks on every map.
inline constexpr const char* kNoData = "no data";
inline constexpr const char* kNotKnownWords = "not known, or not known all along";
inline constexpr const char* kSolidWords = "solid: nobody stands there";

/// A map over a floor plan as a picture: axes in metres, a key, walls at their places, signs, a
/// scale, a legend.
struct PlanPicture {
  std::string title, subtitle;
  std::string barLabel;      ///< empty: no colour bar
  double low = 0, high = 1;  ///< the bar's ends
  bool highIsMore = false;   ///< what is above `high` has its colour: "30+"
  bool stored = false;       ///< values are some of few, as stored times: few get a colour each
  /// Where there are some, a value is the place of its colour (as displays show it) and its words
  /// here, and there is no bar; those without words are not in the legend.
  std::vector<std::pair<Rgb, std::string>> kinds{};
  std::vector<double> values;   ///< shape (y, x) of the plan
  std::vector<PlanMark> marks;  ///< the same
  /// What a mark stands for, in the legend under the map; marks without words are left out.
  std::vector<std::pair<PlanMark, std::string>> words;
  std::vector<PlanShape> shapes{};                         ///< at the eyes' height
  std::shared_ptr<const PlanUnderlay> underlay = nullptr;  ///< may be null
  std::optional<double> north{};  ///< [degrees], from +y clockwise: an arrow; nothing: none
  std::vector<std::pair<Vec2, std::string>> labels{};  ///< texts, and where their middles are [m]
};

/// The signs that a plan at a height [m] shows: those of its storey, not those with a floor
/// between.
std::vector<SightTarget> signsOfStorey(const SightSnapshot& snapshot,
                                       std::span<const SightTarget> signs, double height);

/// Draws it in linear RGB.
Image drawPlan(const FloorPlan& plan, const PlanPicture& picture,
               std::span<const SightTarget> signs, std::span<const Route> routes = {});

/// The same as the text of an SVG file.
std::string planSvg(const FloorPlan& plan, const PlanPicture& picture,
                    std::span<const SightTarget> signs, std::span<const Route> routes = {});

/// Writes `file` (.png) and beside it the same as .svg.
[[nodiscard]] Status writePlan(const std::filesystem::path& file, const FloorPlan& plan,
                               const PlanPicture& picture, std::span<const SightTarget> signs,
                               std::span<const Route> routes = {});

}  // namespace volute
