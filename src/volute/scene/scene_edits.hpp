// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "volute/base/result.hpp"
#include "volute/math/box.hpp"
#include "volute/math/vec.hpp"
#include "volute/media/camera_file.hpp"

namespace volute {

/// The camera of a scene, or a sign, a light or a clip comes, goes or moves, or so does a knot or a
/// layer of a fog's profile; a volume becomes a billboard, or a billboard a volume.
struct SceneEdit {
  enum class Kind {
    kAddSign,
    kAddSpot,  ///< a lamp that shines along `normal`
    kAddSun,
    kAddAmbient,
    kAddClipBox,    ///< around `bounds`
    kAddClipPlane,  ///< through `position`, without what is on the side of `normal`
    kDuplicate,     ///< of `path`, a little beside it
    kRemove,        ///< what is at `path`
    kPlace,         ///< a sign or a spot at `path` goes to `position` and `normal`
    kBillboard,  ///< the volume at `path` is shown as a billboard of the same size and brightness
    kVolume,     ///< the billboard at `path` is shown as a volume, likewise
    kCamera,     ///< becomes `camera`
  };

  Kind kind = Kind::kAddSign;
  std::string path{};            ///< "/signs/0", "/lights/1", "/media/0/profile/knots/2"
  Vec3 position = Vec3::Zero();  ///< of what is added or placed [m]
  Vec3 normal = Vec3::UnitX();   ///< away from the wall that it is on
  double reach = 10;             ///< [m] that a spot is to light
  Box3 bounds{};  ///< the file's, of what becomes a billboard or a volume, or of a box [m]
  CameraDescription camera{};
};

/// Applies an edit to a scene's JSON. Returns a sentence about it; kInvalidArgument if `path` has
/// no object of that kind, and for placing a light without a position.
[[nodiscard]] Result<std::string> applyEdit(nlohmann::ordered_json& json, const SceneEdit& edit);

}  // namespace volute
