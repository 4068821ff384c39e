// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "bench/benchmark.hpp"
#include "bench/tomography_scenes.hpp"

namespace volute::bench {

/// Seconds of 200 products with the projection matrix and its transpose, with all that comes before
/// them, beside an explicit sparse matrix (Eigen) of the same rows, unknowns and weights.
void addProjectorSpeed(const FilmedScene& scene, int raysPerPixel, BenchRows& rows);

}  // namespace volute::bench
