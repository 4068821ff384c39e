// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <vector>

#include "volute/tomography/prior.hpp"

namespace volute {

/// strength / 2 * |a - expected|^2 besides another prior: what the frame before lets expect.
/// @param expected  four floats for each unknown.
std::unique_ptr<Prior> makeTemporalPrior(std::unique_ptr<Prior> other, double strength,
                                         std::vector<float> expected);

}  // namespace volute
