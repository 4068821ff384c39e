// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

#include "volute/medium/medium.hpp"

// The fast execution of FogMedium, apart from the medium so that the SIMD code is one translation
// unit.

namespace volute {

class FogMedium;

/// Beyond this optical depth no light is left to tell.
constexpr float kOpaqueDepth = 17;

/// The optical depth of each segment, in float: transmittances within 2e-6 of the reference. A ray
/// ends where its depth has reached `opaque`. The fog has no top, and its levels fit.
void marchDepths(const FogMedium& fog, std::span<const Segment> segments, std::span<double> depths,
                 float opaque = kOpaqueDepth);

}  // namespace volute
