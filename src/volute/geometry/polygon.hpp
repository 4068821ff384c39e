// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// The triangles of a polygon, as corners' numbers: of a convex one a fan around its first corner,
/// else ears that are cut, so that a concave one is the same figure from whichever corner it
/// begins. Corners are seen along the polygon's mean normal; one without area is a fan, and one
/// that crosses itself becomes some triangles between its corners. Time grows with the number of
/// corners: kTooLarge, in half a sentence, where cutting takes more than a fixed multiple of it.
[[nodiscard]] Result<std::vector<std::array<std::uint32_t, 3>>> trianglesOf(
    std::span<const Vec3> corners);

}  // namespace volute
