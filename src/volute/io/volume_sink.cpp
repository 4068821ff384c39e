// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/volume_sink.hpp"

#include "volute/base/file_name.hpp"
#include "volute/base/frame_name.hpp"
#include "volute/io/array_file.hpp"
#include "volute/io/lattice_sink.hpp"
#include "volute/io/npy.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {

Status checkFormat(const std::filesystem::path& output, bool orVolute) {
  const std::string extension = extensionOf(output);
  if (extension == ".npy" || output == "-" || isArrayOutput(output) || isVdbPath(output) ||
      extension == ".vti" || extension == ".pvd")
    return {};
  return failFor("output", ErrorCode::kInvalidArgument,
                 "'{}' has an unknown format; expected {}.npy, %04d.vdb, %04d.nvdb, %04d.vti, "
                 ".pvd, .nc, .h5 or -{}",
                 output.string(), orVolute ? ".volute, " : "",
                 extension == ".volute" ? "; volute compress writes .volute files" : "");
}

Result<std::unique_ptr<FrameSink>> createSink(const std::filesystem::path& output,
                                              const VolumeInfo& info, const SinkOptions& options) {
  const std::string extension = extensionOf(output);
  const bool array = isArrayOutput(output);
  if ((extension == ".npy" || array) && namesSeries(output)) {
    return failFor("output", ErrorCode::kInvalidArgument,
                   "'{}' names a file for each frame, and a {} holds all frames; leave the frame "
                   "number out of the name",
                   output.string(), extension);
  }
  if (extension == ".npy" || output == "-")
    return NpySink::create(output, info, options.offset);
  if (array)
    return createArraySink(output, info, options.offset);
  VOLUTE_TRY(checkFormat(output, options.orVolute));
  const bool vdb = isVdbPath(output);
  VOLUTE_ASSIGN(const LatticePlugin* plugin, vdb ? loadVdbPlugin() : loadVtkPlugin());
  return createLatticeSink(output, info,
                           plugin->makeWriter({.half = options.half, .offset = options.offset}));
}

Result<std::unique_ptr<CacheSink>> createCacheSink(const std::filesystem::path& output,
                                                   std::vector<GridTarget> grids,
                                                   FrameMetadata fileMetadata,
                                                   std::vector<KeptTarget> kept,
                                                   const VolumeInfo* frames) {
  VOLUTE_ASSIGN(const LatticePlugin* plugin, loadVdbPlugin());
  const VolumeInfo numbers = frames ? *frames : grids.front().info;
  return createLatticeCacheSink(output, numbers, std::move(grids), std::move(fileMetadata),
                                std::move(kept), plugin->makeWriter({}));
}

}  // namespace volute
