// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/frame_name.hpp"
#include "volute/base/result.hpp"
#include "volute/math/box.hpp"

namespace volute {

/// The basis functions of a volume: `kBox` is constant in each voxel; `kTrilinear` interpolates
/// between voxel centres and falls to zero one voxel beyond the outer ones; `kCubic` are B-splines
/// of degree 3 at voxel centres, smooth to the second derivative, which reach two voxels beyond the
/// outer ones. Splines do not interpolate: they stay within the range of the values.
enum class Basis { kBox, kTrilinear, kCubic };

/// "box", "trilinear" or "cubic".
std::string_view basisName(Basis basis);

/// The basis of a name; nothing for any other name.
std::optional<Basis> basisNamed(std::string_view name);

/// A sequence of volumes without its values: sizes, bounds and times.
struct VolumeInfo {
  std::string name = "density";  ///< the grid's name
  std::string unit;              ///< of the values; empty if unknown
  int frames = 0;
  int z = 0, y = 0, x = 0;        ///< voxels
  int channels = 1;               ///< 1, or 3 for linear RGB
  Box3 bounds;                    ///< outer voxel faces [m]
  std::vector<int> frameNumbers;  ///< one per frame, ascending: the numbers of the input
  FrameScale frameScale{};        ///< what the frame numbers mean
  std::vector<double> times;      ///< [s], one per frame, ascending
  bool timesAssumed = false;      ///< the input states none, nor a rate
  Basis basis = Basis::kBox;
  bool levelSet = false;  ///< values are distances to a surface, negative inside
  char up = 0;            ///< axis that points upwards: 'x', 'y' or 'z'; 0: nobody says, z is taken

  std::size_t voxels() const { return static_cast<std::size_t>(z) * y * x; }

  std::size_t frameValues() const { return voxels() * channels; }

  std::size_t values() const { return frameValues() * frames; }

  std::uint64_t rawBytes() const { return 4ull * values(); }

  Vec3 voxelSize() const { return bounds.size().cwiseQuotient(Vec3(x, y, z)); }

  /// The number of the frame at a position, for people: "12", "1.25".
  std::string frameText(std::size_t position) const {
    return volute::frameText(frameNumbers[position], frameScale);
  }

  /// The frame shown at `time` [s]: each until the next one; the first before all, the last after
  /// all.
  int frameAt(double time) const;

  /// Sets the times from the frame numbers: the first frame is at 0 s.
  void setRate(double framesPerSecond);

  /// Fills in what an input does not state: frame numbers 0.., times from the first at 0 s with 25
  /// frames/s by their numbers, and bounds with cubic voxels whose longest side is 1 m.
  void fillDefaults();

  /// An error that names the field if sizes, bounds, numbers or times are inconsistent.
  [[nodiscard]] Status validate(const std::string& where) const;
};

}  // namespace volute
