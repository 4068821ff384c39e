// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "bench/smoke_targets.hpp"
#include "volute/base/progress.hpp"

namespace volute::bench {

/// Holds every pixel of whole pictures against the reference in double: optical depth and lit
/// colour, from outside and inside, up to an exit sign, and with the eye
/// on a vertex, an edge and a face of the mesh; and a lamp's light at every vertex. Takes minutes;
/// `quick` pictures are small.
[[nodiscard]] Status judgeWholePictures(const SmokeCase& smoke,
                                        const std::shared_ptr<const TetLocator>& locator,
                                        bool quick, BenchRows& rows, SmokeTargets& targets,
                                        Progress& progress);

}  // namespace volute::bench
