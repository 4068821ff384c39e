// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "bench/benchmark.hpp"
#include "volute/capture/capture.hpp"
#include "volute/synth/synth.hpp"
#include "volute/tomography/view.hpp"

namespace volute::bench {

/// What is filmed, and what a reconstruction of it is compared with.
struct FilmedScene {
  std::string name;
  VolumeGeometry geometry;   ///< of the unknown volume
  std::vector<float> truth;  ///< (z, y, x, 3) at that resolution
  std::vector<TomographyView> views;
  std::vector<Camera> others;      ///< 24 cameras between and beside those of the views
  std::vector<Image> otherImages;  ///< the truth through them

  /// The largest value of the views.
  float brightest() const;

  /// Adds normal noise of this sigma [radiance] to the views.
  void addNoise(double sigma);

  /// Stores the views as 8-bit sRGB, exposed so that this share of the lit pixels is saturated, and
  /// reads them back as a capture is read: as light, saturated pixels without weight.
  void storeAs8Bit(double saturatedShare);
};

/// How a reconstruction compares with the truth.
struct SceneQuality {
  double psnr = 0;      ///< of the other views, to their brightest value [dB]
  double relative = 0;  ///< L2 of the other views
  double volume = 0;    ///< relative L2
};

SceneQuality qualityOf(const FilmedScene& scene, std::span<const float> volume, Basis basis);

/// A made-up fire or smoke through 8 cameras of 180 x 144. All pictures are integrals through twice
/// the unknown volume's resolution (64^3) in the other basis.
[[nodiscard]] Result<FilmedScene> filmMadeUp(SynthKind kind, Progress& progress);

/// A frame of a capture, with the pictures that it has, beside its true volume. The other views are
/// integrals through the truth, trilinear, with 16 rays a pixel.
/// @param truth  a volume sequence with the capture's frames, or with one frame for each of them.
/// @param grid  of its files; empty: the only one.
[[nodiscard]] Result<FilmedScene> filmCapture(const Capture& capture, int frame,
                                              const std::string& truth, const std::string& grid,
                                              std::uint64_t maxMemory, Progress& progress);

}  // namespace volute::bench
