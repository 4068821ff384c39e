// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/compare.hpp"

#include <algorithm>
#include <cmath>

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/grid/fitted_source.hpp"
#include "volute/grid/select_frames.hpp"
#include "volute/image/colormap.hpp"
#include "volute/image/compare.hpp"
#include "volute/io/image_file.hpp"
#include "volute/media/volume/volume_grids.hpp"

namespace volute::cli {
namespace {

struct Figures {
  double rms = 0;
  double relativeRms = 0;
  double psnr = 0;
  double maxError = 0;
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();  ///< of each, of volumes
  std::string worst{};  ///< the frame with the greatest error, for people
  nlohmann::ordered_json grids = nlohmann::ordered_json::array();  ///< of each of several
  std::string gridLines{};
  std::string name{};  ///< of the grid that this is of; of several, the worst
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
  if (!figures.grids.empty()) {
    report.add("worst_grid", figures.name)
        .add("grids", figures.grids, figures.gridLines);
  }
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

Result<Figures> compareSources(FrameSource& a, FrameSource& b, Context& context,
                               std::size_t& worstFrame) {
  std::vector<Difference> byFrame;
  VOLUTE_ASSIGN(const auto difference, compare(a, b, context.progress, &byFrame));
  Figures figures{difference.rms(), difference.relativeRms(), difference.psnr(),
                  difference.maxError};
  figures.name = a.info().name;
  const auto& numbers = a.info().frameNumbers;
  for (std::size_t i = 0; i < byFrame.size(); ++i) {
    figures.frames.push_back({{"frame", numbers[i]},
                              {"rms", jsonNumber(byFrame[i].rms())},
                              {"max_error", jsonNumber(byFrame[i].maxError)}});
  }
  const auto worst = std::ranges::max_element(byFrame, {}, &Difference::rms);
  worstFrame = static_cast<std::size_t>(worst - byFrame.begin());
  figures.worst = fmt::format("worst in frame {}: rms {:.6g}, max error {:.6g}", numbers[worstFrame],
                              worst->rms(), worst->maxError);
  return figures;
}

/// Both over all that one of them takes, where they are on one lattice of voxels.
Status alignGrids(std::unique_ptr<FrameSource>& a, const std::array<double, 3>& outsideA,
                  std::unique_ptr<FrameSource>& b, const std::array<double, 3>& outsideB) {
  const VolumeInfo infoA = a->info(), infoB = b->info();
  if (!onOneLattice(infoB, infoA))
    return {};  // compare() says what does not fit
  Box3 both = infoA.bounds;
  both.extend(infoB.bounds.min), both.extend(infoB.bounds.max);
  const VolumeInfo wide = widenedTo(infoA, both);
  const auto differs = [&](const VolumeInfo& info) {
    return info.x != wide.x || info.y != wide.y || info.z != wide.z;
  };
  if (differs(infoA))
    a = fitTo(std::move(a), wide, outsideA);
  if (differs(infoB))
    b = fitTo(std::move(b), wide, outsideB);
  return {};
}

/// Pictures side by side, a gap between them.
Image sideBySide(const std::vector<Image>& images) {
  constexpr int kGap = 2;
  int width = -kGap, height = 0;
  for (const Image& image : images)
    width += image.width + kGap, height = std::max(height, image.height);
  Image all(width, height, 1);
  int left = 0;
  for (const Image& image : images) {
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        all.at(left + x, height - image.height + y) = image.at(x, y);
    left += image.width + kGap;
  }
  return all;
}

/// Grid by grid, those of one name. The figures are those of the worst, and of each.
Result<Figures> compareGrids(const VolumeGrids& first, const std::string& a,
                             const VolumeGrids& second, const std::string& b,
                             const Arguments& arguments, Context& context) {
  const std::string fields = arguments.find<std::string>("field").value_or("");
  const auto frames = arguments.find<FrameRange>("frames").value_or(FrameRange{});
  VOLUTE_ASSIGN(const auto chosen, first.choose(fields, a));
  Figures all;
  all.relativeRms = -1;
  std::vector<Image> pictures;
  for (const std::size_t i : chosen) {
    const VolumeGrid& grid = first.grids()[i];
    VOLUTE_ASSIGN(const auto found, second.choose(grid.name, b));
    const VolumeGrid& other = second.grids()[found[0]];
    if (grid.empty != other.empty) {
      return fail(ErrorCode::kInvalidData, "grid '{}' is empty in {}, and not in {}", grid.name,
                  grid.empty ? a : b, grid.empty ? b : a);
    }
    Figures one;
    one.name = grid.name;
    if (!grid.empty) {
      VOLUTE_ASSIGN(auto sourceA, first.source(i));
      VOLUTE_ASSIGN(auto sourceB, second.source(found[0]));
      const auto outside = [](const VolumeGrid& of) {
        return of.description ? of.description->background : std::array<double, 3>{};
      };
      VOLUTE_TRY(alignGrids(sourceA, outside(grid), sourceB, outside(other)));
      VOLUTE_ASSIGN(sourceA, selectFrames(std::move(sourceA), frames));
      VOLUTE_ASSIGN(sourceB, selectFrames(std::move(sourceB), frames));
      std::size_t worstFrame = 0;
      auto compared = compareSources(*sourceA, *sourceB, context, worstFrame);
      if (!compared) {
        return fail(compared.error().code, "grid '{}': {}", grid.name, compared.error().message);
      }
      one = std::move(*compared);
      if (arguments.given("difference")) {
        VOLUTE_ASSIGN(auto errors, errorsOf(*sourceA, *sourceB, static_cast<int>(worstFrame)));
        const double range = one.relativeRms > 0 ? one.rms / one.relativeRms : 1;
        for (float& error : errors.pixels) error = static_cast<float>(error / range);
        pictures.push_back(std::move(errors));
      }
    } else {
      one.psnr = std::numeric_limits<double>::infinity();
    }
    all.grids.push_back({{"name", one.name},
                         {"empty", grid.empty},
                         {"rms", one.rms},
                         {"relative_rms", jsonNumber(one.relativeRms)},
                         {"psnr", jsonNumber(one.psnr)},
                         {"max_error", one.maxError},
                         {"by_frame", one.frames}});
    all.gridLines += fmt::format("\n  {:<16} ", one.name);
    all.gridLines +=
        grid.empty ? std::string("empty in both")
                   : fmt::format("relative rms {:.4g} ({:.2f} dB), max error {:.4g}{}{}",
                                 one.relativeRms, one.psnr, one.maxError,
                                 one.frames.size() > 1 ? "; " : "", one.frames.size() > 1 ? one.worst : "");
    if (one.relativeRms > all.relativeRms) {
      auto grids = std::move(all.grids);
      auto lines = std::move(all.gridLines);
      all = one;
      all.grids = std::move(grids);
      all.gridLines = std::move(lines);
    }
  }
  for (const VolumeGrid& grid : second.grids()) {
    const bool known = std::ranges::any_of(
        first.grids(), [&](const VolumeGrid& one) { return one.name == grid.name; });
    if (!known && fields.empty())
      context.progress.remark(fmt::format("'{}' is in {} alone", grid.name, b));
  }
  if (const auto target = arguments.find<std::string>("difference"); target && !pictures.empty())
    VOLUTE_TRY(writeDifference(*target, sideBySide(pictures)));
  return all;
}

Result<Figures> compareVolumes(const std::string& a, const std::string& b,
                               const Arguments& arguments, Context& context) {
  InputOptions options;
  options.grid = arguments.find<std::string>("field").value_or("");
  options.bounds = arguments.find<Box3>("bounds");
  options.partial = arguments.flag("partial");
  if (VolumeGrids::mayBe(a) && VolumeGrids::mayBe(b) && !options.bounds) {
    options.grid.clear();
    VOLUTE_ASSIGN(const auto first, VolumeGrids::open(a, options, context));
    VOLUTE_ASSIGN(const auto second, VolumeGrids::open(b, options, context));
    if (first->grids().size() > 1 || second->grids().size() > 1)
      return compareGrids(*first, a, *second, b, arguments, context);
    options.grid = arguments.find<std::string>("field").value_or("");
  }
  // A .volute file has its own bounds; the option speaks of the other formats.
  const auto optionsFor = [&](const std::string& path) {
    InputOptions own = options;
    if (isVolutePath(path))
      own.bounds.reset();
    return own;
  };
  VOLUTE_ASSIGN(auto first, openVolume(a, optionsFor(a), context));
  VOLUTE_ASSIGN(auto second, openVolume(b, optionsFor(b), context));
  const VolumeInfo& infoA = first.source->info();
  const VolumeInfo& infoB = second.source->info();
  const bool placed = extensionOf(a) != ".npy" && extensionOf(b) != ".npy" && !options.bounds;
  if (placed && (infoA.x != infoB.x || infoA.y != infoB.y || infoA.z != infoB.z))
    VOLUTE_TRY(alignGrids(first.source, {}, second.source, {}));
  if (const auto frames = arguments.find<FrameRange>("frames")) {
    VOLUTE_ASSIGN(first.source, selectFrames(std::move(first.source), *frames));
    VOLUTE_ASSIGN(second.source, selectFrames(std::move(second.source), *frames));
  }
  std::size_t at = 0;
  VOLUTE_ASSIGN(const auto figures, compareSources(*first.source, *second.source, context, at));
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
          "Volumes are compared frame by frame in the order of their frames, and caches grid by grid, "
          "by the grids' names, over all that one of them takes; pictures in linear "
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
                           "largest differences along y; of several grids, side by side and each "
                           "relative to its range; .png in colours up to the largest, .exr as it is"},
                  {.name = "frames",
                   .kind = kFrames,
                   .value = "A:B[:S]",
                   .help = "frames with numbers A <= n < B of both",
                   .kinds = {"volume", kVoluteKind}},
                  fieldsOption("which ones of files with several, all without it", {"volume", kVoluteKind}),
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
