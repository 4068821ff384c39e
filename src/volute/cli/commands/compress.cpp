// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/cli/ranks.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/values.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/io/raw_volume.hpp"
#include "volute/volume_files/grid_compression.hpp"

namespace volute::cli {
namespace {

/// Over all voxels: a PSNR of 50 dB.
constexpr double kRmsOverAll = 0.003;

bool rmsOverAll(const Arguments& arguments) {
  return arguments.get<std::string>("rms-over") == "all";
}

ErrorTarget targetOf(const Arguments& arguments) {
  using Kind = ErrorTarget::Kind;
  const Kind kRms = rmsOverAll(arguments) ? Kind::kRmsOverAll : Kind::kRms;
  if (const auto rms = arguments.find<double>("rms"))
    return {kRms, *rms};
  if (const auto psnr = arguments.find<double>("psnr"))
    return {Kind::kPsnr, *psnr};
  if (const auto ratio = arguments.find<double>("ratio"))
    return {Kind::kRatio, *ratio};
  if (const auto size = arguments.find<Bytes>("size"))
    return {Kind::kSize, static_cast<double>(size->count)};
  if (const auto most = arguments.find<double>("max-error"))
    return {Kind::kMaxError, *most};
  const auto word = arguments.findGiven<std::string>("quality");
  if (!word && rmsOverAll(arguments))
    return {kRms, kRmsOverAll};
  return std::ranges::find(kQualityWords, word.value_or("look"), &QualityWord::word)->target;
}

/// What --raw-size and the others say of files without a header.
Result<std::optional<RawLayout>> rawLayout(const Arguments& arguments) {
  const auto size = arguments.find<std::string>("raw-size");
  if (!size)
    return std::nullopt;
  VOLUTE_ASSIGN(auto raw, ofOption("raw-size", parseRawSize(*size)));
  raw.type = *rawTypeByName(arguments.get<std::string>("raw-type"));
  raw.bigEndian = arguments.get<std::string>("raw-order") == "big";
  if (arguments.given("raw-order") && raw.type <= RawLayout::Type::kInt8)
    return failFor("raw_order", ErrorCode::kInvalidArgument, "has no effect on values of one byte");
  if (const auto offset = arguments.find<Bytes>("raw-offset"))
    raw.offset = offset->count;
  return raw;
}

Status checkRmsOver(const Arguments& arguments) {
  if (!arguments.given("rms-over") || arguments.given("rms-of"))
    return {};
  for (const char* name : {"quality", "psnr", "ratio", "size", "max-error"}) {
    if (arguments.given(name))
      return fail(ErrorCode::kInvalidArgument,
                  "--rms-over has no effect with --{}; it is of --rms and --rms-of", name);
  }
  return {};
}

Status runCompress(const Arguments& arguments, Context& context) {
  const std::string& path = arguments.positional(0);
  const auto target = arguments.get<std::string>("output");
  if (!isVolutePath(target)) {
    return fail(ErrorCode::kInvalidArgument, "--output: '{}' does not end in .volute", target);
  }
  VOLUTE_TRY(checkRmsOver(arguments));
  VOLUTE_TRY(refuseIdle(arguments, {readKind(path)}));
  if (context.team.leads())
    VOLUTE_TRY(checkTarget(target));
  InputOptions input;
  input.grid = arguments.find<std::string>("field").value_or("");
  input.bounds = arguments.find<Box3>("bounds");
  input.partial = arguments.flag("partial");
  input.byLayers = true;
  input.offsets = Offsets::kAll;
  VOLUTE_ASSIGN(input.raw, rawLayout(arguments));
  GridCompression how;
  how.frames = arguments.find<FrameRange>("frames").value_or(FrameRange{});
  VOLUTE_ASSIGN(
      how.rms,
      ofOption("rms-of", parseGridRms(arguments.find<std::string>("rms-of").value_or(""))));
  how.stated.framesPerSecond = arguments.find<double>("fps");
  how.stated.up = arguments.find<std::string>("up").value_or(std::string(1, '\0')).front();
  how.rmsOverAll = rmsOverAll(arguments);
  how.keep = gridNames(arguments.find<std::string>("keep").value_or(""));
  const auto notFinite = arguments.get<std::string>("not-finite");
  if (notFinite != "refuse")
    how.notFinite = notFinite == "inactive" ? NotFinite::kInactive : NotFinite::kBackground;
  how.dropUncoded = arguments.get<std::string>("uncoded") == "drop";
  CompressOptions& options = how.options;
  options.target = targetOf(arguments);
  options.wavelet = arguments.get<std::string>("wavelet");
  if (arguments.flag("fast") && arguments.given("effort")) {
    return fail(ErrorCode::kInvalidArgument,
                "--fast: is the same as --effort {}; give one of the two", kFastEffort);
  }
  options.effort = arguments.flag("fast") ? kFastEffort : arguments.get<int>("effort");
  if (const auto access = arguments.find<std::string>("access"))
    options.access = *access == "frame" ? Access::kFrame : Access::kFilm;
  if (const auto mode = arguments.find<std::string>("block-mode"))
    options.mode = blockModeByName(*mode);
  options.provenance = std::filesystem::path(path).filename().string();
  options.maxMemory = context.maxMemory;
  if (const auto work = arguments.find<std::string>("work")) {
    options.work = *work;
    VOLUTE_TRY(checkFolderIsShared(*work, context.team));
  }
  VOLUTE_ASSIGN(const auto report, compressVolume(path, target, how, input, context, context.team));
  VOLUTE_TRY(writeStats(arguments, context, report.json()));
  context.print(report);
  return {};
}

}  // namespace

Command compressCommand() {
  using enum ValueKind;
  return {
      .name = "compress",
      .summary = "Compresses a sequence of volumes to a stated error or size",
      .examples =
          {"volute compress fire.npy", "volute compress fire.npy -o fire.volute --quality measure",
           "volute compress smoke_%04d.vdb -o smoke.volute --field density --psnr 50 --frames "
           "10:60",
           "volute compress cache -o cache.volute --rms-of velocity=0.01",
           "volute compress run.raw --raw-size 1024,1024,512 --raw-type float64 --raw-offset 256",
           "volute compress fire.volute -o small.volute --ratio 200"},
      .description =
          "Reads .npy and .npz of shape (z,y,x), (t,z,y,x) or (t,z,y,x,c), of floats, integers or "
          "bool, a VDB "
          "file, pattern or folder, .vti, .pvd, an array of .nc, .h5 or .zarr (run.nc:soot), "
          ".volute, or, with --raw-size, files without a "
          "header, and writes one .volute file. It keeps all grids of a VDB cache with their "
          "descriptions, each with an error relative to its own range, and those that hold no "
          "volume without loss; --size and --ratio are for "
          "the whole file. The error reported is measured on the written data. Values become "
          "float32, and those far from zero differences from a number in their middle: the "
          "rounding of float64 and of large integers counts in the errors, and a target finer than "
          "that is refused. NaN and infinities are refused, with grid, frame and voxel; --keep "
          "and "
          "--not-finite accept them.\n\nRelative RMS "
          "is the RMS error over the support, the voxels and channels that are active or not "
          "equal to the background, divided by the range of their values over all frames. If less "
          "than half of that range is left without the values beyond the .0001 and .9999 "
          "quantiles, "
          "or without up to a hundredth of them that lies far from all others, or one value or two "
          "that do (-999 for no data), however many, that is the range, "
          "and values far beyond it are kept exactly. A target is met by the voxels that differ "
          "from place to place: large parts of one value, or nearly of one, do not count for it. "
          "Which voxels are active, "
          "constant tiles and the background are kept without loss; what is empty stays exactly "
          "empty.\n\nWithout a target, pictures of the file look like those of the original: "
          "--quality "
          "look, a relative RMS of at most 0.0007 in which faint values are finer than strong "
          "ones, so that no haze shows where pictures are made brighter. draft (0.004, the same "
          "way) is smaller, and differences show in bright pictures. measure (0.0001, all "
          "values alike) is for numbers, about as near as those of 16-bit floats. Values of both "
          "signs "
          "are finest around 0: the surface of a level set, slow velocities, small differences.",
      .positionals = {{.name = "INPUT",
                       .help = "a volume: .npy, .npz, .vdb, .nvdb, .vti, .pvd, .nc, .h5, .zarr, "
                               ".volute, a pattern or a folder"}},
      .options =
          {outputOption("OUT.volute", "the file to write", ".volute"),
           {.name = "quality",
            .kind = kChoice,
            .value = "WORD",
            .help = "draft, look (pictures look the same) or measure (for numbers)",
            .initial = "look",
            .choices = {"draft", "look", "measure"}},
           rmsOption("relative RMS error at most R (1 keeps nothing)"),
           {.name = "rms-over",
            .kind = kChoice,
            .value = "WHAT",
            .help = "the voxels that the relative RMS is over: support, those that are active or "
                    "not equal to the background, relative to their range; or all, relative to "
                    "the maximum minus the minimum",
            .initial = "support",
            .choices = {"support", "all"}},
           {.name = "psnr",
            .kind = kNumber,
            .value = "DB",
            .help = "-20 log10 of the relative RMS over all voxels at least DB [dB]",
            .most = 200,
            .positive = true},
           {.name = "ratio",
            .kind = kNumber,
            .value = "F",
            .help = "float32 bytes / file bytes at least F",
            .positive = true},
           {.name = "size",
            .kind = kBytes,
            .value = "BYTES",
            .help = "file at most this large (500K, 20M)"},
           {.name = "max-error",
            .kind = kNumber,
            .value = "E",
            .help = "absolute error at most E at every voxel [unit of the values]",
            .positive = true},
           {.name = "rms-of",
            .kind = kText,
            .value = "NAME=R,...",
            .help = "relative RMS of individual grids of a cache"},
           fieldsOption("grids of a file with several; if not given, all; or the source of "
                        "an FDS case"),
           {.name = "uncoded",
            .kind = kChoice,
            .value = "WHAT",
            .help = "grids of a .vdb cache that hold no volume (integers, bool, masks, points): "
                    "keep them without loss, for extract and mount to give back, or drop them",
            .initial = "keep",
            .choices = {"keep", "drop"}},
           {.name = "keep",
            .kind = kText,
            .value = "NAME[,NAME]",
            .help = "grids of a .vdb cache to keep in this way though they are volumes, such as "
                    "those with NaN: they come back without loss, and are not shown"},
           {.name = "not-finite",
            .kind = kChoice,
            .value = "WHAT",
            .help = "NaN and infinities: refuse them, take the grid's background for them, or that "
                    "and make their voxels inactive, as a mask does",
            .initial = "refuse",
            .choices = {"refuse", "background", "inactive"}},
           framesOption(),
           {.name = "up",
            .kind = kChoice,
            .value = "AXIS",
            .help = "up axis of the files, which the .volute records; values and axes stay as "
                    "they are",
            .choices = {"x", "y", "z"},
            .aliases = {"file-up"}},
           filesRateOption(),
           {.name = "wavelet",
            .kind = kChoice,
            .value = "NAME",
            .help = "transform of all blocks; auto: the best one for each",
            .initial = "auto",
            .choices = {"auto", "haar", "cdf53", "cdf97"}},
           {.name = "effort",
            .kind = kInteger,
            .value = "N",
            .help = "1: fastest, to 9: smallest files; docs/codec-effort.md says what each does",
            .initial = "5",
            .least = kMinEffort,
            .most = kMaxEffort},
           {.name = "fast", .help = "the same as --effort 2"},
           {.name = "access",
            .kind = kChoice,
            .value = "WHAT",
            .help = "what is read most: frame, single frames, which then take about a third of the "
                    "time and bytes, of a file that may be larger; or film, all of them in "
                    "order; if not given, what costs next to nothing of both",
            .choices = {"frame", "film"}},
           {.name = "block-mode",
            .kind = kChoice,
            .value = "SUPPORT:WAVELET:TIME",
            .help = "use one mode for all blocks, for comparison: plain or shaped (with an "
                    "exact support), the wavelet, and the number of levels in time",
            .choices = blockModeNames()},
           {.name = "bounds",
            .kind = kBounds,
            .value = "X0,Y0,Z0,X1,Y1,Z1",
            .help = "outer voxel faces [m]: sets those of an array, crops or pads others on "
                    "the voxel grid"},
           {.name = "raw-size",
            .kind = kText,
            .value = "X,Y,Z[,C]",
            .help = "INPUT has no header: a file, or a pattern of numbered ones, with "
                    "frames of this size, x fastest, and C interleaved channels; the "
                    "length of a single file gives its number of frames"},
           {.name = "raw-type",
            .kind = kChoice,
            .value = "TYPE",
            .help = "type of the values without a header; rounded to float32",
            .initial = "float32",
            .choices = {rawTypeNames().begin(), rawTypeNames().end()},
            .beside = "raw-size"},
           {.name = "raw-order",
            .kind = kChoice,
            .value = "ORDER",
            .help = "byte order of the values without a header",
            .initial = "little",
            .choices = {"little", "big"},
            .beside = "raw-size"},
           {.name = "raw-offset",
            .kind = kBytes,
            .value = "BYTES",
            .help = "bytes before the first value of each file without a header; if not "
                    "given, 0",
            .beside = "raw-size"},
           {.name = "work",
            .kind = kText,
            .value = "FOLDER",
            .help = "keep finished units here until the file is written: the same command "
                    "continues from them, with any number of ranks; ranks share the folder"},
           statsOption(),
           partialOption({kVoluteKind})},
      .oneOf = {{{"quality", "rms", "psnr", "ratio", "size", "max-error"}, false},
                {{"wavelet", "block-mode"}, false}},
      .ranks = true,
      .run = runCompress};
}

}  // namespace volute::cli
