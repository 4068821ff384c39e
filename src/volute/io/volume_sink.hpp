// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <memory>

#include "volute/base/result.hpp"
#include "volute/grid/frame_source.hpp"

namespace volute {

/// How to write a volume.
struct SinkOptions {
  bool half = false;  ///< OpenVDB: store values as 16-bit floats
};

/// A sink by what `output` is: OUT.npy (float32, (t, z, y, x) or (t, z, y, x, 3)), or "-" for the
/// same on standard output; a pattern such as smoke_%04d.vdb or smoke_%04d.vti, one file a frame
/// with its number in the name (a plain name will do for one frame); OUT.pvd, which writes
/// OUT_0001.vti, ... and a list of them with their times. The grid or array is called info.name. No
/// file appears before finish().
[[nodiscard]] Result<std::unique_ptr<FrameSink>> createSink(const std::filesystem::path& output,
                                                            const VolumeInfo& info,
                                                            const SinkOptions& options = {});

}  // namespace volute
