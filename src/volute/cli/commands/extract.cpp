// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/ranges.h>

#include <array>

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/codec/extract_source.hpp"
#include "volute/cli/ranks.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/media/volume/fds_input.hpp"
#include "volute/media/volume/volume_extraction.hpp"
#include "volute/media/volume/volume_grids.hpp"

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

/// A sink of one grid as one of several.
class OneGridSink final : public CacheSink {
 public:
  explicit OneGridSink(std::unique_ptr<FrameSink> sink) : sink_(std::move(sink)) {}

  Status writeFrame(std::span<const std::vector<float>> grids) override {
    return sink_->writeFrame(grids[0]);
  }

  Status finish() override { return sink_->finish(); }

 private:
  std::unique_ptr<FrameSink> sink_;
};

std::string withGrid(std::string target, const std::string& name) {
  const auto place = target.find("{grid}");
  return place == std::string::npos ? target : target.replace(place, 6, name);
}

/// One grid, to a file of any format.
Status extractOne(const std::string& path, const std::string& grid, const std::string& target,
                  const Arguments& arguments, Context& context) {
  VOLUTE_ASSIGN(auto reader, openVolute(path, arguments.flag("partial"), context, true, grid));
  VOLUTE_ASSIGN(auto extraction, extractionOf(arguments, reader->info(), context.maxMemory));
  const std::vector<int> positions = extraction.positions;
  VOLUTE_ASSIGN(auto source,
                ExtractSource::create(reader, std::move(extraction), context.progress));
  const VolumeInfo info = source->info();
  std::vector<std::unique_ptr<FrameSource>> sources;
  sources.push_back(std::move(source));
  const MakeSink make = [&]() -> Result<std::unique_ptr<CacheSink>> {
    VOLUTE_ASSIGN(auto sink, openSink(target, info));
    return std::make_unique<OneGridSink>(std::move(sink));
  };
  VOLUTE_TRY(extractFrames(sources, positions, make, context, context.team));
  std::array<std::uint64_t, 2> counts{reader->bytesRead(), reader->blocksDecoded()};
  VOLUTE_TRY(context.team.sum(counts));
  const Report report = extractReport(target, info, counts, reader->blocks().count());
  VOLUTE_TRY(writeStats(arguments, context, report.json()));
  context.print(report);
  return {};
}

/// Several grids, or one with what a cache says of it, to .vdb files.
Status extractCache(const std::string& path, const std::vector<std::string>& names,
                    const std::string& target, const VolumeInfo& frames,
                    const Arguments& arguments, Context& context) {
  Extraction extraction;
  VOLUTE_ASSIGN(extraction.positions,
                selectPositions(frames, arguments.find<FrameRange>("frames").value_or(FrameRange{})));
  extraction.level = arguments.get<int>("level");
  extraction.maxMemory = context.maxMemory;
  VOLUTE_ASSIGN(auto grids,
                openGrids(path, names, extraction, arguments.flag("partial"), context));
  const MakeSink make = [&] {
    return createCacheSink(target, grids.targets, grids.fileMetadata);
  };
  VOLUTE_TRY(extractFrames(grids.sources, grids.positions, make, context, context.team));
  std::array<std::uint64_t, 3> counts{};
  for (const auto& reader : grids.readers) {
    if (!reader)
      continue;
    counts[0] += reader->bytesRead(), counts[1] += reader->blocksDecoded();
    counts[2] += reader->blocks().count();
  }
  const std::uint64_t blocks = counts[2];
  VOLUTE_TRY(context.team.sum(counts));
  auto list = nlohmann::ordered_json::array();
  std::string text;
  for (const GridTarget& grid : grids.targets) {
    const VolumeInfo& info = grid.info;
    list.push_back({{"name", info.name},
                    {"size", {info.x, info.y, info.z}},
                    {"channels", info.channels},
                    {"half", grid.description.half}});
    text += fmt::format("\n  {:<16} {}", info.name,
                        info.x == 0 ? std::string("empty")
                                    : fmt::format("{} x {} x {}, {}{}", info.x, info.y, info.z,
                                                  grid.description.type,
                                                  grid.description.half ? " (half)" : ""));
  }
  Report report;
  report.add("output", target)
      .add("frames", grids.positions.size(), fmt::format("{}", grids.positions.size()))
      .add("grids", list, text)
      .add("bytes_read", counts[0], bytesText(counts[0]))
      .add("blocks_decoded", counts[1], fmt::format("{} of {}", counts[1], blocks));
  VOLUTE_TRY(writeStats(arguments, context, report.json()));
  context.print(report);
  return {};
}

/// Which grids go where.
Status extractVolute(const std::string& path, const std::string& target,
                     const Arguments& arguments, Context& context) {
  const std::string fields = arguments.find<std::string>("field").value_or("");
  VOLUTE_ASSIGN(const auto main, openVolute(path, arguments.flag("partial"), context, false));
  InputOptions input;
  input.partial = arguments.flag("partial");
  input.verify = false;  // who reads a grid says what is damaged
  VOLUTE_ASSIGN(const auto grids, VolumeGrids::open(path, input, context));
  VOLUTE_ASSIGN(const auto chosen, grids->choose(fields, path));
  std::vector<std::string> names;
  for (const std::size_t i : chosen) names.push_back(grids->grids()[i].name);
  const bool vdb = extensionOf(target) == ".vdb";
  const bool each = target.find("{grid}") != std::string::npos;
  const bool described = main->grids().size() > 1 || main->grid().description.has_value();
  if (names.size() > 1 || described) {
    if (arguments.given("region") && names.size() > 1) {
      return fail(ErrorCode::kInvalidArgument,
                  "--region is for one grid, as each has voxels of its own; {} has {}: choose one "
                  "with --field",
                  path, fmt::join(names, ", "));
    }
    if (vdb && !each && !arguments.given("region"))
      return extractCache(path, names, target, main->info(), arguments, context);
  }
  if (names.size() > 1 && !each) {
    return fail(ErrorCode::kInvalidArgument,
                "{} has {} grids ({}), and '{}' holds one: choose one with --field, put {{grid}} into "
                "the name, or write %04d.vdb files, which hold all",
                path, names.size(), fmt::join(names, ", "), target);
  }
  if (names.size() > 1 && context.json)
    return fail(ErrorCode::kInvalidArgument, "--json and {{grid}} do not go together");
  for (const std::size_t i : chosen) {
    const std::string& name = grids->grids()[i].name;
    if (grids->grids()[i].empty && names.size() > 1) {
      context.progress.remark(fmt::format("{}: '{}' is empty and is left out", path, name));
      continue;
    }
    VOLUTE_TRY(vdb && described && !arguments.given("region")
                   ? extractCache(path, {name}, withGrid(target, name), main->info(), arguments,
                                  context)
                   : extractOne(path, name, withGrid(target, name), arguments, context));
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
  return extractVolute(path, target, arguments, context);
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
           "volute extract cache.volute -o cache_%04d.vdb",
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
          "A .npy is float32 of shape (t,z,y,x) or (t,z,y,x,c), a single frame included. Of several "
          "grids each .vdb file holds all, with the names, types, classes, transforms and metadata of "
          "the cache that they come from; other files hold one, which --field chooses, or each its "
          "own, with {grid} in OUT.\n\n"
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
                  fieldsOption("which grids of a file with several, all without it; or which source "
                               "of an FDS case",
                               {kVoluteKind, "fds"}),
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
