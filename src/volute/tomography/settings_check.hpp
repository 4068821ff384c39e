// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/base/progress.hpp"
#include "volute/capture/capture.hpp"
#include "volute/tomography/reconstructed_frames.hpp"

namespace volute {

/// kInvalidArgument for settings that would have no effect on this capture: strengths of a prior
/// with solvers and regularizations that have none, and a temporal prior where no frame can be
/// predicted from those before.
[[nodiscard]] Status checkSettings(const ReconstructionSettings& settings, const Capture& capture);

/// Notes what the capture states and these settings do not use: lamps, albedo, spectrum.
void remarkOnUnused(const ReconstructionSettings& settings, const Capture& capture,
                    Progress& progress);

}  // namespace volute
