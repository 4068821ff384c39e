// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <nlohmann/json.hpp>

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/cli/ranks.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/fds/smv_index.hpp"
#include "volute/io/volume_source.hpp"
#include "volute/volume_files/volume_extraction.hpp"
#include "volute/volume_files/volume_input.hpp"
#include "volute/volume_files/volume_writer.hpp"

namespace volute::cli {
namespace {

Status checkExtraction(const std::string& path, const std::string& target, Context& context) {
  if (!isSmvPath(path) && !isVolutePath(path)) {
    return fail(ErrorCode::kInvalidArgument,
                "'{}' does not end in .volute or .smv; 'extract' reads such files alone", path);
  }
  if (isSmvPath(path) && context.team.size() > 1) {
    return fail(ErrorCode::kUnsupported,
                "{}: an FDS case is taken out by one process; leave mpirun out", path);
  }
  return checkTarget(target, context);
}

Status runExtract(const Arguments& arguments, Context& context) {
  const std::string& path = arguments.positional(0);
  const auto target = arguments.get<std::string>("output");
  VOLUTE_TRY(refuseIdle(arguments, {readKind(path)}));
  VOLUTE_TRY(checkExtraction(path, target, context));
  if (arguments.given("fps") && !statesTimes(target)) {
    return fail(ErrorCode::kInvalidArgument,
                "--fps: '{}' does not say when its frames are shown; leave it out", target);
  }
  const auto stats = arguments.find<std::string>("stats");
  const ExtractionRequest request{
      .fields = arguments.find<std::string>("field").value_or(""),
      .frames = arguments.find<FrameRange>("frames").value_or(FrameRange{}),
      .region = arguments.find<Region>("region"),
      .level = arguments.get<int>("level"),
      .framesPerSecond = arguments.find<double>("fps"),
      .partial = arguments.flag("partial"),
      .taken = stats ? std::vector{*stats} : std::vector<std::string>()};
  const bool several = isSmvPath(path) ? namesEachMesh(target) : namesEachGrid(target);
  auto outputs = Json::array();  // of several
  const Extracted extracted = [&](const Report& report) -> Status {
    if (several)
      outputs.push_back(report.json());
    else
      VOLUTE_TRY(writeStats(arguments, context, report.json()));
    if (!several || !context.json)
      context.print(report);
    return {};
  };
  Status status = isSmvPath(path)
                      ? extractFds(path, target, request, extracted, context)
                      : extractVolute(path, target, request, extracted, context, context.team);
  // On the way to .vdb frames are read whole.
  if (!status && status.error().code == ErrorCode::kTooLarge && !request.region &&
      !isVdbPath(target))
    status.error().hints = {Hint::set("region").so("takes a part"), Hint::raise("max_memory")};
  VOLUTE_TRY(std::move(status));
  if (!several)
    return {};
  VOLUTE_TRY(writeStats(arguments, context, {{"outputs", outputs}}));
  if (context.json)
    context.printJson({{"outputs", outputs}});
  return {};
}

}  // namespace

Command extractCommand() {
  using enum ValueKind;
  return {
      .name = "extract",
      .summary = "Extracts frames, a region or a coarser level of a .volute file",
      .examples =
          {"volute extract fire.volute -o fire.npy",
           "volute extract case.smv -o smoke_{mesh}_%04d.vti",
           "volute extract fire.volute -o fire_%04d.vdb --frames 10:20",
           "volute extract cache.volute -o cache_%04d.vdb",
           "volute extract fire.volute -o - --frames 3 --region 0:32,0:32,16:48 | other-program"},
      .description =
          "Reads only the blocks needed, with at most 16 frames in memory at a time, and reports "
          "how "
          "many bytes were read and blocks decoded.\n\nLevel L divides the resolution by 2^L: it "
          "skips "
          "the finest levels of each block, which contain details smaller than 2^L voxels in "
          "space and 2^L frames in time, and averages cubes of 2^L voxels. It is a preview: means "
          "are accurate to some percent. Level 4 is the mean of each block, over all of its "
          "frames, "
          "and reads nothing but the index. Cubes that reach beyond the region count the "
          "background there, "
          "and the bounds grow with "
          "them.\n\nA .npy is float32 of shape (t,z,y,x) or (t,z,y,x,c), also for a single frame. "
          "With several grids, each .vdb file holds all of them, with the names, types, classes, "
          "transforms and metadata of the original cache; other files hold one grid, selected "
          "with --field, or one each, with {grid} in OUT.\n\nFor an FDS case it writes the "
          "extinction [1/m] at the stored times as voxels of the finest cell size, with zeros in "
          "obstructions; with {mesh} in OUT, each mesh separately.",
      .positionals = {{.name = "IN", .help = "a .volute file, or the .smv of an FDS case"}},
      .options = {outputOption("OUT",
                               ".npy, a pattern %04d.vdb, %04d.nvdb or %04d.vti with the frame's "
                               "number, .pvd, .nc or .h5 (netCDF-4, which is HDF5), or - for a "
                               ".npy on standard output"),
                  framesOption(),
                  fieldsOption("grids of a file with several; if not given, all; or the source of "
                               "an FDS case",
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
                  filesRateOption({kVoluteKind}),
                  statsOption({kVoluteKind}),
                  partialOption({kVoluteKind})},
      .ranks = true,
      .run = runExtract};
}

}  // namespace volute::cli
