// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/media/contour.hpp"
#include "volute/media/smoke/smoke_medium.hpp"

namespace volute {

/// Appends a contour of smoke, and the building that its mesh fills. A concentration needs a field
/// that holds mass (SmokeState::extinctionOfUnit).
void contourPieces(const Contour& contour, const Camera& camera, const SmokeState& smoke,
                   ContourPieces& pieces);

}  // namespace volute
