// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/math/box.hpp"
#include "volute/media/field.hpp"
#include "volute/media/medium_snapshot.hpp"

namespace volute {

/// A plane, of whose two sides the one that `normal` points to is left out.
struct ClipPlane {
  Vec3 point = Vec3::Zero();    ///< [m]
  Vec3 normal = Vec3::UnitX();  ///< of any length
};

/// The "clip" of a scene: the part of the media that is shown, which is in all boxes and behind all
/// planes. Light is that of the whole media, as in a building that is cut open for a view.
struct SceneClip {
  std::vector<Box3> boxes;
  std::vector<ClipPlane> planes;

  bool empty() const { return boxes.empty() && planes.empty(); }

  bool holds(const Vec3& point) const;

  /// The part of a segment that is shown.
  Segment part(const Segment& segment) const;
};

/// Tables of members, one for each kind of clip.
std::span<const FieldTable* const> clipTables();

[[nodiscard]] Result<SceneClip> parseClip(const nlohmann::json& json, const FieldOrigin& origin);

/// The medium where the clip shows it, exact to the plane; walls, lamps and contours as before.
std::shared_ptr<const MediumSnapshot> clipped(std::shared_ptr<const MediumSnapshot> medium,
                                              std::shared_ptr<const SceneClip> clip);

/// By what it is clipped; null: it is not.
const SceneClip* clipOf(const MediumSnapshot& medium);

/// What clipped() was given; the medium itself where it is not clipped.
const MediumSnapshot& unclipped(const MediumSnapshot& medium);

}  // namespace volute
