// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <array>

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/codec/extract_source.hpp"
#include "volute/cli/ranks.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/media/volume/fds_input.hpp"
#include "volute/media/volume/volume_input.hpp"

namespace volute::cli {
namespace {

Result<Extraction> extractionOf(const Arguments& arguments, const VolumeInfo& info,
                                std::uint64_t maxMemory) {
  Extraction extraction;
  VOLUTE_ASSIGN(extraction.positions,
                selectPositions(info, arguments.find<FrameRange>("frames").value_or(FrameRange{})));
  extraction.region =
      arguments.find<Region>("region").value_or(Region{{0, 0, 0}, {info.x, info.y, info.z}});
  extraction.level = arguments.get<int>("level");
  extraction.maxMemory = maxMemory;
  return extraction;
}

/// @param counts  bytes read, blocks decoded
Report extractReport(const std::string& target, const VolumeInfo& info,
                     std::span<const std::uint64_t, 2> counts, std::size_t blocks) {
  Report report;
  report.add("output", target)
      .add("frames", info.frames, fmt::format("{}", info.frames))
      .add("size", {info.x, info.y, info.z},
           fmt::format("{} x {} x {} voxels", info.x, info.y, info.z))
      .add("channels", info.channels, fmt::format("{}", info.channels))
      .add("bytes_read", counts[0], bytesText(counts[0]))
      .add("blocks_decoded", counts[1], fmt::format("{} of {}", counts[1], blocks));
  return report;
}

/// Where {mesh} stands in an output's name, the number of a mesh from 1.
std::string nameForMesh(std::string target, int mesh) {
  const auto place = target.find("{mesh}");
  return target.replace(place, 6, fmt::format("{:04}", mesh));
}

/// Voxels of extinction out of an FDS case: all meshes together, or one.
Status extractFds(const std::string& path, const std::string& target, std::optional<int> mesh,
                  const Arguments& arguments, Context& context) {
  VOLUTE_TRY(checkTarget(target, true));
  VOLUTE_ASSIGN(auto volume, openFdsVolume(path, arguments.find<std::string>("field").value_or(""),
                                           std::nullopt, mesh, context));
  const auto frames = arguments.find<FrameRange>("frames").value_or(FrameRange{});
  VOLUTE_ASSIGN(auto source, selectFrames(std::move(volume), frames));
  const VolumeInfo& info = source->info();
  VOLUTE_ASSIGN(auto sink, openSink(target, info));
  VOLUTE_TRY(copyFrames(*source, *sink, "extracting", context.progress));
  Report report;
  report.add("output", target)
      .add("frames", info.frames, fmt::format("{}", info.frames))
      .add("size", {info.x, info.y, info.z},
           fmt::format("{} x {} x {} voxels", info.x, info.y, info.z));
  context.print(report);
  return {};
}

Status runFds(const std::string& path, const std::string& target, const Arguments& arguments,
              Context& context) {
  if (target.find("{mesh}") == std::string::npos)
    return extractFds(path, target, std::nullopt, arguments, context);
  if (context.json)
    return fail(ErrorCode::kInvalidArgument, "--json and {{mesh}} do not go together");
  VOLUTE_ASSIGN(const SmvIndex index, SmvIndex::read(path));
  for (int mesh = 0; mesh < static_cast<int>(index.meshes.size()); ++mesh) {
    const Status status = extractFds(path, nameForMesh(target, mesh + 1), mesh, arguments, context);
    if (!status && status.error().code == ErrorCode::kNotFound) {
      context.progress.remark(status.error().message);
      continue;
    }
    VOLUTE_TRY(status);
  }
  return {};
}

Status runExtract(const Arguments& arguments, Context& context) {
  const std::string& path = arguments.positional(0);
  const auto target = arguments.get<std::string>("output");
  if (context.json && target == "-") {
    return fail(ErrorCode::kInvalidArgument,
                "--json and '--output -' both want standard output; leave one");
  }
  context.resultsToStderr = target == "-";
  VOLUTE_TRY(refuseIdle(arguments, {readKind(path)}));
  if (isSmvPath(path)) {
    if (context.team.size() > 1) {
      return fail(ErrorCode::kUnsupported,
                  "{}: an FDS case is taken out by one process; leave mpirun out", path);
    }
    return runFds(path, target, arguments, context);
  }
  if (!isVolutePath(path)) {
    return fail(ErrorCode::kInvalidArgument,
                "'{}' does not end in .volute or .smv; 'extract' reads such files alone", path);
  }
  if (context.team.leads())
    VOLUTE_TRY(checkTarget(target, true));
  VOLUTE_ASSIGN(auto reader, openVolute(path, arguments.flag("partial"), context));
  VOLUTE_ASSIGN(auto extraction, extractionOf(arguments, reader->info(), context.maxMemory));
  VOLUTE_ASSIGN(auto source,
                ExtractSource::create(reader, std::move(extraction), context.progress));
  std::unique_ptr<FrameSink> sink;
  if (context.team.leads()) {
    VOLUTE_ASSIGN(sink, openSink(target, source->info()));
  }
  VOLUTE_TRY(extractFrames(*source, sink.get(), context.maxMemory, context.progress, context.team));
  std::array<std::uint64_t, 2> counts{reader->bytesRead(), reader->blocksDecoded()};
  VOLUTE_TRY(context.team.sum(counts));
  const Report report = extractReport(target, source->info(), counts, reader->blocks().count());
  VOLUTE_TRY(writeStats(arguments, context, report.json()));
  context.print(report);
  return {};
}

}  // namespace

Command extractCommand() {
  using enum ValueKind;
  return {
      .name = "extract",
      .summary = "Takes frames, a region or a coarser level out of a .volute file",
      .examples =
          {"volute extract fire.volute -o fire.npy",
           "volute extract case.smv -o smoke_{mesh}_%04d.vti",
           "volute extract fire.volute -o fire_%04d.vdb --frames 10:20",
           "volute extract fire.volute -o - --frames 3 --region 0:32,0:32,16:48 | other-program"},
      .description =
          "Touches only the blocks that are needed, a row of 16 frames in memory at a time, and "
          "reports how many bytes "
          "were read and blocks decoded.\n\n"
          "Level L divides the resolution by 2^L: it leaves out the finest levels of each block, "
          "which hold what is smaller than 2^L voxels in space and 2^L frames in time, and "
          "averages "
          "cubes of 2^L voxels. It is a preview: means are right within some percent, and less so "
          "where a small body stands in empty space. Cubes that reach beyond the region count "
          "zeros "
          "there and the bounds grow with them.\n\n"
          "A .npy is float32 of shape (t,z,y,x) or (t,z,y,x,c), a single frame included.\n\n"
          "Of an FDS case it takes the extinction [1/m] at the stored times as voxels of the "
          "finest "
          "cell size, obstructions zero; with {mesh} in OUT, each mesh on its own.",
      .positionals = {{.name = "IN", .help = "a .volute file, or the .smv of an FDS case"}},
      .options = {{.name = "output",
                   .letter = 'o',
                   .kind = kOutput,
                   .value = "OUT",
                   .help = ".npy, a pattern %04d.vdb or %04d.vti with the frame's number, or - for "
                           "a .npy on standard output",
                   .required = true},
                  {.name = "frames",
                   .kind = kFrames,
                   .value = "A:B[:S]",
                   .help = "frames with numbers A <= n < B, every S-th"},
                  fieldOption("which source of an FDS case; 'volute info' names them", {"fds"}),
                  {.name = "region",
                   .kind = kRegion,
                   .value = "X0:X1,Y0:Y1,Z0:Z1",
                   .help = "voxels, half-open on each axis",
                   .kinds = {kVoluteKind}},
                  {.name = "level",
                   .kind = kInteger,
                   .value = "L",
                   .help = "divide the resolution by 2^L",
                   .initial = "0",
                   .least = 0,
                   .most = 4,
                   .kinds = {kVoluteKind}},
                  statsOption({kVoluteKind}),
                  {.name = "partial",
                   .help = "use what is intact of a damaged file",
                   .kinds = {kVoluteKind}}},
      .ranks = true,
      .run = runExtract};
}

}  // namespace volute::cli
