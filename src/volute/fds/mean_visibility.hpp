// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <vector>

#include "volute/fds/smoke_scale.hpp"

namespace volute {

/// What the mean extinction of the cells round each node may be where a file holds the means V of
/// their visibilities C / K, which is more than C / V (Jensen's inequality), and less only where
/// some of them are cut. It is bounded by how V varies from node to node: no cell is assumed to see
/// less far than a share of the least V, or farther than that multiple of the largest V, among the
/// node and its neighbours. The extinction is largest if each cell is at either end.
///
/// The share is 1/3 in layers, of whose normal their nodes say nothing, and at the border of a box,
/// 2/3 within it: in fires on grids of 0.2 to 0.5 m it was then above the limit of 0.3 1/m
/// unnoticed at 0.1 % at most of the nodes where C / V misses that, and at none.
///
/// @param stored  visibilities [m], x fastest; what is not above 0 lies in solids, and is NaN in
///                what is returned, as are others that make no sense
/// @param size  of the file's box; a layer is one value thick
std::vector<SmokeBand> bandsOfMeans(const SmokeScale& scale, std::span<const float> stored,
                                    const std::array<int, 3>& size);

}  // namespace volute
