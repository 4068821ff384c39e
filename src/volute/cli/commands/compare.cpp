// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/compare.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/image/colormap.hpp"
#include "volute/io/frame_file.hpp"
#include "volute/io/image_file.hpp"
#include "volute/volume_files/volume_comparison.hpp"

namespace volute::cli {
namespace {

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

/// @param measured  else there were no numbers to compare, and people read none
Report compareReport(const ImageDifference& whole, const std::string& a, const std::string& b,
                     bool measured = true) {
  const auto of = [&](std::string text) { return measured ? std::move(text) : std::string(); };
  Report report;
  report.add("rms", jsonNumber(whole.rms), of(fmt::format("{:.6g}", whole.rms)))
      .add("relative_rms", jsonNumber(whole.relativeRms),
           of(fmt::format("{:.6g}", whole.relativeRms)))
      .add("psnr", psnrJson(whole.psnr), of(fmt::format("{:.2f} dB", whole.psnr)))
      .add("max_error", jsonNumber(whole.maxError), of(fmt::format("{:.6g}", whole.maxError)))
      .add("bytes", {bytesJson(a), bytesJson(b)}, bytesLine(a, b));
  return report;
}

/// Where two pictures differ: dark where they agree, bright where they differ most.
Status writeDifference(const std::string& target, const Image& errors) {
  const double most = *std::ranges::max_element(errors.pixels);
  return writeImage(target, extensionOf(target) == ".exr"
                                ? errors
                                : colorMapped(errors, ColorMap::kInferno, 0, most > 0 ? most : 1));
}

/// What else two pictures differ in: pixels of another shape, other windows.
Status remarkOnWindows(const std::string& a, const std::string& b, Progress& progress) {
  if (extensionOf(a) != ".exr" || extensionOf(b) != ".exr")
    return {};
  VOLUTE_ASSIGN(const auto infoA, readFrameInfo(a));
  VOLUTE_ASSIGN(const auto infoB, readFrameInfo(b));
  if (infoA.parts.empty() || infoB.parts.empty())
    return {};
  const FramePart &partA = infoA.parts.front(), &partB = infoB.parts.front();
  const auto window = [](const PixelWindow& w) {
    return fmt::format("{}..{} x {}..{}", w.left, w.right - 1, w.top, w.bottom - 1);
  };
  const auto differ = [&](std::string_view what, const std::string& of, const std::string& other) {
    if (of != other)
      progress.remark(
          {RemarkCode::kDoubtful, fmt::format("{}: {} in {}, {} in {}; stored pixels are compared",
                                              what, of, a, other, b)});
  };
  differ("shape of a pixel, width / height", fmt::format("{:g}", partA.pixelAspect),
         fmt::format("{:g}", partB.pixelAspect));
  differ("data window", window(partA.data), window(partB.data));
  differ("display window", window(partA.display), window(partB.display));
  return {};
}

void remarkOnNumbers(const std::string& file, const Image& image, Progress& progress) {
  const auto count = std::ranges::count_if(image.pixels, [](float v) { return !std::isfinite(v); });
  if (count > 0)
    progress.remark(
        {RemarkCode::kDoubtful, fmt::format("{}: {} of {} values are no numbers, or infinite", file,
                                            count, image.pixels.size())});
}

constexpr const char* kOfColors = "rms, PSNR and max error are of the colours";

/// Adds the largest difference in alpha, where both have it.
Status compareAlpha(const std::string& a, const std::string& b, const ImageReadOptions& options,
                    Report& report, Progress& progress) {
  VOLUTE_ASSIGN(const auto alphaA, readAlpha(a, options));
  VOLUTE_ASSIGN(const auto alphaB, readAlpha(b, options));
  if (alphaA.has_value() != alphaB.has_value()) {
    progress.remark({RemarkCode::kDoubtful, fmt::format("{}: has alpha, {} has none: the colours "
                                                        "alone are compared",
                                                        alphaA ? a : b, alphaA ? b : a)});
  }
  if (!alphaA || !alphaB)
    return {};
  VOLUTE_ASSIGN(const auto difference, compareImages(*alphaA, *alphaB));
  report.add("alpha_max_error", difference.maxError);
  if (difference.maxError != 0)
    progress.remark({RemarkCode::kDoubtful, fmt::format("alpha differs by up to {:.6g}; {}",
                                                        difference.maxError, kOfColors)});
  return {};
}

/// Channels of a .exr besides those of one picture: layers, depths, optical depths.
std::vector<FrameChannel> besides(const FrameInfo& info) {
  constexpr std::string_view kPicture[] = {"R", "G", "B", "A", "Y"};
  std::vector<FrameChannel> others;
  for (const FrameChannel& channel : info.channels) {
    if (info.channels.size() > 1 && std::ranges::find(kPicture, channel.name) == std::end(kPicture))
      others.push_back(channel);
  }
  return others;
}

/// The largest difference of two pictures of one size; what is the same, infinite or no number, is
/// none.
double farthestApart(const Image& a, const Image& b) {
  double farthest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const double one = a.pixels[i], other = b.pixels[i];
    const bool same = one == other || (std::isnan(one) && std::isnan(other));
    const double apart = same ? 0 : std::abs(one - other);
    if (std::isnan(apart))
      return apart;
    farthest = std::max(farthest, apart);
  }
  return farthest;
}

/// Adds the largest difference of each other channel that both have.
Status compareOthers(const std::string& a, const std::string& b, std::uint64_t maxMemory,
                     Report& report, Progress& progress) {
  if (extensionOf(a) != ".exr" || extensionOf(b) != ".exr")
    return {};
  VOLUTE_ASSIGN(const auto infoA, readFrameInfo(a));
  VOLUTE_ASSIGN(const auto infoB, readFrameInfo(b));
  const auto ofA = besides(infoA), ofB = besides(infoB);
  const auto aloneIn = [&](const auto& own, const auto& other, const std::string& file) {
    std::vector<std::string> names;
    for (const FrameChannel& one : own) {
      if (std::ranges::find(other, one.name, &FrameChannel::name) == other.end())
        names.push_back(one.name);
    }
    if (!names.empty())
      progress.remark(
          {RemarkCode::kLeftOut, fmt::format("{} alone has {}", file, fmt::join(names, ", "))});
  };
  aloneIn(ofA, ofB, a);
  aloneIn(ofB, ofA, b);
  auto all = nlohmann::ordered_json::object();
  std::string text;
  std::vector<std::string> differing;
  for (const FrameChannel& one : ofA) {
    const auto other = std::ranges::find(ofB, one.name, &FrameChannel::name);
    if (other == ofB.end())
      continue;
    VOLUTE_ASSIGN(const auto first, readFrameChannels(a, {&one, 1}, maxMemory));
    VOLUTE_ASSIGN(const auto second, readFrameChannels(b, {&*other, 1}, maxMemory));
    if (first.width != second.width || first.height != second.height) {
      return fail(ErrorCode::kInvalidData,
                  "channel '{}' has {} x {} pixels in {} and {} x {} in {}", one.name, first.width,
                  first.height, a, second.width, second.height, b);
    }
    const double apart = farthestApart(first, second);
    all[one.name] = jsonNumber(apart);
    text += fmt::format("{}{} {:.6g}", text.empty() ? "" : ", ", one.name, apart);
    if (apart != 0)
      differing.push_back(fmt::format("{} (by up to {:.4g})", one.name, apart));
  }
  if (!all.empty())
    report.add("channels_max_error", std::move(all), text);
  if (!differing.empty()) {
    progress.remark({RemarkCode::kDoubtful, fmt::format("channels differ: {}; {}",
                                                        fmt::join(differing, ", "), kOfColors)});
  }
  return {};
}

Result<Report> comparePictures(const std::string& a, const std::string& b,
                               const Arguments& arguments, Context& context) {
  const ImageReadOptions options{.maxMemory = context.maxMemory / 2};  // both are held
  VOLUTE_ASSIGN(const auto imageA, readImage(a, options));
  VOLUTE_ASSIGN(const auto imageB, readImage(b, options));
  VOLUTE_ASSIGN(const auto difference, compareImages(imageA, imageB));
  if (const auto target = arguments.find<std::string>("difference"))
    VOLUTE_TRY(writeDifference(*target, largestDifferences(imageA, imageB)));
  auto report = compareReport(difference, a, b);
  remarkOnNumbers(a, imageA, context.progress);
  remarkOnNumbers(b, imageB, context.progress);
  VOLUTE_TRY(remarkOnWindows(a, b, context.progress));
  VOLUTE_TRY(compareAlpha(a, b, options, report, context.progress));
  VOLUTE_TRY(compareOthers(a, b, options.maxMemory, report, context.progress));
  return report;
}

Result<Report> compareVolumes(const std::string& a, const std::string& b,
                              const Arguments& arguments, Context& context) {
  const auto target = arguments.find<std::string>("difference");
  const ComparisonRequest request{
      .fields = arguments.find<std::string>("field").value_or(""),
      .frames = arguments.find<FrameRange>("frames").value_or(FrameRange{}),
      .bounds = arguments.find<Box3>("bounds"),
      .framesPerSecond = arguments.find<double>("fps"),
      .partial = arguments.flag("partial"),
      .drawErrors = target.has_value(),
      .overAll = arguments.get<std::string>("rms-over") == "all"};
  VOLUTE_ASSIGN(const auto comparison, volute::compareVolumes(a, b, request, context));
  if (comparison.errors)
    VOLUTE_TRY(writeDifference(*target, *comparison.errors));
  const GridComparison& worst = comparison.worst();
  Report report = compareReport({worst.empty ? 0 : worst.whole.rms(), worst.relativeRms(),
                                 worst.psnr(), worst.whole.maxError},
                                a, b, comparison.measured());
  addDetails(report, comparison);
  return report;
}

Status runCompare(const Arguments& arguments, Context& context) {
  if (const auto target = arguments.find<std::string>("difference")) {
    if (!isPicturePath(*target)) {
      return fail(ErrorCode::kInvalidArgument,
                  "--difference: '{}' has an unknown format; expected .png or .exr", *target);
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
  VOLUTE_ASSIGN(const auto report, isPicturePath(a) ? comparePictures(a, b, arguments, context)
                                                    : compareVolumes(a, b, arguments, context));
  context.print(report);
  return {};
}

}  // namespace

Command compareCommand() {
  using enum ValueKind;
  return {
      .name = "compare",
      .summary = "Measures the difference between two volumes or pictures",
      .examples = {"volute compare fire.npy fire.volute",
                   "volute compare before.png after.png --json"},
      .description =
          "Volumes are compared frame by frame, in order; caches grid by grid, by name, over the "
          "union of their extents; pictures in linear values, other channels of a .exr by their "
          "maximum error. The relative RMS is the RMS over all "
          "divided by the maximum minus the minimum of A; PSNR is -20 log10 of it (infinite, null "
          "in JSON, if they are equal; -1000 there where A is one value and B is not, or numbers "
          "are missing). The support RMS is that over the voxels that A has active "
          "or not equal to its background, divided by the range of those without the few far "
          "from all others (as compress takes it); the outside error is the largest "
          "elsewhere. Both must have the same size.",
      .positionals = {{.name = "A", .help = "the original: a volume, or a picture (.png, .exr)"},
                      {.name = "B", .help = "the volume or picture to compare with it"}},
      .options = {{.name = "difference",
                   .kind = kOutput,
                   .value = "OUT.png",
                   .help = "write a picture of the differences: for volumes, of the frame that "
                           "differs most, the largest differences along y; for several grids, "
                           "side by side, each relative to its range; .png in colours scaled to "
                           "the largest, .exr unscaled"},
                  {.name = "rms-over",
                   .kind = kChoice,
                   .value = "WHAT",
                   .help = "the voxels by whose RMS the worst frame and grid are found: support, "
                           "those that A has active or not equal to its background; or all",
                   .initial = "support",
                   .choices = {"support", "all"},
                   .kinds = {"volume", kVoluteKind}},
                  framesOption("frames with numbers A <= n < B, in both", {"volume", kVoluteKind}),
                  fieldsOption("grids of files with several; if not given, all",
                               {"volume", kVoluteKind}),
                  {.name = "bounds",
                   .kind = kBounds,
                   .value = "X0,Y0,Z0,X1,Y1,Z1",
                   .help = "as for compress [m]",
                   .kinds = {"volume"}},
                  filesRateOption({"volume", kVoluteKind}),
                  partialOption({kVoluteKind})},
      .run = runCompare};
}

}  // namespace volute::cli
