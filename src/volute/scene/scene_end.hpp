// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/scene/scene.hpp"

namespace volute {

/// Whether there is something at a time [s]: kInvalidArgument, "time: ..." with the times that
/// there are, where all media with frames have ended, or before 0 and the first of them. The last
/// frame lasts as long as the one before. What loops, has one frame, or has no end of its own holds
/// at any time.
[[nodiscard]] Status checkSceneTime(const Scene& scene, double time);

}  // namespace volute
