// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/lighting/lamp.hpp"
#include "volute/math/box.hpp"

namespace volute {

/// Lamps of about the same light, in any order: those whose places and ways differ least for their
/// power become one, which sends their power (Ward's method). Suns stay; dark lamps go.
/// @param most  spots, at least 1
std::vector<Lamp> fewerLamps(std::span<const Lamp> lamps, std::size_t most);

/// How much the light of some lamps differs from that of others, in a box and without shadows: the
/// mean of the difference over the mean of the light.
double lampsDiffer(std::span<const Lamp> lamps, std::span<const Lamp> others, const Box3& box);

}  // namespace volute
