// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/camera/camera.hpp"
#include "volute/image/image.hpp"
#include "volute/medium/any_medium.hpp"

namespace volute {

enum class Renderer {
  kReference,  ///< pieces and their composite, in double
  kCpu,  ///< the media's fast paths; agrees with the reference within 1e-5 of the brightest pixel,
         ///< and with sunlit fog within some 1e-3
};

/// A quantity shown instead of colour, in one channel.
enum class Aov {
  kNone,
  kOpticalDepth,   ///< the integral of the extinction along the pixel's ray, natural logarithm
  kTransmittance,  ///< exp(-optical depth)
  /// Depth along the view axis [m]: of the nearest opaque surface or, where media in front of it
  /// take more than half of the light, of the point where half is left; infinite where there is
  /// neither. Only for scenes.
  kDistance,
  kAlpha,  ///< 1 where a surface is opaque, else 1 - transmittance; only for scenes
};

struct RenderOptions {
  Renderer renderer = Renderer::kCpu;
  Rgb background = Rgb::Zero();  ///< linear radiance behind all media where no opaque surface is
  Aov aov = Aov::kNone;
  Box3 within{};  ///< of kDistance: around all media
  /// A linear RGB picture of the camera's size behind all media, including opaque surfaces and what
  /// is beyond them; replaces the background. Must outlive the call.
  const Image* behind = nullptr;
  /// Empty, or one value per pixel, row by row: 0 leaves the pixel black. Must outlive the call.
  std::span<const std::uint8_t> only = {};
};

struct RenderStats {
  std::uint64_t rays = 0;
  std::uint64_t segments = 0;  ///< passed to media: rays times media
  std::uint64_t pieces = 0;    ///< that were composited; fast paths make none
  double milliseconds = 0;
};

/// A picture of all media together: their emission, attenuated by all of them, and the background
/// seen through them. Overlapping media add up. One ray per pixel, through its centre.
///
/// @param opaqueDepth  empty, or the distance along each pixel's ray to the nearest opaque surface
/// [m], shape
///   (height, width), infinite where there is none: media behind it do not show. Its own light is
///   not in the picture; whoever drew it adds it, times the picture of Aov::kTransmittance.
/// @param stats  filled when it is not null.
/// @return the picture, the same for any number of threads; kCancelled when `progress` said so,
/// kInvalidArgument when
///   the size of opaqueDepth, of the picture behind or of `only` is not the camera's.
[[nodiscard]] Result<Image> render(const Camera& camera, std::span<const AnyMedium> media,
                                   const RenderOptions& options, Progress& progress,
                                   RenderStats* stats = nullptr,
                                   std::span<const float> opaqueDepth = {});

}  // namespace volute
