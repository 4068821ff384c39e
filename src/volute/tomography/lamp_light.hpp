// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/capture/capture.hpp"
#include "volute/tomography/reconstruct.hpp"

namespace volute {

/// The light of lamps that a unit of extinction sends in any direction, if it scatters once and
/// evenly: albedo / (4 pi) times the sum over lamps of irradiance exp(-t), with t the optical depth
/// from the lamp.
/// @param extinction  [1/m], (z, y, x), interpolated between voxel centres; zero outside.
/// @return radiance, (z, y, x, 3); 0 for voxels where `wanted` is 0 (empty: all are wanted).
std::vector<float> lampSource(const CaptureLighting& lighting, const VolumeGeometry& geometry,
                              std::span<const float> extinction,
                              std::span<const float> wanted = {});

/// The extinction that sends the emission, by a fixed point: the light at each voxel follows from
/// the extinction before it. Where less than 2 % of the light arrives, too little is found rather
/// than too much.
/// @param emission  radiance per metre, (z, y, x, 3).
/// @return [1/m], (z, y, x).
std::vector<float> litExtinction(const CaptureLighting& lighting, const VolumeGeometry& geometry,
                                 std::span<const float> emission);

/// By how much a view's pixels would be brighter if the medium took nothing from its own light on
/// the way to the camera, 1 to 5; of pixel centres.
/// @return (height, width).
std::vector<float> selfAttenuation(const Camera& camera, const VolumeGeometry& geometry,
                                   std::span<const float> extinction,
                                   std::span<const float> emission);

/// A frame of smoke that lamps light.
struct LitReconstruction {
  Reconstruction fit;             ///< its volume is the light that is scattered, radiance per metre
  std::vector<float> extinction;  ///< [1/m], (z, y, x)
};

/// Single scattering by a fixed point: a linear reconstruction of the light that voxels send; the
/// extinction that sends it; pixels as they would be without attenuation on the way to the camera;
/// and again, four times.
/// @param views  become those without attenuation.
/// Errors: those of reconstruct(); kInvalidArgument without lamps.
[[nodiscard]] Result<LitReconstruction> reconstructLit(std::span<TomographyView> views,
                                                       std::span<const std::size_t> fitted,
                                                       const VolumeGeometry& geometry,
                                                       const TomographyOptions& options,
                                                       const CaptureLighting& lighting,
                                                       Progress& progress);

}  // namespace volute
