// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>

#include "volute/tomography/lattice_field.hpp"

namespace volute {

/// Differences of a colour along x, y and z: a matrix of 3 axes by 3 channels. The fourth float of
/// each colour is 0.
using ColourSlopes = std::array<Colour, 3>;

/// Replaces each matrix by the nearest one (Frobenius norm) none of whose singular values is above
/// 1: larger ones become 1. To about 1e-5 of the matrix.
void clipSingularValues(std::span<ColourSlopes> slopes);

}  // namespace volute
