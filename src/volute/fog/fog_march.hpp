// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

#include "volute/medium/medium.hpp"

// The fast execution of FogMedium, apart from the medium so that the SIMD code is one translation
// unit.

namespace volute {

class FogMedium;

/// The optical depth of each segment, in float: transmittances within 2e-6 of the reference. A ray
/// that has lost all but 1e-7 of its light ends there. The fog has no top, and its levels fit.
void marchDepths(const FogMedium& fog, std::span<const Segment> segments, std::span<double> depths);

}  // namespace volute
