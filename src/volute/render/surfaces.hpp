// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/camera/camera.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/image/image.hpp"
#include "volute/lighting/lamp.hpp"
#include "volute/medium/any_medium.hpp"

namespace volute {

/// Writes the optical depths of segments.
using DepthsAlong = std::function<void(std::span<const Segment>, std::span<double>)>;

/// What decides how surfaces look.
struct SurfaceScene {
  const TriangleScene& geometry;
  std::span<const Lamp> lamps = {};
  Rgb ambient = Rgb::Zero();  ///< radiance that comes from everywhere, whatever is in the way
  std::span<const AnyMedium> media = {};  ///< take from lamps' light on its way to a surface
  bool shadows = true;  ///< else nothing takes from lamps' light: quick, for previews
  /// Empty, or the optical depth of more that takes from it, asked for from one thread and for many
  /// segments at once: several processes may answer together.
  DepthsAlong more{};
};

/// What opaque surfaces look like from a camera, without the media before them.
struct SurfaceView {
  std::vector<float> depth;  ///< of each pixel, along its ray; infinite where there is none
  Image color;               ///< linear RGB radiance, black where there is none
};

/// The nearest surface in each pixel, as render() takes it.
struct SurfacePicture {
  Image color;               ///< linear RGB radiance; the background where there is no surface
  std::vector<float> depth;  ///< along each pixel's ray [m], infinite where there is none
  std::uint64_t surfacePixels = 0;
  std::uint64_t shadowRays = 0;
};

/// What a surface at a point sends back along `ray` (Lambert):
///   emission + base color / pi * sum over lamps of irradiance cos V exp(-t) + base color * ambient
/// with V = 0 behind other surfaces, else 1, and t the optical depth of all media to the lamp,
/// exact. Only the side that the ray meets is lit.
///
/// One ray for each pixel, through its centre, so that edges are not smoothed and fit the media's.
/// @param only  empty, or one for each pixel: 0 leaves it out, as if no surface were there
/// @return the same for any number of threads; kCancelled when `progress` said so.
[[nodiscard]] Result<SurfacePicture> renderSurfaces(const Camera& camera, const SurfaceScene& scene,
                                                    const Rgb& background, Progress& progress,
                                                    std::span<const std::uint8_t> only = {});

/// The normal of what a segment meets, towards the side from which the segment comes.
Vec3 facing(const TriangleScene& geometry, const Segment& segment, const Hit& hit);

/// The same for any segments: where each meets a surface first and what comes back from there; no
/// light and an infinite distance where it meets none.
struct SurfacePoint {
  Hit hit;
  Rgb radiance = Rgb::Zero();
};

std::vector<SurfacePoint> lookAtSurfaces(const SurfaceScene& scene,
                                         std::span<const Segment> segments,
                                         std::uint64_t* shadowRays = nullptr);

}  // namespace volute
