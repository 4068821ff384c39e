// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "volute/base/result.hpp"
#include "volute/grid/frame_source.hpp"

namespace volute {

/// What is known of a file that holds values and nothing else.
struct RawLayout {
  enum class Type { kUint8, kInt8, kUint16, kInt16, kUint32, kInt32, kFloat16, kFloat32, kFloat64 };

  std::array<int, 3> size{};  ///< voxels along x, y, z; x fastest
  int channels = 1;           ///< 1 or 3, of a voxel side by side
  Type type = Type::kFloat32;
  bool bigEndian = false;
  std::uint64_t offset = 0;  ///< [bytes] before the first value of each file
};

/// How to read a volume.
struct SourceOptions {
  std::string grid;            ///< which grid or array; empty: the only one, else `usualGrid`
  std::optional<Box3> bounds;  ///< [m] outer voxel faces: states them (.npy), or crops and pads to
                               ///< them on the voxel grid
  std::uint64_t maxMemory = std::uint64_t{4} << 30;  ///< [bytes] that one frame may take
  bool byLayers = false;          ///< a frame may take more: who reads it takes some layers at a time
  std::optional<RawLayout> raw{};  ///< the files have no header, and this is what it would say
  std::string usualGrid = "density";                 ///< which of several, when none is named
  std::function<void(const std::string&)> remark{};  ///< receives what was taken and what was left
};

/// Opens a sequence of volumes by what `input` is: a .npy or .vdb file, a pattern of such files
/// (flame_%04d.vdb, flame_####.npy) or a folder of numbered ones; a .vti file or pattern; a
/// .pvd collection of .vti files. The source streams: it holds one frame at most. Values come as
/// they are in the file, NaN and infinities included.
[[nodiscard]] Result<std::unique_ptr<FrameSource>> openSource(const std::filesystem::path& input,
                                                              const SourceOptions& options);

/// The kind of the numbered files in a folder that are volumes: ".vdb" or ".npy"; ".vdb" where there
/// are none. kInvalidArgument where there are both.
[[nodiscard]] Result<std::string> volumesIn(const std::filesystem::path& folder);

}  // namespace volute
