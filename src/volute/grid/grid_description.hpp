// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "volute/grid/grid_matrix.hpp"

namespace volute {

/// One entry of the metadata of a file of another program, or of a grid in it.
struct GridMetadata {
  std::string name;
  std::string type;   ///< as OpenVDB calls it: "string", "float", "vec3i", ...
  std::string value;  ///< its bytes; numbers are little endian

  bool operator==(const GridMetadata&) const = default;
};

using MetadataList = std::vector<GridMetadata>;

/// Lists of metadata of the frames of a sequence: most have the same one.
struct FrameMetadata {
  std::vector<MetadataList> lists{};  ///< each once
  std::vector<int>
      listOf{};  ///< of each frame a position in `lists`, -1: it has none; empty: all -1

  /// Of a frame; null where it has none.
  const MetadataList* at(int frame) const;

  /// Adds that of the next frame; null: it has none.
  void add(const MetadataList* list);

  /// Metadata of some frames, by their positions.
  FrameMetadata of(const std::vector<int>& positions) const;

  bool operator==(const FrameMetadata&) const = default;
};

/// GridDescription::gridClass of vectors whose components are each in the middle of the face before
/// the voxel along its own axis.
inline constexpr const char* kStaggered = "staggered";

/// The metadata of a grid of a cache, so that it can be restored exactly. Axes are in the order x,
/// y, z.
struct GridDescription {
  using Index = std::array<std::int64_t, 3>;

  std::string type = "float";          ///< of a value: float, double, vec3s or vec3d
  std::string gridClass{};             ///< "fog volume", "level set", kStaggered; empty: unknown
  bool half = false;                   ///< values are stored as 16-bit floats
  std::array<double, 3> background{};  ///< of each channel, where the cache has no voxels
  std::string map{};                   ///< OpenVDB's name of the kind of transform
  std::array<double, 3> voxelSize{};   ///< [m]
  std::array<double, 3> origin{};      ///< centre of the voxel with index 0 in the first frame [m]
  Index begin{};                       ///< index of the volume's first voxel in the first frame
  std::uint64_t voxels = 0;            ///< that are not empty, the most in any frame
  std::uint64_t memory = 0;            ///< [bytes] in OpenVDB's tree, the most in any frame
  FrameMetadata metadata{};            ///< a frame that has none does not have the grid
  /// How far the origin of each frame lies from that of the first [voxels]; empty: nowhere.
  std::vector<Index> shifts{};
  /// From index to world [m] in each frame, where that is not along the axes or no such shift.
  /// `voxelSize` and `origin` are then those of the first frame in a space of the grid's own, in
  /// which all frames have them, and there are no shifts. Else empty.
  std::vector<GridMatrix> matrices{};

  /// From that space to the world, in each frame; empty where there are no matrices.
  std::vector<GridMatrix> places() const;

  /// Whether its numbers are float32.
  bool isOfFloats() const { return type == "float" || type == "vec3s"; }

  /// The same of some frames, by their positions.
  GridDescription of(const std::vector<int>& positions) const;

  bool operator==(const GridDescription&) const = default;
};

}  // namespace volute
