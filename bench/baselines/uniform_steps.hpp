// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

#include "volute/medium/medium.hpp"

namespace volute {

class FogMedium;

/// The usual way: the density at the midpoints of so many equal steps, in SIMD like the walk and
/// from the same set-up. Kept as the timed baseline. Degree 1 and profiles of constant zones only.
void uniformStepDepths(const FogMedium& fog, int steps, std::span<const Segment> segments,
                       std::span<double> depths);

}  // namespace volute
