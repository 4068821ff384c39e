// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/math/vec2.hpp"

namespace volute {

/// From one point to another, in the unit of its drawing.
struct DrawnLine {
  Vec2 from = Vec2::Zero(), to = Vec2::Zero();
};

/// A drawing seen from above, as straight lines: arcs are cut so that no point lies further off
/// than 1/2000 of the radius.
struct DxfDrawing {
  std::vector<DrawnLine> lines;
  std::optional<double> unit;       ///< [m], where the file states one ($INSUNITS)
  std::map<std::string, int> left;  ///< entities of kinds that are not drawn, and how many
};

/// An ASCII .dxf file (Autodesk, DXF Reference 2012): LINE, LWPOLYLINE and POLYLINE with bulges,
/// ARC, CIRCLE, ELLIPSE, SPLINE, SOLID, TRACE, 3DFACE, and blocks that are inserted, also in rows
/// and columns. What is on layers that are off or frozen, invisible, or on paper is left out.
/// Errors name the line.
[[nodiscard]] Result<DxfDrawing> readDxf(const std::filesystem::path& path,
                                         std::uint64_t maxMemory);

}  // namespace volute
