// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/compress.hpp"

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/cli/ranks.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/media/volume/volume_input.hpp"

namespace volute::cli {
namespace {

/// A PSNR of 50 dB.
constexpr double kUsualRms = 0.003;

ErrorTarget targetOf(const Arguments& arguments) {
  using Kind = ErrorTarget::Kind;
  if (const auto rms = arguments.find<double>("rms"))
    return {Kind::kRms, *rms};
  if (const auto psnr = arguments.find<double>("psnr"))
    return {Kind::kPsnr, *psnr};
  if (const auto ratio = arguments.find<double>("ratio"))
    return {Kind::kRatio, *ratio};
  if (const auto size = arguments.find<Bytes>("size"))
    return {Kind::kSize, static_cast<double>(size->count)};
  if (const auto most = arguments.find<double>("max-error"))
    return {Kind::kMaxError, *most};
  return {Kind::kRms, kUsualRms};
}

std::vector<std::string_view> modeNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const BlockMode& mode : allBlockModes()) all.push_back(shortName(mode));
    return all;
  }();
  return {names.begin(), names.end()};
}

/// @param inputBytes  of the files on disk, where all of them are in the result
Report compressReport(const std::string& target, const VolumeInfo& info,
                      const CompressReport& result, std::optional<std::uint64_t> inputBytes) {
  const double ratio = static_cast<double>(result.rawBytes) / static_cast<double>(result.fileBytes);
  const double speed = static_cast<double>(result.rawBytes) / 1e6 / std::max(result.seconds, 1e-9);
  Report report;
  report.add("output", target)
      .add("frames", info.frames, fmt::format("{}", info.frames))
      .add("size", {info.x, info.y, info.z},
           fmt::format("{} x {} x {} voxels", info.x, info.y, info.z))
      .add("channels", info.channels, fmt::format("{}", info.channels))
      .add("raw_bytes", result.rawBytes, bytesText(result.rawBytes))
      .add("bytes", result.fileBytes, bytesText(result.fileBytes))
      .add("ratio", jsonNumber(ratio), fmt::format("{:.4g} (of dense floats)", ratio));
  if (inputBytes) {
    const double onDisk = static_cast<double>(*inputBytes) / static_cast<double>(result.fileBytes);
    report.add("input_bytes", *inputBytes, bytesText(*inputBytes))
        .add("ratio_to_input", jsonNumber(onDisk), fmt::format("{:.4g} (of the files on disk)", onDisk));
  }
  report.add("relative_rms", result.relativeRms)
      .add("psnr", jsonNumber(-20 * std::log10(result.relativeRms)),
           fmt::format("{:.2f} dB", -20 * std::log10(result.relativeRms)))
      .add("max_error", result.maxError)
      .add("seconds", jsonNumber(result.seconds), fmt::format("{:.2f} s", result.seconds))
      .add("megabytes_per_second", jsonNumber(speed), fmt::format("{:.3g} MB/s", speed));
  return report;
}

/// The command line was checked, so what compress() still finds invalid is a target out of reach:
/// it could not, and that is not wrong usage.
Result<CompressReport> compressTo(const std::string& target, FrameSource& source,
                                  const CompressOptions& options, Context& context) {
  auto result = compress(source, target, options, context.progress, context.team);
  if (!result && result.error().code == ErrorCode::kInvalidArgument)
    result.error().code = ErrorCode::kUnsupported;
  return result;
}

Status runCompress(const Arguments& arguments, Context& context) {
  const std::string& path = arguments.positional(0);
  const auto target = arguments.get<std::string>("output");
  if (!isVolutePath(target)) {
    return fail(ErrorCode::kInvalidArgument, "--output: '{}' does not end in .volute", target);
  }
  if (context.team.leads())
    VOLUTE_TRY(checkTarget(target));
  InputOptions input;
  input.grid = arguments.find<std::string>("field").value_or("");
  input.bounds = arguments.find<Box3>("bounds");
  input.partial = arguments.flag("partial");
  VOLUTE_ASSIGN(auto volume, openVolume(path, input, context));
  auto source = std::move(volume.source);
  if (const auto frames = arguments.find<FrameRange>("frames")) {
    VOLUTE_ASSIGN(source, selectFrames(std::move(source), *frames));
  }
  CompressOptions options;
  options.target = targetOf(arguments);
  options.wavelet = arguments.get<std::string>("wavelet");
  options.fast = arguments.flag("fast");
  if (const auto mode = arguments.find<std::string>("block-mode"))
    options.mode = blockModeByName(*mode);
  options.provenance = std::filesystem::path(path).filename().string();
  options.maxMemory = context.maxMemory;
  if (const auto work = arguments.find<std::string>("work")) {
    options.work = *work;
    VOLUTE_TRY(checkFolderIsShared(*work, context.team));
  }
  VOLUTE_ASSIGN(const auto result, compressTo(target, *source, options, context));
  const bool whole = !arguments.given("frames") && !arguments.given("bounds");
  const Report report = compressReport(target, source->info(), result,
                                       whole ? bytesOnDisk(path) : std::nullopt);
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
          {"volute compress fire.npy", "volute compress fire.npy -o fire.volute --rms 0.001",
           "volute compress smoke_%04d.vdb -o smoke.volute --field density --psnr 50 --frames 10:60",
           "volute compress fire.volute -o small.volute --ratio 200"},
      .description =
          "Reads .npy of shape (z,y,x), (t,z,y,x) or (t,z,y,x,c) in float32 or float16, a VDB "
          "file, pattern or "
          "folder, .vti, .pvd, or .volute, and writes one .volute file. It reports what was "
          "reached, measured on "
          "what was written; without an option for it the relative RMS is at most 0.003. NaN and infinities are refused with the frame and voxel.\n\n"
          "Relative RMS is the RMS error over all voxels and channels, divided by the maximum "
          "minus the minimum of "
          "the whole original.",
      .positionals = {{.name = "INPUT",
                       .help = "a volume: .npy, .vdb, .vti, .pvd, .volute, a pattern or a folder"}},
      .options = {{.name = "output",
                   .letter = 'o',
                   .kind = kOutput,
                   .value = "OUT.volute",
                   .help = "the file to write",
                   .derived = ".volute"},
                  {.name = "rms",
                   .kind = kNumber,
                   .value = "R",
                   .help = "relative RMS error at most R; one of 1 keeps nothing; 0.003 unless another of these is given",
                   .most = 1,
                   .positive = true},
                  {.name = "psnr",
                   .kind = kNumber,
                   .value = "DB",
                   .help = "-20 log10 of the relative RMS at least DB [dB]",
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
                  fieldOption("which one of a file with several, or which source of an FDS case"),
                  {.name = "frames",
                   .kind = kFrames,
                   .value = "A:B[:S]",
                   .help = "frames with numbers A <= n < B, every S-th"},
                  {.name = "wavelet",
                   .kind = kChoice,
                   .value = "NAME",
                   .help = "transform of all blocks; auto: the best one for each",
                   .initial = "auto",
                   .choices = {"auto", "haar", "cdf53", "cdf97"}},
                  {.name = "fast",
                   .help = "fewer transforms to choose from: quicker, and a little larger"},
                  {.name = "block-mode",
                   .kind = kChoice,
                   .value = "SUPPORT:WAVELET:TIME",
                   .help = "one mode for all blocks, to compare: plain or shaped (with an exact "
                           "support), the wavelet, and how often time is halved",
                   .choices = modeNames()},
                  {.name = "bounds",
                   .kind = kBounds,
                   .value = "X0,Y0,Z0,X1,Y1,Z1",
                   .help = "outer voxel faces [m]: states those of a .npy, crops or pads others to "
                           "them on the voxel grid"},
                  {.name = "work",
                   .kind = kText,
                   .value = "FOLDER",
                   .help = "keep finished units here until the file is written: the same command, "
                           "with any number of ranks, goes on from them; ranks share the folder"},
                  statsOption(),
                  {.name = "partial", .help = "use what is intact of a damaged .volute"}},
      .oneOf = {{{"rms", "psnr", "ratio", "size", "max-error"}, false}},
      .ranks = true,
      .run = runCompress};
}

}  // namespace volute::cli
