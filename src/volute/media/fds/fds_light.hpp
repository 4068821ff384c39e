// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/fds/fds_field.hpp"
#include "volute/fds/obstructions.hpp"
#include "volute/lighting/illumination.hpp"

namespace volute {

/// What lights the smoke of an FDS case.
struct FdsLamps {
  Illumination light{};      ///< its surfaces are those besides the obstructions
  Rgb albedo = Rgb::Zero();  ///< share of what smoke takes that it sends on
  double density = 1;        ///< the smoke is so many times as thick as the field
  /// Whose ranks hold a share of the field each; null: this holds all. Then there are no other
  /// media, and light is scattered once.
  Team* holders = nullptr;
};

/// Light that smoke scatters, the same in all directions, for FdsField::withLight(). What a
/// lamp sends is attenuated by the smoke on its straight way to the middle of each cell of gas,
/// exactly, and stopped by obstructions; a node has the mean of its lattice's cells of gas around
/// it. So shadows have edges a cell wide. Where ranks hold shares, each gets the light of its own
/// lattices, and the call is collective.
[[nodiscard]] Result<std::vector<std::shared_ptr<const FdsLight>>> fdsLight(
    const FdsField& field, const FdsObstructions& obstructions, const FdsLamps& lamps);

}  // namespace volute
