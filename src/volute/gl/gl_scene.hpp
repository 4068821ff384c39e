// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/lighting/lamp.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

namespace volute {

class GlPart;

/// A plane, of whose two sides media are shown on the one that `normal` points away from.
struct GlCut {
  Vec3 point = Vec3::Zero();    ///< [m]
  Vec3 normal = Vec3::UnitX();  ///< of any length
};

/// All media of a picture, whatever their kinds; glPart() in the headers of the kinds makes them.
struct GlScene {
  std::vector<std::shared_ptr<const GlPart>> parts{};
  TriangleScene shade{};  ///< surfaces that keep suns from the media that they light
  /// Of what the eye sees of the media; light goes through all of them.
  std::vector<GlCut> cuts{};

  /// With this factor on all extinctions: GlPart::scaled().
  GlScene scaled(double factor) const;
};

/// The boundary of a mesh as walls that reflect the light of lamps, seen from inside alone
/// (lookAtWalls() in media/smoke/smoke_walls).
struct GlWalls {
  std::shared_ptr<const TetMesh> mesh;
  GlScene media{};  ///< that the lamps shine through
  std::span<const Lamp> lamps{};
  Rgb color = Rgb::Ones();
  Rgb ambient = Rgb::Zero();
  TriangleScene blocks{};  ///< other things that stand in the light
};

}  // namespace volute
