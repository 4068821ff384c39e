// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/file_name.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/synth/hall_files.hpp"
#include "volute/synth/puffs.hpp"
#include "volute/synth/synth.hpp"
#include "volute/synth/valley_files.hpp"
#include "volute/volume_files/volume_input.hpp"
#include "volute/volume_files/volume_writer.hpp"

namespace volute::cli {
namespace {

/// 512 voxels on a side, 16 frames.
std::unique_ptr<FrameSource> puffsOf(const Arguments& arguments) {
  PuffOptions options;
  options.size = arguments.findGiven<int>("size").value_or(options.size);
  options.frames = arguments.findGiven<int>("frames").value_or(options.frames);
  options.seed = static_cast<std::uint32_t>(arguments.get<int>("seed"));
  return std::make_unique<PuffSource>(options);
}

Result<std::unique_ptr<FrameSource>> sourceOf(const Arguments& arguments, Context& context) {
  SynthOptions options;
  const int size = arguments.get<int>("size");
  if (size % 8 != 0)
    return fail(ErrorCode::kInvalidArgument, "--size: '{}' is not a multiple of 8", size);
  const std::string& kind = arguments.positional(0);
  if (kind == "puffs")
    return puffsOf(arguments);
  if (kind == "smoke") {
    options.kind = SynthKind::kSmoke;
  } else if (kind != "fire" && kind != "flame") {
    return fail(ErrorCode::kInvalidArgument,
                "'{}' is unknown; expected fire, flame, smoke, puffs, valley, hall or ball", kind);
  }
  options.channels = kind == "flame" || arguments.flag("scalar") ? 1 : 3;
  options.size = size;
  options.frames = arguments.get<int>("frames");
  options.seed = static_cast<std::uint32_t>(arguments.get<int>("seed"));
  VOLUTE_ASSIGN(auto source, SyntheticSource::create(options, context.progress));
  return source;
}

/// The valley is a folder of pictures, the hall and the ball are smoke on meshes of tets.
Status writeFiles(const Arguments& arguments, Report& report, Context& context) {
  const std::string& kind = arguments.positional(0);
  const auto target = arguments.get<std::string>("output");
  const auto seed = static_cast<std::uint32_t>(arguments.get<int>("seed"));
  const auto frames = arguments.findGiven<int>("frames");
  report.add("output", target);
  if (kind == "ball")
    return writeBall(target, seed);
  int written = 0;
  if (kind == "valley") {
    ValleyFiles files;
    files.seed = seed;
    files.size = arguments.get<Pixels>("pixels");
    files.frames = written = frames.value_or(1);
    files.mapSize = arguments.findGiven<int>("size").value_or(files.mapSize);
    files.geometry = arguments.flag("geometry");
    VOLUTE_TRY(writeValley(files, target, context.progress));
  } else {
    HallFiles files;
    files.seed = seed;
    files.steps = written = frames.value_or(files.steps);
    files.cell = arguments.get<double>("cell");
    files.interval = arguments.get<double>("interval");
    VOLUTE_TRY(writeHall(files, target, context.progress));
  }
  report.add("frames", written, fmt::format("{}", written));
  return {};
}

Status writeVolumes(const Arguments& arguments, Report& report, Context& context) {
  const auto target = arguments.get<std::string>("output");
  VOLUTE_TRY(checkTarget(target, context));
  VOLUTE_ASSIGN(auto source, sourceOf(arguments, context));
  const VolumeInfo& info = source->info();
  const bool sparse = isVolutePath(target) || isVdbPath(target);
  if (const std::uint64_t bytes = 4 * std::uint64_t{info.frameValues()};
      !sparse && bytes > context.maxMemory) {
    return fail(ErrorCode::kTooLarge,
                "{}: a frame of {} x {} x {} voxels needs {} MiB as an array, more than the {} MiB "
                "allowed; write .vdb or .volute",
                target, info.x, info.y, info.z, bytes >> 20, context.maxMemory >> 20);
  }
  const std::string provenance =
      fmt::format("synthesized {}, seed {}", arguments.positional(0), arguments.get<int>("seed"));
  VOLUTE_ASSIGN(auto writer, VolumeWriter::open({{source.get(), arguments.get<double>("rms")}},
                                                target, provenance, context, context.team));
  report.add("output", target);
  addSize(report, info);
  report.add("channels", info.channels, fmt::format("{}", info.channels));
  return writer.write(report);
}

Status runSynthesize(const Arguments& arguments, Context& context) {
  constexpr int kLargest = 128;  // of all but puffs
  const std::string& kind = arguments.positional(0);
  if (const int size = arguments.get<int>("size"); size > kLargest && kind != "puffs") {
    return fail(ErrorCode::kInvalidArgument,
                "--size: '{}' is more than {}; only puffs may have more", size, kLargest);
  }
  Report report;
  VOLUTE_TRY(kind == "valley" || kind == "hall" || kind == "ball"
                 ? writeFiles(arguments, report, context)
                 : writeVolumes(arguments, report, context));
  context.print(report);
  return {};
}

}  // namespace

Command synthesizeCommand() {
  using enum ValueKind;
  return {
      .name = "synthesize",
      .summary = "Synthesizes fire, smoke, a valley for fog or a hall on fire from a seed",
      .examples = {"volute synthesize fire -o fire.npy --size 64 --frames 48 --seed 7",
                   "volute synthesize smoke -o smoke_%04d.vdb --frames 10",
                   "volute synthesize puffs -o puffs_%04d.vdb --size 512 --frames 4",
                   "volute synthesize valley -o valley --pixels 640x360",
                   "volute synthesize hall -o hall.pvd", "volute synthesize hall -o hall.smv"},
      .description =
          "fire is emission in linear RGB [radiance/m], mostly empty and fast; flame is its "
          "luminance only; smoke is coloured density [1/m], slow and dense. The volume is a cube "
          "of 2 m, at 25 frames per second. The same seed gives the same values on every "
          "machine.\n\npuffs is a sparse density [1/m], twelve drifting puffs that fill one per "
          "cent "
          "of the cube: 16 frames of 512 voxels a side.\n\nvalley is a frame for volute fog, in a "
          "folder: color.exr, depth.exr, "
          "camera.json and the painted fogmap.png with --size pixels on each side; with --frames "
          "a flight: color_%04d.png, depth_%04d.exr and camera_%04d.json. The map's cells have a "
          "side of 512 m / size.\n\nhall is a hall of 28 x 12 x 6 m beside a room on fire, as a "
          "tetrahedral mesh with the field soot [g/m3], one .vtu file for each of --frames (31) "
          "times, --interval apart, or as an FDS case (-o hall.smv) with its burner, soot, "
          "temperature, CO, CO2 and O2; for volute render and volute visibility. It is a formula, "
          "not a simulation. ball is a ball of the same smoke in a box, one .vtu file.",
      .positionals = {{.name = "KIND",
                       .help = "fire, flame, smoke, puffs, valley, hall or ball",
                       .file = false}},
      .options = {{.name = "output",
                   .letter = 'o',
                   .kind = kFile,
                   .value = "OUT",
                   .help = ".npy, .volute, a pattern %04d.vdb or %04d.vti, or - for a .npy on "
                           "standard output, .nc, .h5; "
                           "the valley's folder; the hall's .pvd or .smv, the ball's .vtu",
                   .required = true},
                  {.name = "size",
                   .kind = kInteger,
                   .value = "N",
                   .help = "voxels on each side, a multiple of 8, at most 128, of puffs 4096; "
                           "pixels of the valley's map",
                   .initial = "64",
                   .least = 16,
                   .most = 4096},
                  {.name = "frames",
                   .kind = kInteger,
                   .value = "N",
                   .help = "number of frames",
                   .initial = "48",
                   .least = 1,
                   .most = 100000},
                  {.name = "geometry",
                   .help = "for valley: also write valley.glb, its surface as triangles"},
                  {.name = "seed",
                   .kind = kInteger,
                   .value = "S",
                   .help = "seed; another one gives another fire",
                   .initial = "1",
                   .least = 0,
                   .most = 2147483647},
                  {.name = "pixels",
                   .kind = kPixels,
                   .value = "WxH",
                   .help = "size of the valley's pictures [pixels]",
                   .initial = "640x360"},
                  {.name = "cell",
                   .kind = kNumber,
                   .value = "M",
                   .help = "cell size of the hall [m]",
                   .initial = "0.4",
                   .least = 0.1,
                   .most = 2},
                  {.name = "interval",
                   .kind = kNumber,
                   .value = "S",
                   .help = "time between the hall's frames [s]",
                   .initial = "5",
                   .positive = true},
                  {.name = "scalar", .help = "one channel instead of RGB"},
                  rmsOption("relative RMS error of a .volute", "0.001")},
      .run = runSynthesize};
}

}  // namespace volute::cli
