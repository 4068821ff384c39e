// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/base/team.hpp"
#include "volute/fds/fds_field.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/lighting/illumination.hpp"
#include "volute/lighting/lit_medium.hpp"

namespace volute {

/// What lights the smoke of an FDS case.
struct FdsLamps {
  Illumination light{};      ///< its `blocks` are those of `surfaces`
  TriangleScene surfaces{};  ///< the building and what else stands in the way
  Rgb albedo = Rgb::Zero();  ///< share of what smoke takes that it sends on, the same in all ways
  double density = 1;        ///< the smoke is so many times as thick as the field
  /// The team whose ranks hold a share of the field each, and then there are no other media and
  /// light is scattered once; null: this process holds all of it.
  Team* team = nullptr;
};

/// Smoke in the light of lamps that reach it through itself and other media, and in the light that
/// is the same everywhere. Where ranks hold shares each gets its own, in the light of the whole,
/// and the call is collective.
LitMedium litFds(const FdsField& field, const FdsLamps& lamps);

}  // namespace volute
