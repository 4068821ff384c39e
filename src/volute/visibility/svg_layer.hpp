// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "volute/visibility/area_file.hpp"

namespace volute {

/// What is drawn on a layer of an .svg file, in shares of its picture: 0, 0 is the lower left
/// corner, 1, 1 the upper right one.
struct SvgLayer {
  std::vector<PlanOutline> outlines;                ///< closed, of straight lines
  std::vector<std::pair<Vec2, std::string>> texts;  ///< where each begins
  int open = 0;                                     ///< lines that are not closed
  int curved = 0;                                   ///< circles, and lines with curves
};

/// Rectangles, polygons, closed polylines and closed parts of paths in the group whose label
/// (inkscape:label) or id is `layer`, in any case. A label of its own is an outline's name.
/// kNotFound where there is no such group; kUnsupported for transforms and pictures that are not
/// understood. Errors name the line.
[[nodiscard]] Result<SvgLayer> readSvgLayer(const std::filesystem::path& file,
                                            const std::string& layer);

}  // namespace volute
