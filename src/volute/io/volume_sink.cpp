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
  if (extension == ".npy")
    return NpySink::create(output, info);
  const bool vdb = extension == ".vdb";
  if (!vdb && extension != ".vti" && extension != ".pvd") {
    return fail(ErrorCode::kUnsupported,
                "{}: cannot write this kind of volume; expected .npy, a pattern such as "
                "smoke_%04d.vdb or smoke_%04d.vti, or .pvd",
                output.string());
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
