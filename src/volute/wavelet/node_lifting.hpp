// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

namespace volute {

/// CDF(2,2) of a function that is linear between nodes 0..N and zero at both ends, in place; N
/// even. Node j holds coefficient j - 1 of the B-splines of degree 1. Afterwards even nodes hold
/// the coarse function, odd ones the details. Beside the border the weight of the missing neighbour
/// goes to the present one, so that 2 * (sum of the coarse nodes) is the sum of all nodes, exactly.
void liftNodes(std::span<double> nodes);

/// Undoes liftNodes.
void unliftNodes(std::span<double> nodes);

}  // namespace volute
