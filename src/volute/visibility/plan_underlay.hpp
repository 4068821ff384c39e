// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "volute/base/remark.hpp"
#include "volute/base/result.hpp"
#include "volute/image/image.hpp"
#include "volute/math/vec.hpp"
#include "volute/visibility/area_file.hpp"

namespace volute {

/// A drawing of the building over maps: a picture's dark parts, or lines.
struct PlanUnderlay {
  Image picture{};                              ///< linear RGB; white is not drawn; may be empty
  Vec2 min = Vec2::Zero(), max = Vec2::Zero();  ///< where it ends [m]
  std::vector<std::pair<Vec2, Vec2>> lines{};   ///< from, to [m]
  std::vector<NamedArea> areas{};               ///< what is drawn on UnderlayOptions::areaLayer
};

struct UnderlayOptions {
  Vec2 min = Vec2::Zero(), max = Vec2::Zero();      ///< where the case ends [m]
  std::optional<std::pair<Vec2, Vec2>> place = {};  ///< the drawing's own ends, where stated [m]
  std::uint64_t maxMemory = std::uint64_t{4} << 30;

  /// A layer whose closed lines are areas, named by the text within them, else by the layer and a
  /// number; empty: none.
  std::string areaLayer = {};
};

/// A picture (.svg too, by rsvg-convert where it is installed) lies over the whole case; a .dxf
/// file where its coordinates say, in its unit or, where it states none, in that of m, mm, cm,
/// inches and feet which makes it as large as the case. A .dxf that touches the case nowhere is
/// moved to its lower left corner. What was chosen, and what is not drawn, is added to `remarks`.
[[nodiscard]] Result<PlanUnderlay> readUnderlay(const std::filesystem::path& file,
                                                const UnderlayOptions& options,
                                                std::vector<Remark>& remarks);

/// What is transparent in a picture becomes white.
/// @param alpha  of the same size, one channel: 0 transparent, 1 opaque
void layOnWhite(Image& picture, const Image& alpha);

/// The part of a line within a rectangle; nothing where there is none. Liang and Barsky 1984.
std::optional<std::pair<Vec2, Vec2>> lineWithin(Vec2 from, Vec2 to, const Vec2& min,
                                                const Vec2& max);

}  // namespace volute
