// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "volute/medium/any_medium.hpp"
#include "volute/viewer/view_scene.hpp"

namespace volute {

/// The values of the media where a ray meets a medium or a surface.
class MediumProbe {
 public:
  struct Medium {
    std::string name;
    double extinction = 0;       ///< [1/m], of the picture
    Rgb emission = Rgb::Zero();  ///< [radiance/m]
    double opticalDepth = 0;     ///< of the ray, up to the surface
  };

  struct Reading {
    Vec3 place = Vec3::Zero();
    Vec3 inside = Vec3::Zero();  ///< the same, a little before a surface
    bool onSurface = false;
    std::vector<Medium> media{};
  };

  /// Where `ray` meets a surface, else where most of its light comes from; nothing where it meets
  /// neither.
  /// @param size  [m], of the scene
  std::optional<Reading> read(const std::shared_ptr<const ViewScene>& scene, Segment ray,
                              double size);

 private:
  std::vector<std::vector<AnyMedium>> media_;  // of each medium of a snapshot,
  std::weak_ptr<const ViewScene> of_;          // this one
};

}  // namespace volute
