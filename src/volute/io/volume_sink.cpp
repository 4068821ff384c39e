// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/volume_sink.hpp"

#include <pthread.h>
#include <sys/mman.h>

#include <array>

#include "volute/base/file_name.hpp"
#include "volute/base/frame_name.hpp"
#include "volute/io/array_file.hpp"
#include "volute/io/lattice_sink.hpp"
#include "volute/io/npy.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {
namespace {

/// OpenVDB for this process. A library that it loads starts four threads at once, and where it gets
/// too few, or too little address space, it aborts or waits for ever: that is tried before.
Result<const LatticePlugin*> loadVdbWriter() {
  constexpr std::size_t kLibraries = std::size_t{72} << 20;
  static const Status room = []() -> Status {
    // Plain ones, which take no memory of their own.
    std::array<pthread_t, 4> threads{};
    std::size_t made = 0;
    while (made < threads.size() &&
           ::pthread_create(
               &threads[made], nullptr, [](void*) -> void* { return nullptr; }, nullptr) == 0)
      ++made;
    void* const space =
        ::mmap(nullptr, kLibraries, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    const bool fits = space != MAP_FAILED && ::munmap(space, kLibraries) == 0;
    for (std::size_t i = 0; i < made; ++i) ::pthread_join(threads[i], nullptr);
    if (fits && made == threads.size())
      return {};
    return fail(ErrorCode::kTooLarge,
                "OpenVDB cannot be loaded: it needs {} MiB of address space and four threads; "
                "raise the limits of this shell (ulimit -v, ulimit -u)",
                kLibraries >> 20);
  }();
  VOLUTE_TRY(room);
  return loadVdbPlugin();
}

}  // namespace

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
  const bool vdb = isVdbPath(output);
  if (!vdb && extension != ".vti" && extension != ".pvd") {
    return failFor("output", ErrorCode::kInvalidArgument,
                   "'{}' has an unknown format; expected {}.npy, %04d.vdb, %04d.nvdb, %04d.vti, "
                   ".pvd, .nc, .h5 or -{}",
                   output.string(), options.orVolute ? ".volute, " : "",
                   extension == ".volute" ? "; volute compress writes .volute files" : "");
  }
  VOLUTE_ASSIGN(const LatticePlugin* plugin, vdb ? loadVdbWriter() : loadVtkPlugin());
  return createLatticeSink(output, info,
                           plugin->makeWriter({.half = options.half, .offset = options.offset}));
}

Result<std::unique_ptr<CacheSink>> createCacheSink(const std::filesystem::path& output,
                                                   std::vector<GridTarget> grids,
                                                   FrameMetadata fileMetadata,
                                                   std::vector<KeptTarget> kept,
                                                   const VolumeInfo* frames) {
  VOLUTE_ASSIGN(const LatticePlugin* plugin, loadVdbWriter());
  const VolumeInfo numbers = frames ? *frames : grids.front().info;
  return createLatticeCacheSink(output, numbers, std::move(grids), std::move(fileMetadata),
                                std::move(kept), plugin->makeWriter({}));
}

}  // namespace volute
