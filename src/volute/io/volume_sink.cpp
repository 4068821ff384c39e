// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/volume_sink.hpp"

#include "volute/io/lattice_sink.hpp"
#include "volute/io/npy.hpp"
#include "volute/io/plugin.hpp"

namespace volute {

Result<std::unique_ptr<FrameSink>> createSink(const std::filesystem::path& output,
                                              const VolumeInfo& info, const SinkOptions& options) {
  const std::string extension = output.extension().string();
  if (extension == ".npy" || output == "-")
    return NpySink::create(output, info);
  const bool vdb = extension == ".vdb";
  if (!vdb && extension != ".vti" && extension != ".pvd") {
    return fail(
        ErrorCode::kInvalidArgument,
        "output: '{}' has an unknown format; expected {}.npy, %04d.vdb, %04d.vti, .pvd or -{}",
        output.string(), options.orVolute ? ".volute, " : "",
        extension == ".volute" ? "; volute compress writes .volute files" : "");
  }
  VOLUTE_ASSIGN(const LatticePlugin* plugin, vdb ? loadVdbPlugin() : loadVtkPlugin());
  return createLatticeSink(output, info, plugin->makeWriter({.half = options.half}));
}

Result<std::unique_ptr<CacheSink>> createCacheSink(const std::filesystem::path& output,
                                                   std::vector<GridTarget> grids,
                                                   FrameMetadata fileMetadata) {
  VOLUTE_ASSIGN(const LatticePlugin* plugin, loadVdbPlugin());
  return createLatticeCacheSink(output, std::move(grids), std::move(fileMetadata),
                                plugin->makeWriter({}));
}

}  // namespace volute
