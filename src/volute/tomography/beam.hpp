// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

#include "volute/tomography/beam_kernels.hpp"
#include "volute/tomography/support.hpp"

namespace volute {

/// Makes the rays of a pixel one beam through a trilinear support.
/// @param touched  touchedPart of each; not all empty.
/// @return Whether it could: not when they are no four, not where the rays are too far apart,
///   advance along different axes or ascend and descend along the same, and not where one starts
///   inside the lattice or leaves it far from the others.
bool makeBeam(const Support& support, std::span<const Segment> segments,
              std::span<const TouchedPart> touched, Beam& beam, std::span<BeamRay> rays);

}  // namespace volute
