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

#include "volute/base/remark.hpp"
#include "volute/base/result.hpp"
#include "volute/grid/frame_source.hpp"
#include "volute/grid/frustum_sampling.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {

/// The layout of a file without a header.
struct RawLayout {
  enum class Type { kUint8, kInt8, kUint16, kInt16, kUint32, kInt32, kFloat16, kFloat32, kFloat64 };

  std::array<int, 3> size{};  ///< voxels along x, y, z; x fastest
  int channels = 1;           ///< 1 or 3, interleaved
  Type type = Type::kFloat32;
  bool bigEndian = false;
  std::uint64_t offset = 0;  ///< [bytes] before the first value of each file
};

/// How to read a volume.
struct SourceOptions {
  std::string grid;            ///< grid or array to read; empty: the only one, else `usualGrid`
  std::optional<Box3> bounds;  ///< [m] outer voxel faces: states them (.npy), or crops and pads to
                               ///< them on the voxel grid
  std::uint64_t maxMemory = std::uint64_t{4} << 30;  ///< [bytes] that one frame may take
  bool byLayers = false;              ///< a frame may take more: the caller reads it by layers
  std::optional<RawLayout> raw{};     ///< layout of files without a header
  std::string usualGrid = "density";  ///< default grid of several
  std::optional<FrustumSampling> frusta{};      ///< how they are read; else they are refused
  bool upStated = false;                        ///< whatever files say of their up axes
  Offsets offsets = Offsets::kNone;             ///< what is read so: offsetOf() the source
  std::function<void(const Remark&)> remark{};  ///< receives remarks on chosen and ignored grids
};

/// Opens a sequence of volumes according to `input`: a .npy or .vdb file, a pattern of such files
/// (flame_%04d.vdb, flame_####.npy) or a folder of numbered ones; a .vti file or pattern; a
/// .pvd collection of .vti files. The source streams: it holds at most one frame. Values are as
/// in the file, including NaN and infinities.
[[nodiscard]] Result<std::unique_ptr<FrameSource>> openSource(const std::filesystem::path& input,
                                                              const SourceOptions& options);

/// By the name's end: .vdb, or .nvdb of NanoVDB.
bool isVdbPath(const std::filesystem::path& path);

/// The kind of the numbered volume files in a folder: ".vdb" or ".npy"; ".vdb" if there are none.
/// kInvalidArgument if there are both.
[[nodiscard]] Result<std::string> volumesIn(const std::filesystem::path& folder);

}  // namespace volute
