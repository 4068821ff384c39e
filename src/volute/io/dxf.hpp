// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// From one point to another, in the unit of its drawing.
struct DrawnLine {
  Vec2 from = Vec2::Zero(), to = Vec2::Zero();
};

/// A closed line, and text that stands somewhere.
struct DrawnOutline {
  std::vector<Vec2> points;
  int line = 0;  ///< of the file
};

struct DrawnText {
  Vec2 at = Vec2::Zero();
  std::string text;
};

/// A drawing seen from above, as straight lines: arcs are cut so that no point lies further off
/// than 1/2000 of the radius.
struct DxfDrawing {
  std::vector<DrawnLine> lines;
  std::vector<DrawnOutline> outlines;  ///< of the layer that is asked for
  std::vector<DrawnText> texts;        ///< of that layer
  int open = 0;                        ///< its polylines that are not closed
  std::optional<double> unit;          ///< [m], where the file states one ($INSUNITS)
  std::map<std::string, int> left;     ///< entities of kinds that are not drawn, and how many
};

/// An ASCII .dxf file (Autodesk, DXF Reference 2012): LINE, LWPOLYLINE and POLYLINE with bulges,
/// ARC, CIRCLE, ELLIPSE, SPLINE, SOLID, TRACE, 3DFACE, and blocks that are inserted, also in rows
/// and columns. What is on layers that are off or frozen, invisible, or on paper is left out.
/// Errors name the line.
/// @param layer  of which closed polylines, circles and texts are kept besides, whether it is off
/// or not; kNotFound where there is no such layer
[[nodiscard]] Result<DxfDrawing> readDxf(const std::filesystem::path& path, std::uint64_t maxMemory,
                                         std::string_view layer = {});

}  // namespace volute
