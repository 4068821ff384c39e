// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "volute/lighting/diffuse_light.hpp"
#include "volute/lighting/lamp.hpp"
#include "volute/tetmesh/tet_locator.hpp"

namespace volute {

/// How much of a lamp's light comes to each vertex of a mesh through the smoke: e^-depth of the
/// straight way, exact for the field; 0 where a wall is in the way. A lamp's cone is not in it: its
/// edge is sharper than the mesh. Staubli et al. 2005, section 4.3, read it off a picture from the
/// lamp instead.
///
/// Walls are what the light would have to leave the mesh for and enter it again, so that a lamp may
/// stand outside.
///
/// Walks from vertex to lamp through neighbours, in double; where the way meets an edge, the slow
/// twin does it.
class LampPaths {
 public:
  explicit LampPaths(std::shared_ptr<const TetLocator> locator);

  /// One share for each vertex. `extinction` [1/m], one for each vertex, finite and >= 0.
  std::vector<float> shares(std::span<const float> extinction, const Lamp& lamp) const;

  /// The same where light is linear between vertices: moved so that it is right in the mean of each
  /// tet (ShareFit).
  /// @param shares  those at vertices, also less what others take
  /// @param others  takes what is not the mesh's from shares at points; may be empty
  /// @param inside  so far inside of their tets others see the points [m]
  std::vector<float> means(
      std::span<const float> extinction, const Lamp& lamp, std::span<const float> shares,
      const std::function<void(std::span<const Vec3>, std::span<float>)>& others,
      double inside = 0) const;

  const std::shared_ptr<const TetLocator>& locator() const { return locator_; }

 private:
  std::int32_t firstTet(std::int32_t vertex, const Vec3& direction, bool& doubtful) const;

  std::shared_ptr<const TetLocator> locator_;
  std::vector<std::int32_t> begin_, around_;  ///< the tets around each vertex
};

/// The same from a point of `tet`, its faces included: `way` leads from there to the lamp, which is
/// in the mesh or not.
double lampShareAt(const TetLocator& locator, std::span<const float> extinction, const Segment& way,
                   std::int32_t tet, bool lampInside);

/// The optical depths of the same way through two smokes of one mesh, in one walk; infinity where
/// something is in the way.
std::array<double, 2> lampDepthsAt(const TetLocator& locator,
                                   const std::array<std::span<const float>, 2>& extinctions,
                                   const Segment& way, std::int32_t tet, bool lampInside);

/// The slow twin, one segment at a time: the depth of a way in the mesh and whether it leaves the
/// mesh and enters it again.
double lampShareReference(const TetLocator& locator, std::span<const float> extinction,
                          const Segment& way);

/// Radiance of infinitely thick smoke at each vertex, three each: lamps' light scattered once, the
/// same in all directions, plus `ambient` that comes from everywhere and is not attenuated.
/// `shares` has one list for each lamp. Albedo is the share of what smoke takes from light that it
/// sends on. `again`, what was scattered before, may be null.
std::vector<float> scatteredLight(std::span<const Vec3> points, std::span<const Lamp> lamps,
                                  std::span<const std::vector<float>> shares, const Rgb& albedo,
                                  const Rgb& ambient, const DiffuseLight* again = nullptr);

}  // namespace volute
