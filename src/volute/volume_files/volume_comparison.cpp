// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/volume_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/base/plain_number.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/fitted_source.hpp"
#include "volute/grid/resample.hpp"
#include "volute/grid/rounding_source.hpp"
#include "volute/volume_files/volume_grids.hpp"

namespace volute {
namespace {

/// Of a frame, over what was asked for: over the support, of all that is wrong.
double rmsOf(const GridComparison& grid, const Difference& frame) {
  if (grid.overAll)
    return frame.rms();
  const auto values = static_cast<double>(std::max<std::uint64_t>(frame.supportValues, 1));
  return std::sqrt(frame.sumOfSquares / values);
}

std::size_t worstFrame(const GridComparison& grid) {
  const auto worst = std::ranges::max_element(
      grid.byFrame, {}, [&](const Difference& frame) { return rmsOf(grid, frame); });
  return static_cast<std::size_t>(worst - grid.byFrame.begin());
}

/// Of one frame, as VolumeComparison::errors has them.
Result<Image> errorsOfFrame(FrameSource& a, FrameSource& b, int frame, std::uint64_t maxMemory) {
  const VolumeInfo& info = a.info();
  if (8 * info.frameValues() > maxMemory) {
    return fail(ErrorCode::kTooLarge,
                "a picture of the differences needs all {} x {} x {} voxels of two frames, {} MiB, "
                "more than the {} MiB allowed",
                info.x, info.y, info.z, (info.frameValues() >> 17) + 1, maxMemory >> 20);
  }
  std::vector<float> first(info.frameValues()), second(info.frameValues());
  VOLUTE_TRY(a.readFrame(frame, first));
  VOLUTE_TRY(b.readFrame(frame, second));
  const double apart = offsetOf(a) - offsetOf(b);
  Image errors(info.x, info.z, 1);
  for (std::size_t i = 0; i < first.size(); ++i) {
    const std::size_t voxel = i / static_cast<std::size_t>(info.channels);
    const int x = static_cast<int>(voxel % info.x), z = static_cast<int>(voxel / info.x / info.y);
    float& error = errors.at(x, info.z - 1 - z);
    error = std::max(error, static_cast<float>(std::abs(apart + first[i] - second[i])));
  }
  return errors;
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

/// What a source has where nothing is stored.
Result<std::array<double, 3>> outsideOf(FrameSource& source) {
  Bricks bricks;
  VOLUTE_TRY(source.readBricks(0, 0, 1, bricks));
  std::array<double, 3> outside{};
  for (std::size_t c = 0; c < 3; ++c) outside[c] = offsetOf(source) + bricks.background()[c];
  return outside;
}

/// Both over all that one of them takes, where they are on one lattice of voxels.
void align(std::unique_ptr<FrameSource>& a, const std::array<double, 3>& outsideA,
           std::unique_ptr<FrameSource>& b, const std::array<double, 3>& outsideB) {
  const VolumeInfo infoA = a->info(), infoB = b->info();
  if (!onOneLattice(infoB, infoA))
    return;  // compare() says what does not fit
  Box3 both = infoA.bounds;
  both.extend(infoB.bounds);
  const VolumeInfo wide = widenedTo(infoA, both);
  const auto differs = [&](const VolumeInfo& info) {
    return info.x != wide.x || info.y != wide.y || info.z != wide.z;
  };
  if (differs(infoA))
    a = fitTo(std::move(a), wide, outsideA);
  if (differs(infoB))
    b = fitTo(std::move(b), wide, outsideB);
}

/// What plays at another speed is not the same, though all of its values are.
void remarkOnTimes(const VolumeInfo& a, const VolumeInfo& b, Reading& reading) {
  constexpr double kSame = 1e-6;
  if (a.timesAssumed || b.timesAssumed || a.frames != b.frames || a.frames < 2)
    return;
  const auto last = static_cast<std::size_t>(a.frames) - 1;
  const double spanA = a.times[last] - a.times[0], spanB = b.times[last] - b.times[0];
  if (std::abs(spanA - spanB) <= kSame * std::max(spanA, spanB))
    return;
  reading.progress.remark(
      {RemarkCode::kDoubtful,
       fmt::format("the two have other times: from the first to the last frame pass {} and "
                   "{} s",
                   plainNumber(spanA), plainNumber(spanB)),
       {Hint::set("fps").so("takes one rate for both")}});
}

/// What lies elsewhere is not the same, though all of its values are.
void remarkOnPlaces(const VolumeInfo& a, const VolumeInfo& b, Reading& reading) {
  constexpr double kSame = 1e-3;  // voxels
  if (a.x != b.x || a.y != b.y || a.z != b.z)
    return;  // an error
  const double voxel = std::min(a.voxelSize().minCoeff(), b.voxelSize().minCoeff());
  const double apart = std::max((a.bounds.min - b.bounds.min).cwiseAbs().maxCoeff(),
                                (a.bounds.max - b.bounds.max).cwiseAbs().maxCoeff());
  if (apart <= kSame * voxel)
    return;
  reading.progress.remark(
      {RemarkCode::kDoubtful,
       fmt::format("'{}': the two lie elsewhere ({}; {}): voxels of the same number are compared",
                   a.name, boxText(a.bounds), boxText(b.bounds))});
}

/// The same numbers in other units are not the same, nor are values that stand on another axis.
void remarkOnMeaning(const VolumeInfo& a, const VolumeInfo& b, Reading& reading) {
  if (a.unit != b.unit) {
    const bool both = !a.unit.empty() && !b.unit.empty();
    const auto text = [](const std::string& unit) {
      return unit.empty() ? std::string("states no unit") : "is in " + unit;
    };
    reading.progress.remark({both ? RemarkCode::kDoubtful : RemarkCode::kNote,
                             fmt::format("'{}': one {} and the other {}: numbers are compared as "
                                         "they are",
                                         a.name, text(a.unit), text(b.unit))});
  }
  if (a.up != b.up) {
    const auto text = [](char up) {
      return up == 0 ? std::string("does not say which axis points upwards")
                     : fmt::format("says that {} points upwards", up);
    };
    reading.progress.remark({a.up != 0 && b.up != 0 ? RemarkCode::kDoubtful : RemarkCode::kNote,
                             fmt::format("'{}': one {} and the other {}: axes are compared as they "
                                         "are",
                                         a.name, text(a.up), text(b.up))});
  }
}

/// Whether a volume holds one array, which has no name.
bool isNameless(const std::string& path) {
  return extensionOf(path) == ".npy" || volumesIn(path).value_or("") == ".npy";
}

/// Values of another name may be of another thing, and the same ones over another basis are another
/// field. What an array is called is no statement, nor is what Volute calls what has no name.
void remarkOnKinds(const VolumeInfo& a, const std::string& pathA, const VolumeInfo& b,
                   const std::string& pathB, Reading& reading) {
  const auto named = [](const VolumeInfo& info) { return info.name != VolumeInfo().name; };
  if (a.name != b.name && !isNumpyPath(pathA) && !isNumpyPath(pathB)) {
    reading.progress.remark(
        {named(a) && named(b) ? RemarkCode::kDoubtful : RemarkCode::kNote,
         fmt::format("'{}' of one is compared with '{}' of the other", a.name, b.name)});
  }
  if (a.basis != b.basis && isVolutePath(pathA) && isVolutePath(pathB)) {
    reading.progress.remark(
        {RemarkCode::kDoubtful,
         fmt::format("'{}': one is over the {} basis and the other over the {} one: values are "
                     "compared as they are stored",
                     a.name, basisName(a.basis), basisName(b.basis))});
  }
}

/// What has no numbers has no error.
void remarkOnErrors(const GridComparison& grid, Reading& reading) {
  const Difference& whole = grid.whole;
  std::string text;
  if (!std::isfinite(whole.rms()))
    text = "some values are no numbers, or infinite: no error of all is known";
  else if (whole.rms() > 0 && !(whole.maxA > whole.minA))
    text =
        fmt::format("the first is {:g} everywhere: no error is relative to its range", whole.minA);
  if (!text.empty())
    reading.progress.remark({RemarkCode::kDoubtful, fmt::format("'{}': {}", grid.name, text)});
}

/// Frames are compared in their order, whatever their numbers.
void remarkOnNumbers(const VolumeInfo& a, const VolumeInfo& b, Reading& reading) {
  if (a.frames != b.frames || a.frames < 2)
    return;  // an error; files that are named each by itself
  std::optional<std::size_t> first;
  bool alike = true;  // but for where they begin
  const auto number = [](const VolumeInfo& info, std::size_t i) {
    return info.frameScale.frame(info.frameNumbers[i]);
  };
  for (std::size_t i = 0; i < a.frameNumbers.size(); ++i) {
    if (!first && number(a, i) != number(b, i))
      first = i;
    alike = alike && number(a, i) - number(a, 0) == number(b, i) - number(b, 0);
  }
  if (first)
    reading.progress.remark({alike ? RemarkCode::kNote : RemarkCode::kDoubtful,
                             fmt::format("'{}': frames are compared in their order: frame {} with "
                                         "frame {}{}",
                                         a.name, a.frameText(*first), b.frameText(*first),
                                         *first + 1 < a.frameNumbers.size() ? " and so on" : "")});
}

/// The chosen frames of both.
/// @param placed  both state where they lie
Result<GridComparison> compareSources(std::unique_ptr<FrameSource> a,
                                      std::unique_ptr<FrameSource> b, bool placed,
                                      const ComparisonRequest& request, Reading& reading,
                                      std::vector<Image>& errors) {
  if (placed)
    remarkOnPlaces(a->info(), b->info(), reading);
  VOLUTE_ASSIGN(a, selectFrames(std::move(a), request.frames));
  VOLUTE_ASSIGN(b, selectFrames(std::move(b), request.frames));
  remarkOnTimes(a->info(), b->info(), reading);
  remarkOnNumbers(a->info(), b->info(), reading);
  remarkOnMeaning(a->info(), b->info(), reading);
  GridComparison grid{a->info().name};
  grid.overAll = request.overAll;
  VOLUTE_ASSIGN(grid.whole, compare(*a, *b, reading.progress, &grid.byFrame));
  remarkOnErrors(grid, reading);
  if (grid.whole.backgroundsDiffer) {
    reading.progress.remark(
        {RemarkCode::kDoubtful,
         fmt::format(
             "'{}': the two have other backgrounds, so that they differ where nothing is stored",
             grid.name)});
  }
  grid.frameNumbers = a->info().frameNumbers;
  grid.frameScale = a->info().frameScale;
  grid.times = a->info().times;
  if (request.drawErrors) {
    VOLUTE_ASSIGN(auto image,
                  errorsOfFrame(*a, *b, static_cast<int>(worstFrame(grid)), reading.maxMemory));
    errors.push_back(std::move(image));
  }
  return grid;
}

/// How a volume lies in the world.
struct Placed {
  const VolumeInfo& info;                 ///< of all frames
  const std::vector<GridMatrix>& places;  ///< as PlacedFrames has them
  const std::string& path;
};

/// Both must lie in the world alike in the frames that are compared.
/// @return whether their bounds are in one space, too: then one may take more of it than the other
Result<bool> checkPlaces(const Placed& a, const Placed& b, const FrameRange& range) {
  if (a.places.empty() && b.places.empty())
    return true;
  std::array<std::vector<GridMatrix>, 2> spaces, indices;
  for (const std::size_t side : {0, 1}) {
    const Placed& one = side == 0 ? a : b;
    VOLUTE_ASSIGN(const auto positions, selectPositions(one.info, range));
    for (const int position : positions) {
      const auto frame = static_cast<std::size_t>(position);
      if (!one.places.empty())
        spaces[side].push_back(one.places[frame]);
      indices[side].push_back(indexToWorld(one.info, one.places, frame));
    }
  }
  const double voxel = a.info.voxelSize().minCoeff();
  if (samePlaces(spaces[0], spaces[1], a.info.bounds, voxel))
    return true;
  const Box3 all{Vec3::Zero(), Vec3(a.info.x, a.info.y, a.info.z)};
  if (samePlaces(indices[0], indices[1], all, voxel))
    return false;
  return fail(ErrorCode::kInvalidData,
              "{} and {} turn '{}' otherwise, or lay it elsewhere, so that no voxel of one is one "
              "of the other",
              a.path, b.path, a.info.name);
}

/// Those of one name.
Result<GridComparison> compareGrid(const VolumeGrids& first, std::size_t i, const std::string& a,
                                   const VolumeGrids& second, const std::string& b,
                                   const ComparisonRequest& request, Reading& reading,
                                   std::vector<Image>& errors) {
  const VolumeGrid& grid = first.grids()[i];
  VOLUTE_ASSIGN(const auto found, second.choose(grid.name, b));
  const VolumeGrid& other = second.grids()[found[0]];
  if (grid.empty != other.empty) {
    return fail(ErrorCode::kInvalidData, "grid '{}' is empty in {}, and not in {}", grid.name,
                grid.empty ? a : b, grid.empty ? b : a);
  }
  if (grid.empty)
    return GridComparison{grid.name, true, request.overAll};
  VOLUTE_ASSIGN(auto sourceA, first.source(i));
  VOLUTE_ASSIGN(auto sourceB, second.source(found[0]));
  sourceA = asStated(std::move(sourceA), {request.framesPerSecond});
  sourceB = asStated(std::move(sourceB), {request.framesPerSecond});
  const auto places = [](const VolumeGrid& of) {
    return of.description ? of.description->places() : std::vector<GridMatrix>();
  };
  remarkOnKinds(sourceA->info(), a, sourceB->info(), b, reading);
  const auto placesA = places(grid), placesB = places(other);
  VOLUTE_ASSIGN(const bool oneSpace, checkPlaces({sourceA->info(), placesA, a},
                                                 {sourceB->info(), placesB, b}, request.frames));
  const auto outside = [](const VolumeGrid& of) {
    return of.description ? of.description->background : std::array<double, 3>{};
  };
  if (oneSpace)
    align(sourceA, outside(grid), sourceB, outside(other));
  auto compared =
      compareSources(std::move(sourceA), std::move(sourceB), oneSpace, request, reading, errors);
  if (!compared)
    return fail(compared.error().code, compared.error().hints, "grid '{}': {}", grid.name,
                compared.error().message);
  compared->name = grid.name;
  if (request.drawErrors) {
    const double range = compared->whole.maxA - compared->whole.minA;
    for (float& error : errors.back().pixels)
      error = static_cast<float>(error / (range > 0 ? range : 1));
  }
  return compared;
}

/// Whether two are the same bytes; both may be null.
Result<bool> sameBytes(KeptBytes* a, KeptBytes* b) {
  if (!a || !b || a->size() != b->size())
    return !a && !b;
  for (;;) {
    VOLUTE_ASSIGN(const auto one, a->next());
    VOLUTE_ASSIGN(const auto other, b->next());
    if (!std::ranges::equal(one, other))
      return false;
    if (one.empty())
      return true;
  }
}

/// @param positions  of the frames in both
Result<bool> sameBytes(const VolumeGrids& first, std::size_t i, const VolumeGrids& second,
                       std::size_t k, const std::array<std::vector<int>, 2>& positions) {
  for (std::size_t frame = 0; frame < positions[0].size(); ++frame) {
    VOLUTE_ASSIGN(const auto a, first.keep(i, positions[0][frame]));
    VOLUTE_ASSIGN(const auto b, second.keep(k, positions[1][frame]));
    VOLUTE_ASSIGN(const bool same, sameBytes(a.get(), b.get()));
    if (!same)
      return false;
  }
  return true;
}

/// The grids that the request names.
Result<VolumeComparison> compareCaches(const VolumeGrids& first, const std::string& a,
                                       const VolumeGrids& second, const std::string& b,
                                       const ComparisonRequest& request, Reading& reading) {
  VolumeComparison all;
  all.caches = true;
  std::vector<Image> errors;
  VOLUTE_ASSIGN(const auto chosen, first.choose(request.fields, a));
  std::vector<std::pair<std::size_t, std::size_t>> asBytes;
  for (const std::size_t i : chosen) {
    VOLUTE_ASSIGN(const auto other, second.choose(first.grids()[i].name, b));
    if (!first.grids()[i].kept.empty() || !second.grids()[other[0]].kept.empty()) {
      asBytes.emplace_back(i, other[0]);
      continue;
    }
    VOLUTE_ASSIGN(auto one, compareGrid(first, i, a, second, b, request, reading, errors));
    all.grids.push_back(std::move(one));
  }
  remarkOnRange(a, first.frames(), request.frames, reading);
  remarkOnRange(b, second.frames(), request.frames, reading);
  std::array<std::vector<int>, 2> positions;
  VOLUTE_ASSIGN(positions[0], selectPositions(first.frames(), request.frames));
  VOLUTE_ASSIGN(positions[1], selectPositions(second.frames(), request.frames));
  if (positions[0].size() != positions[1].size()) {
    return fail(ErrorCode::kInvalidData, "{} has {} frames and {} has {}; expected as many", a,
                positions[0].size(), b, positions[1].size());
  }
  if (request.drawErrors && errors.empty()) {
    return fail(ErrorCode::kUnsupported,
                "{}: no grid that is compared has values, so there is no picture of differences",
                a);
  }
  for (const auto& [i, k] : asBytes) {
    VOLUTE_ASSIGN(const bool same, sameBytes(first, i, second, k, positions));
    all.kept.emplace_back(first.grids()[i].name, same);
  }
  for (const VolumeGrid& grid : second.grids()) {
    const bool known = std::ranges::any_of(
        first.grids(), [&](const VolumeGrid& one) { return one.name == grid.name; });
    if (!known && request.fields.empty())
      reading.progress.remark(
          {RemarkCode::kLeftOut, fmt::format("'{}' is in {} alone", grid.name, b)});
  }
  if (!errors.empty())
    all.errors = sideBySide(errors);
  return all;
}

std::string worstFrameText(const GridComparison& grid) {
  const std::size_t at = worstFrame(grid);
  return fmt::format("worst in frame {} at {} s: rms {:.6g}, max error {:.6g}",
                     frameText(grid.frameNumbers[at], grid.frameScale),
                     plainNumber(grid.times[at], 4), rmsOf(grid, grid.byFrame[at]),
                     grid.byFrame[at].maxError);
}

/// Where the largest error is, and what is there.
std::string worstPlaceText(const GridComparison& grid) {
  const Difference& whole = grid.whole;
  if (!(whole.maxError > 0))
    return "nowhere";
  return fmt::format(
      "frame {}, voxel ({}, {}, {}): {:.6g} and {:.6g}",
      frameText(grid.frameNumbers[static_cast<std::size_t>(whole.worstFrame)], grid.frameScale),
      whole.worst[0], whole.worst[1], whole.worst[2], whole.worstA, whole.worstB);
}

nlohmann::ordered_json worstPlaceJson(const GridComparison& grid) {
  const Difference& whole = grid.whole;
  if (!(whole.maxError > 0))
    return nullptr;
  return {{"frame", jsonFrame(grid.frameNumbers[static_cast<std::size_t>(whole.worstFrame)],
                              grid.frameScale)},
          {"voxel", whole.worst},
          {"values", {jsonNumber(whole.worstA), jsonNumber(whole.worstB)}}};
}

nlohmann::ordered_json framesJson(const GridComparison& grid) {
  auto frames = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < grid.byFrame.size(); ++i) {
    frames.push_back({{"frame", jsonFrame(grid.frameNumbers[i], grid.frameScale)},
                      {"time", grid.times[i]},
                      {"rms", jsonNumber(grid.byFrame[i].rms())},
                      {"support_rms", jsonNumber(grid.byFrame[i].supportRms())},
                      {"max_error", jsonNumber(grid.byFrame[i].maxError)}});
  }
  return frames;
}

}  // namespace

const GridComparison& VolumeComparison::worst() const {
  static const GridComparison kNothing{.name = "", .empty = true};
  return grids.empty() ? kNothing
                       : *std::ranges::max_element(grids, {}, &GridComparison::wantedRms);
}

Result<VolumeComparison> compareVolumes(const std::string& a, const std::string& b,
                                        const ComparisonRequest& request, Reading& reading) {
  InputOptions options;
  options.partial = request.partial;
  options.offsets = Offsets::kOfRounded;
  options.bounds = request.bounds;
  options.stated.framesPerSecond = request.framesPerSecond;
  if (VolumeGrids::mayBe(a) && VolumeGrids::mayBe(b) && !options.bounds) {
    VOLUTE_ASSIGN(const auto first, VolumeGrids::open(a, options, reading));
    VOLUTE_ASSIGN(const auto second, VolumeGrids::open(b, options, reading));
    const auto isCache = [](const VolumeGrids& grids) {
      return grids.grids().size() != 1 ||
             std::ranges::any_of(grids.grids(), [](const VolumeGrid& grid) {
               return grid.empty || !grid.kept.empty() ||
                      (grid.description && grid.description->gridClass == "level set");
             });
    };
    if (isCache(*first) || isCache(*second))
      return compareCaches(*first, a, *second, b, request, reading);
  }
  options.grid = request.fields;
  // A .volute file has its own bounds; the option speaks of the other formats, and a field of what
  // has names.
  const bool eitherIsNamed = !isNameless(a) || !isNameless(b);
  const auto optionsFor = [&](const std::string& path) {
    InputOptions own = options;
    if (isVolutePath(path))
      own.bounds.reset();
    if (eitherIsNamed && isNameless(path))
      own.grid.clear();
    return own;
  };
  VOLUTE_ASSIGN(auto first, openVolume(a, optionsFor(a), reading));
  VOLUTE_ASSIGN(auto second, openVolume(b, optionsFor(b), reading));
  const VolumeInfo& infoA = first.source->info();
  const VolumeInfo& infoB = second.source->info();
  remarkOnKinds(infoA, a, infoB, b, reading);
  bool placed = !isNumpyPath(a) && !isNumpyPath(b);
  if (placed) {
    VOLUTE_ASSIGN(placed,
                  checkPlaces({infoA, first.places, a}, {infoB, second.places, b}, request.frames));
  }
  remarkOnRange(a, infoA, request.frames, reading);
  remarkOnRange(b, infoB, request.frames, reading);
  placed = placed && !options.bounds;
  // Of arrays of netCDF some state coordinates; the bounds of others are those that none state.
  const auto statesPlace = [](const std::string& path, const VolumeInfo& info) {
    const std::string extension = extensionOf(path);
    return isVolutePath(path) || VolumeGrids::mayBe(path) || extension == ".vti" ||
           extension == ".pvd" || !hasUsualBounds(info);
  };
  const bool bothPlaced = placed && statesPlace(a, infoA) && statesPlace(b, infoB);
  if (placed && (infoA.x != infoB.x || infoA.y != infoB.y || infoA.z != infoB.z)) {
    VOLUTE_ASSIGN(const auto outsideA, outsideOf(*first.source));
    VOLUTE_ASSIGN(const auto outsideB, outsideOf(*second.source));
    align(first.source, outsideA, second.source, outsideB);
  }
  VolumeComparison comparison;
  std::vector<Image> errors;
  VOLUTE_ASSIGN(auto one, compareSources(std::move(first.source), std::move(second.source),
                                         bothPlaced, request, reading, errors));
  comparison.grids.push_back(std::move(one));
  if (!errors.empty())
    comparison.errors = std::move(errors[0]);
  return comparison;
}

nlohmann::ordered_json psnrJson(double psnr) {
  constexpr double kNone = -1000;
  if (std::isinf(psnr) && psnr > 0)
    return nullptr;
  return std::isfinite(psnr) ? psnr : kNone;
}

void addDetails(Report& report, const VolumeComparison& comparison) {
  const GridComparison& worst = comparison.worst();
  const Difference& whole = worst.whole;
  const auto of = [&](std::string text) {
    return comparison.measured() ? std::move(text) : std::string();
  };
  report
      .add("support_rms", jsonNumber(whole.supportRms()),
           of(fmt::format("{:.6g} of the range {:.4g} to {:.4g}{}", whole.supportRms(),
                          whole.supportLow, whole.supportHigh,
                          whole.robust ? ", without outliers" : "")))
      .add("support_share", whole.supportShare(),
           of(fmt::format("{:.4g} %", 100 * whole.supportShare())))
      .add("outside_error", jsonNumber(whole.outsideError),
           of(fmt::format("{:.6g}", whole.outsideError)))
      .add("max_error_at", worstPlaceJson(worst), of(worstPlaceText(worst)));
  if (worst.byFrame.size() > 1)
    report.add("by_frame", framesJson(worst), worstFrameText(worst));
  if (!comparison.caches)
    return;
  auto list = nlohmann::ordered_json::array();
  std::string text;
  for (const GridComparison& grid : comparison.grids) {
    list.push_back({{"name", grid.name},
                    {"empty", grid.empty},
                    {"rms", grid.empty ? 0 : grid.whole.rms()},
                    {"relative_rms", jsonNumber(grid.relativeRms())},
                    {"support_rms", jsonNumber(grid.whole.supportRms())},
                    {"support_share", grid.whole.supportShare()},
                    {"psnr", psnrJson(grid.psnr())},
                    {"max_error", grid.whole.maxError},
                    {"max_error_at", worstPlaceJson(grid)},
                    {"by_frame", framesJson(grid)}});
    text += fmt::format("\n  {:<16} ", grid.name);
    text += grid.empty ? std::string("empty in both")
                       : fmt::format(
                             "relative rms {:.4g} over what is in use, {:.4g} over all "
                             "({:.2f} dB), max error {:.4g}{}{}",
                             grid.whole.supportRms(), grid.relativeRms(), grid.psnr(),
                             grid.whole.maxError, grid.byFrame.size() > 1 ? "; " : "",
                             grid.byFrame.size() > 1 ? worstFrameText(grid) : "");
  }
  report.add("worst_grid", worst.name, of(worst.name)).add("grids", list, text);
  auto kept = nlohmann::ordered_json::array();
  std::string keptText;
  for (const auto& [name, same] : comparison.kept) {
    kept.push_back({{"name", name}, {"identical", same}});
    keptText += fmt::format("\n  {:<16} {}", name, same ? "identical" : "differs");
  }
  if (!kept.empty())
    report.add("kept", kept, keptText);
}

}  // namespace volute
