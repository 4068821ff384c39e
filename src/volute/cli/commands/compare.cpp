// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/compare.hpp"

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/image/compare.hpp"
#include "volute/io/image_file.hpp"
#include "volute/media/volume/volume_input.hpp"

namespace volute::cli {
namespace {

struct Figures {
  double rms = 0;
  double relativeRms = 0;
  double psnr = 0;
  double maxError = 0;
};

nlohmann::ordered_json bytesJson(const std::string& path) {
  const auto bytes = bytesOnDisk(path);
  return bytes ? nlohmann::ordered_json(*bytes) : nlohmann::ordered_json();
}

std::string bytesLine(const std::string& a, const std::string& b) {
  const auto text = [](const std::string& path) {
    const auto bytes = bytesOnDisk(path);
    return bytes ? bytesText(*bytes) : std::string("unknown");
  };
  return fmt::format("{} and {}", text(a), text(b));
}

Report compareReport(const Figures& figures, const std::string& a, const std::string& b) {
  Report report;
  report.add("rms", figures.rms)
      .add("relative_rms", figures.relativeRms)
      .add("psnr", jsonNumber(figures.psnr), fmt::format("{:.2f} dB", figures.psnr))
      .add("max_error", figures.maxError)
      .add("bytes", {bytesJson(a), bytesJson(b)}, bytesLine(a, b));
  return report;
}

Result<Figures> comparePictures(const std::string& a, const std::string& b) {
  VOLUTE_ASSIGN(const auto imageA, readImage(a));
  VOLUTE_ASSIGN(const auto imageB, readImage(b));
  VOLUTE_ASSIGN(const auto difference, compareImages(imageA, imageB));
  return Figures{difference.rms, difference.relativeRms, difference.psnr, difference.maxError};
}

Result<Figures> compareVolumes(const std::string& a, const std::string& b,
                               const Arguments& arguments, Context& context) {
  InputOptions options;
  options.grid = arguments.find<std::string>("field").value_or("");
  options.bounds = arguments.find<Box3>("bounds");
  options.partial = arguments.flag("partial");
  // A .volute file has one grid and its own bounds; the options speak of the other formats.
  const auto optionsFor = [&](const std::string& path) {
    return isVolutePath(path) ? InputOptions{.grid = "", .bounds = {}, .partial = options.partial}
                              : options;
  };
  VOLUTE_ASSIGN(auto first, openVolume(a, optionsFor(a), context));
  VOLUTE_ASSIGN(auto second, openVolume(b, optionsFor(b), context));
  if (const auto frames = arguments.find<FrameRange>("frames")) {
    VOLUTE_ASSIGN(first.source, selectFrames(std::move(first.source), *frames));
    VOLUTE_ASSIGN(second.source, selectFrames(std::move(second.source), *frames));
  }
  VOLUTE_ASSIGN(const auto difference, compare(*first.source, *second.source, context.progress));
  return Figures{difference.rms(), difference.relativeRms(), difference.psnr(),
                 difference.maxError};
}

Status runCompare(const Arguments& arguments, Context& context) {
  const std::string& a = arguments.positional(0);
  const std::string& b = arguments.positional(1);
  if (isPicturePath(a) != isPicturePath(b)) {
    return fail(ErrorCode::kInvalidArgument,
                "{} is a picture and {} is not; expected two pictures or two volumes",
                isPicturePath(a) ? a : b, isPicturePath(a) ? b : a);
  }
  VOLUTE_TRY(refuseIdle(arguments, {readKind(a), readKind(b)}));
  VOLUTE_ASSIGN(const auto figures, isPicturePath(a) ? comparePictures(a, b)
                                                     : compareVolumes(a, b, arguments, context));
  context.print(compareReport(figures, a, b));
  return {};
}

}  // namespace

Command compareCommand() {
  using enum ValueKind;
  return {
      .name = "compare",
      .summary = "Measures how far one volume or picture is from another",
      .examples = {"volute compare fire.npy fire.volute",
                   "volute compare before.png after.png --json"},
      .description =
          "Volumes are compared frame by frame in the order of their frames, pictures in linear "
          "values. The relative RMS is "
          "the RMS divided by the maximum minus the minimum of A; PSNR is -20 log10 of it "
          "(infinite, null in JSON, when "
          "they are equal). Both must have the same size.",
      .positionals = {{.name = "A", .help = "the original: a volume, or a picture (.png, .exr)"},
                      {.name = "B", .help = "what is compared with it"}},
      .options = {{.name = "frames",
                   .kind = kFrames,
                   .value = "A:B[:S]",
                   .help = "frames with numbers A <= n < B of both",
                   .kinds = {"volume", kVoluteKind}},
                  fieldOption("which one of files with several", {"volume"}),
                  {.name = "bounds",
                   .kind = kBounds,
                   .value = "X0,Y0,Z0,X1,Y1,Z1",
                   .help = "as for compress [m]",
                   .kinds = {"volume"}},
                  {.name = "partial",
                   .help = "use what is intact of a damaged .volute",
                   .kinds = {kVoluteKind}}},
      .run = runCompare};
}

}  // namespace volute::cli
