// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/compare.hpp"

#include <algorithm>
#include <cmath>

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/image/colormap.hpp"
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
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();  ///< of each, of volumes
  std::string worst{};  ///< the frame with the greatest error, for people
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
  if (figures.frames.size() > 1)
    report.add("by_frame", figures.frames, figures.worst);
  return report;
}

/// Where two pictures differ: dark where they agree, bright where they differ most.
Status writeDifference(const std::string& target, const Image& errors) {
  const double most = *std::ranges::max_element(errors.pixels);
  return writeImage(target, extensionOf(target) == ".exr"
                                ? errors
                                : colorMapped(errors, ColorMap::kInferno, 0, most > 0 ? most : 1));
}

/// The largest difference of the channels of each pixel.
Image errorsOf(const Image& a, const Image& b) {
  Image errors(a.width, a.height, 1);
  const auto channels = static_cast<std::size_t>(a.channels);
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    float& error = errors.pixels[i / channels];
    error = std::max(error, std::abs(a.pixels[i] - b.pixels[i]));
  }
  return errors;
}

/// The largest difference of a frame along y, seen from the front: x to the right, z up.
Result<Image> errorsOf(FrameSource& a, FrameSource& b, int frame) {
  const VolumeInfo& info = a.info();
  std::vector<float> first(info.frameValues()), second(info.frameValues());
  VOLUTE_TRY(a.readFrame(frame, first));
  VOLUTE_TRY(b.readFrame(frame, second));
  Image errors(info.x, info.z, 1);
  for (std::size_t i = 0; i < first.size(); ++i) {
    const std::size_t voxel = i / static_cast<std::size_t>(info.channels);
    const int x = static_cast<int>(voxel % info.x), z = static_cast<int>(voxel / info.x / info.y);
    float& error = errors.at(x, info.z - 1 - z);
    error = std::max(error, std::abs(first[i] - second[i]));
  }
  return errors;
}

Result<Figures> comparePictures(const std::string& a, const std::string& b,
                                const Arguments& arguments) {
  VOLUTE_ASSIGN(const auto imageA, readImage(a));
  VOLUTE_ASSIGN(const auto imageB, readImage(b));
  VOLUTE_ASSIGN(const auto difference, compareImages(imageA, imageB));
  if (const auto target = arguments.find<std::string>("difference"))
    VOLUTE_TRY(writeDifference(*target, errorsOf(imageA, imageB)));
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
  std::vector<Difference> byFrame;
  VOLUTE_ASSIGN(const auto difference,
                compare(*first.source, *second.source, context.progress, &byFrame));
  Figures figures{difference.rms(), difference.relativeRms(), difference.psnr(),
                  difference.maxError};
  const auto& numbers = first.source->info().frameNumbers;
  for (std::size_t i = 0; i < byFrame.size(); ++i) {
    figures.frames.push_back({{"frame", numbers[i]},
                              {"rms", jsonNumber(byFrame[i].rms())},
                              {"max_error", jsonNumber(byFrame[i].maxError)}});
  }
  const auto worst = std::ranges::max_element(byFrame, {}, &Difference::rms);
  const auto at = static_cast<std::size_t>(worst - byFrame.begin());
  figures.worst = fmt::format("worst in frame {}: rms {:.6g}, max error {:.6g}", numbers[at],
                              worst->rms(), worst->maxError);
  if (const auto target = arguments.find<std::string>("difference")) {
    VOLUTE_ASSIGN(const auto errors,
                  errorsOf(*first.source, *second.source, static_cast<int>(at)));
    VOLUTE_TRY(writeDifference(*target, errors));
  }
  return figures;
}

Status runCompare(const Arguments& arguments, Context& context) {
  if (const auto target = arguments.find<std::string>("difference")) {
    if (!isPicturePath(*target)) {
      return fail(ErrorCode::kInvalidArgument,
                  "--difference: '{}' is of no known format; expected .png or .exr", *target);
    }
    VOLUTE_TRY(checkTarget(*target));
  }
  const std::string& a = arguments.positional(0);
  const std::string& b = arguments.positional(1);
  if (isPicturePath(a) != isPicturePath(b)) {
    return fail(ErrorCode::kInvalidArgument,
                "{} is a picture and {} is not; expected two pictures or two volumes",
                isPicturePath(a) ? a : b, isPicturePath(a) ? b : a);
  }
  VOLUTE_TRY(refuseIdle(arguments, {readKind(a), readKind(b)}));
  VOLUTE_ASSIGN(const auto figures, isPicturePath(a) ? comparePictures(a, b, arguments)
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
      .options = {{.name = "difference",
                   .kind = kOutput,
                   .value = "OUT.png",
                   .help = "a picture of where they differ: of volumes the frame that differs most, its "
                           "largest differences along y; .png in colours up to the largest, .exr as "
                           "it is"},
                  {.name = "frames",
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
