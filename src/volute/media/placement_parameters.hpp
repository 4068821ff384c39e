// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "volute/media/field_sliders.hpp"
#include "volute/media/placement.hpp"

namespace volute {

/// A volume's "transform" as a person says it: every point of the volume is mirrored (x), scaled
/// along the volume's axes and turned, all about the volume's middle, which then is put in its
/// place.
struct PlacementWords {
  Vec3 middle = Vec3::Zero();  ///< in the scene [m]
  Vec3 turn = Vec3::Zero();    ///< [degrees] about the scene's x, then y, then z; |y| <= 90
  Vec3 scale = Vec3::Ones();   ///< > 0
  bool mirrored = false;
};

/// @param fileBounds  of the volume before its transform [m]; empty: its middle is its origin
PlacementWords wordsOf(const Placement& placement, const Box3& fileBounds);

/// The 16 numbers of a transform, row-major. wordsOf() of it gives `words` back but for rounding.
nlohmann::ordered_json transformOf(const PlacementWords& words, const Box3& fileBounds);

/// "transform/middle", "transform/turn", ..
void addPlacement(ParameterGroup& group, const Placement& placement, const Box3& fileBounds);

/// Sets one of those in a volume's JSON; a transform that does nothing goes.
void setPlacement(nlohmann::ordered_json& volume, const Placement& placement,
                  const Box3& fileBounds, const std::string& key, const std::vector<double>& value);

}  // namespace volute
