// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fog/fog_scene_medium.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "volute/base/plain_number.hpp"
#include "volute/io/frame_file.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/image_file.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {
namespace {

struct Maps {
  std::vector<FogMap> maps;
  std::vector<double> times;
  std::optional<VolumeInfo> place{};  ///< where a volume says that its cells are
};

/// [s], of the map with a number.
double timeOfNumber(double number, double first, const FogDescription& fog) {
  return (number - (fog.byNumber ? 0 : first)) / fog.rate;
}

/// An argument of the library is data here.
ErrorCode codeOfData(ErrorCode code) {
  return code == ErrorCode::kInvalidArgument ? ErrorCode::kInvalidData : code;
}

/// The library's error as one about a map in a file.
tl::unexpected<Error> aboutFile(const std::string& file, const Error& error) {
  return fail(codeOfData(error.code), "{}: {}", file, error.message);
}

/// The library's error as one about the entry.
tl::unexpected<Error> aboutEntry(const FogDescription& fog, const Error& error) {
  return tl::unexpected(fog.about({codeOfData(error.code), error.message}));
}

/// What is transparent in a painted map was not painted. In a .exr colours are multiplied by alpha.
Status multiplyByAlpha(const std::string& path, Image& image, const Reading& reading) {
  VOLUTE_ASSIGN(const auto alpha, readAlpha(path, {.raw = true, .maxMemory = reading.maxMemory}));
  if (!alpha || std::ranges::all_of(alpha->pixels, [](float value) { return value == 1; }))
    return {};
  const auto channels = static_cast<std::size_t>(image.channels);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] *= alpha->pixels[i / channels];
  reading.progress.remark(
      Remark{RemarkCode::kAssumed, path + ": its values are multiplied by its alpha: where the map "
                                          "is transparent it is 0"}
          .in(path));
  return {};
}

/// What is told once of the pictures of a map.
using ToldOfMaps = std::set<std::string>;

std::string notSquare(double aspect) {
  return fmt::format("its pixels are {:g} times as wide as high; the map's cells are square",
                     aspect);
}

/// Of a .exr: what is not read of it, and values that are no shares.
Status tellOfExr(const std::string& path, const Image& image, const std::string& unit, double whole,
                 ToldOfMaps& told, Progress& progress) {
  const auto tell = [&](const char* subject, RemarkCode code, const std::string& text) {
    if (told.insert(subject).second)
      progress.remark(Remark{code, fmt::format("{}: {}", path, text)}.in(path));
  };
  const float largest = std::ranges::max(image.pixels);
  if (largest > 1) {
    tell("values", unit == "m" ? RemarkCode::kNote : RemarkCode::kDoubtful,
         fmt::format("values up to {:g} count as they are, not as shares of a maximum as a .png's "
                     "do: {} up to {:g} {}",
                     largest, unit == "m" ? "heights are" : "the extinction is", largest * whole,
                     unit));
  }
  VOLUTE_ASSIGN(const auto info, readFrameInfo(path));
  std::vector<std::string> others;
  for (const FrameChannel& channel : info.channels) {
    const bool read =
        channel.name == "A" || info.channels.size() == 1 ||
        (image.channels == 3 ? channel.name == "R" || channel.name == "G" || channel.name == "B"
                             : channel.name == "Y");
    if (!read)
      others.push_back(channel.name);
  }
  if (!others.empty()) {
    tell("channels", RemarkCode::kLeftOut,
         fmt::format("the map is {}; left out: {}", image.channels == 3 ? "R, G and B" : "Y",
                     fmt::join(others, ", ")));
  }
  if (const double aspect = info.parts.front().pixelAspect; aspect != 1)
    tell("aspect", RemarkCode::kLeftOut, notSquare(aspect));
  return {};
}

/// Of a .png: what is not read of it.
Status tellOfPng(const std::string& path, ToldOfMaps& told, Progress& progress) {
  VOLUTE_ASSIGN(const auto extras, readPngKind(path));
  if (extras.pictures > 1 && told.insert("pictures").second) {
    progress.remark(
        Remark{RemarkCode::kLeftOut,
               fmt::format("{}: holds {} pictures; the first is read", path, extras.pictures)}
            .in(path));
  }
  if (extras.pixelAspect != 1 && told.insert("aspect").second) {
    progress.remark(
        Remark{RemarkCode::kLeftOut, fmt::format("{}: {}", path, notSquare(extras.pixelAspect))}.in(
            path));
  }
  return {};
}

Result<FogMap> readMap(const std::string& path, const FogPlacement& placement, FogColour colour,
                       const std::string& unit, ToldOfMaps& told, const Reading& reading) {
  VOLUTE_ASSIGN(auto image, readImage(path, {.raw = true, .maxMemory = reading.maxMemory}));
  if (extensionOf(path) == ".exr")
    VOLUTE_TRY(tellOfExr(path, image, unit, placement.sigmaMax, told, reading.progress));
  else
    VOLUTE_TRY(multiplyByAlpha(path, image, reading));
  if (extensionOf(path) == ".png")
    VOLUTE_TRY(tellOfPng(path, told, reading.progress));
  auto map = FogMap::fromImage(image, placement, colour);
  if (!map)
    return aboutFile(path, map.error());
  return map;
}

Result<Maps> readPictures(const std::vector<std::string>& paths, const std::vector<double>& numbers,
                          const FogDescription& fog, const Reading& reading) {
  Maps maps;
  ToldOfMaps told;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    VOLUTE_ASSIGN(auto map, readMap(paths[i], fog.placement, fog.colour, "/m", told, reading));
    maps.maps.push_back(std::move(map));
    maps.times.push_back(timeOfNumber(numbers[i], numbers.front(), fog));
  }
  return maps;
}

Result<Maps> readPattern(const std::string& path, const FogDescription& fog,
                         const Reading& reading) {
  VOLUTE_ASSIGN(const auto pattern, FramePattern::parse(path));
  VOLUTE_ASSIGN(const auto files, pattern.list(SubFrames::kAllowed));
  std::vector<std::string> paths;
  std::vector<double> numbers;
  std::vector<int> units;
  for (const NumberedFile& file : files) {
    paths.push_back(file.path.string());
    numbers.push_back(file.frame());
    units.push_back(file.number);
  }
  if (const auto gaps = missingNumbers(units, files.front().scale); !gaps.empty()) {
    reading.progress.remark(
        Remark{RemarkCode::kAssumed,
               fmt::format("{}: {}; the maps before and after are mixed there", path, gaps)}
            .in(path));
  }
  return readPictures(paths, numbers, fog, reading);
}

/// A volume one voxel high; row 0 is that of the smallest y.
Result<Maps> readVolume(const std::string& path, const FogDescription& fog, Reading& reading) {
  auto opened = openVolume(path, {}, reading);
  bool placeless = false;
  const bool needsBounds =
      !opened && std::ranges::count(opened.error().hints, Hint::set("bounds")) > 0;
  if (needsBounds) {  // its cells may be in degrees
    InputOptions anywhere;
    anywhere.bounds = Box3{Vec3::Zero(), Vec3::Ones()};
    auto again = openVolume(path, anywhere, reading);
    if (!again)
      return tl::unexpected(opened.error());
    opened = std::move(again);
    placeless = true;
  }
  if (!opened)
    return tl::unexpected(opened.error());
  const VolumeInput& input = *opened;
  const VolumeInfo& info = input.source->info();
  if (placeless && !fog.placed) {
    reading.progress.remark(
        Remark{RemarkCode::kLeftOut,
               fmt::format("{}: its coordinates are not metres and are not used; the map's own "
                           "cell is, {:g} m",
                           path, fog.placement.cell)}
            .in(path));
  }
  if (info.z != 1 || info.channels != 1) {
    return fail(ErrorCode::kInvalidData,
                "{}: {} x {} x {} voxels of {} channels are no fog map; expected one voxel along z "
                "and one channel",
                path, info.x, info.y, info.z, info.channels);
  }
  if (4 * info.frameValues() > reading.maxMemory) {
    return fail(ErrorCode::kTooLarge,
                "{}: a map of {} x {} voxels needs {} MiB of memory, more than the {} MiB allowed",
                path, info.x, info.y, info.frameValues() >> 18, reading.maxMemory >> 20);
  }
  Maps maps;
  if (!placeless)
    maps.place = info;
  float largest = 0;
  std::vector<float> frame(info.frameValues());
  for (int i = 0; i < info.frames; ++i) {
    VOLUTE_TRY(input.source->readFrame(i, frame));
    for (const float value : frame) largest = std::max(largest, value);
    SplineGrid grid(info.x, info.y);
    std::ranges::transform(frame, grid.c.begin(),
                           [&](float value) { return value * fog.placement.sigmaMax; });
    auto map = FogMap::fromCoefficients(std::move(grid), fog.placement);
    if (!map)
      return aboutFile(fmt::format("{}: frame {}", path, info.frameNumbers[i]), map.error());
    maps.maps.push_back(std::move(*map));
    maps.times.push_back(info.timesAssumed
                             ? timeOfNumber(info.frameScale.frame(info.frameNumbers[i]),
                                            info.frameScale.frame(info.frameNumbers.front()), fog)
                             : info.times[i]);
  }
  if (largest > 1) {
    reading.progress.remark(
        Remark{RemarkCode::kDoubtful,
               fmt::format("{}: values up to {:g} count as they are, not as shares of a maximum as "
                           "a picture's do: the extinction is up to {:g} /m",
                           path, largest, largest * fog.placement.sigmaMax)}
            .in(path));
  }
  return maps;
}

Result<Maps> loadMaps(const FogDescription& fog, Reading& reading) {
  const std::string& first = fog.maps.front();
  constexpr std::string_view kOtherPictures[] = {".jpg", ".jpeg", ".tif",  ".tiff", ".pgm", ".ppm",
                                                 ".bmp", ".tga",  ".webp", ".gif",  ".jp2", ".hdr"};
  if (std::ranges::find(kOtherPictures, extensionOf(first)) != std::end(kOtherPictures)) {
    return fail(ErrorCode::kUnsupported,
                "{}: pictures of this kind are not read as maps; expected .png (8 or 16 bits) or "
                ".exr, or a volume one voxel high",
                first);
  }
  if (fog.maps.size() == 1 && !isPicturePath(first))
    return readVolume(first, fog, reading);
  if (fog.maps.size() == 1 && namesSeriesOfFiles(first))
    return readPattern(first, fog, reading);
  std::vector<double> numbers(fog.maps.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<double>(i);
  return readPictures(fog.maps, numbers, fog, reading);
}

/// What the picture spans, by the rays at its border; nullopt: all around.
std::optional<PolarSector> sectorOf(const Camera& camera) {
  std::vector<float> x, y, z;
  const auto add = [&](double px, double py) {
    const Vec3 direction = camera.ray(px, py).direction;
    x.push_back(static_cast<float>(direction.x()));
    y.push_back(static_cast<float>(direction.y()));
    z.push_back(static_cast<float>(direction.z()));
  };
  for (const double py : {0.0, static_cast<double>(camera.height())})
    for (int px = 0; px <= camera.width(); ++px) add(px, py);
  for (const double px : {0.0, static_cast<double>(camera.width())})
    for (int py = 0; py <= camera.height(); ++py) add(px, py);
  return PolarSector::of({camera.eye(), x, y, z, {}});
}

}  // namespace

bool shadowsFog(const TriangleScene& geometry, std::span<const Lamp> lamps, const FogMedium& fog) {
  constexpr std::size_t kTriangles = 4096;
  const auto triangles = geometry.triangles();
  const std::size_t step = std::max<std::size_t>(1, triangles.size() / kTriangles);
  std::vector<Segment> behind;
  for (std::size_t i = 0; i < triangles.size(); i += step) {
    const auto& corners = triangles[i].corners;
    const Vec3 middle = (corners[0] + corners[1] + corners[2]) / 3;
    for (const Lamp& lamp : lamps) {
      const Segment way = lamp.towards(middle);
      behind.push_back({middle, -way.direction, 0, std::numeric_limits<double>::infinity()});
    }
  }
  std::vector<double> depths(behind.size());
  fog.opticalDepth(behind, depths);
  return std::ranges::any_of(depths, [](double depth) { return depth > 0; });
}

namespace {

/// Degree and cell decide where a coefficient peaks.
Vec3 registered(const Vec3& origin, double cell, int degree, FogRegistration registration) {
  const double shift = registration == FogRegistration::kPixel ? -0.5 * degree * cell : 0;
  return origin + Vec3(shift, shift, 0);
}

FogDescription registered(FogDescription fog) {
  FogPlacement& map = fog.placement;
  map.origin = registered(map.origin, map.cell, fog.options.degree, fog.registration);
  if (fog.top) {
    FogPlacement& top = fog.top->placement;
    top.origin = registered(top.origin, top.cell, 1, fog.registration);
  }
  return fog;
}

}  // namespace

namespace {

/// Where a volume's cells lie, if it says so and the map does not lie there.
void tellOfPlace(const VolumeInfo& info, const FogDescription& fog, Progress& progress) {
  VolumeInfo silent = info;
  silent.bounds = Box3();
  silent.fillDefaults();
  const auto same = [](const Vec3& a, const Vec3& b) {
    return (a - b).head<2>().norm() <= 1e-5 * std::max(a.head<2>().norm(), 1.0);
  };
  const Vec3 cell = info.voxelSize(), corner = info.bounds.min;
  const FogPlacement& map = fog.placement;
  const bool stated = !same(silent.bounds.min, corner) || !same(silent.bounds.max, info.bounds.max);
  if (fog.placed || !stated || (same(cell, Vec3::Constant(map.cell)) && same(corner, map.origin)))
    return;
  progress.remark(
      Remark{RemarkCode::kLeftOut,
             fmt::format("{}: says that its cells are {:g} x {:g} m from x = {}, y = {} m; this "
                         "is not used: the map's are {:g} m from {}, {} m",
                         fog.maps.front(), cell.x(), cell.y(), plainNumber(corner.x()),
                         plainNumber(corner.y()), map.cell, plainNumber(map.origin.x()),
                         plainNumber(map.origin.y()))}
          .in(fog.maps.front()));
}

/// Beyond the map of heights there is no fog.
void tellOfTop(const FogMap& map, const FogMap& top, const FogDescription& fog,
               Progress& progress) {
  const auto end = [](const FogMap& of) {
    return Vec3(of.origin + of.cell * Vec3(of.coefficients.columns, of.coefficients.rows, 0));
  };
  const double slack = top.cell;
  const Vec3 low = top.origin, high = end(top), from = map.origin, to = end(map);
  if (low.x() <= from.x() + slack && low.y() <= from.y() + slack && high.x() >= to.x() - slack &&
      high.y() >= to.y() - slack)
    return;
  progress.remark(
      Remark{RemarkCode::kDoubtful,
             fmt::format("{}: the map of the top covers x = {} to {}, y = {} to {} m, the "
                         "map of the fog {} to {}, {} to {} m: there is no fog beyond the "
                         "top's; its cell is {:g} m",
                         fog.top->file, plainNumber(low.x()), plainNumber(high.x()),
                         plainNumber(low.y()), plainNumber(high.y()), plainNumber(from.x()),
                         plainNumber(to.x()), plainNumber(from.y()), plainNumber(to.y()), top.cell)}
          .in(fog.top->file));
}

void tellOfIdle(const FogDescription& fog, Progress& progress) {
  for (const auto& [member, reason] : fog.idle) {
    const std::string text = fmt::format("{} has no effect: {}", member, reason);
    progress.remark(fog.origin.options()
                        ? Remark(RemarkCode::kLeftOut, text)
                        : Remark(RemarkCode::kLeftOut, fmt::format("{}: {}", fog.where(), text))
                              .in(fog.origin.file, fog.origin.path + '/' + member));
  }
}

/// Why no polar table serves a fog, whatever the camera; empty: one may.
std::string unserved(const FogDescription& fog, bool lit) {
  if (lit)
    return "fog in the light of lamps is walked";
  if (fog.options.degree == 0)
    return "fog of degree 0 is walked";
  if (fog.top)
    return "fog with a top is walked";
  if (!fog.options.detail.finestOnly())
    return "fog with dropped details (mu, cell_angle) is walked";
  const bool decays =
      std::ranges::any_of(fog.profile.zones(), [](const auto& zone) { return zone.decay != 0; });
  return decays ? "fog of an exponential profile is walked" : "";
}

}  // namespace

Result<std::shared_ptr<FogSceneMedium>> FogSceneMedium::open(const FogDescription& said,
                                                             std::vector<Lamp> lamps,
                                                             Reading& reading) {
  auto opened = std::make_shared<FogSceneMedium>();
  FogSceneMedium& layer = *opened;
  layer.description_ = said;
  layer.lamps_ = std::move(lamps);
  layer.readAt_ = said.placement.origin;
  const FogDescription description = registered(said);
  VOLUTE_ASSIGN(auto maps, loadMaps(description, reading));
  FogDescription told = said;
  if (const auto why = unserved(said, !layer.lamps_.empty());
      said.path == FogPath::kPolar && !why.empty())
    told.idle.push_back({"path", why});
  if (maps.maps.size() == 1 && !(said.clock == Clock()))
    told.idle.push_back({"time", "there is one map, and wind follows the scene's time"});
  tellOfIdle(told, reading.progress);
  if (said.borderInWind() == FogBorder::kRepeat && !said.border && !said.origin.options()) {
    reading.progress.remark(
        Remark(fmt::format("{}: what the wind blows out of the map comes in on its other side, as "
                           "if border were \"repeat\"",
                           said.where()))
            .in(said.origin.file, said.origin.path));
  }
  if (maps.place)
    tellOfPlace(*maps.place, said, reading.progress);
  if (!description.times.empty() && description.times.size() != maps.maps.size()) {
    return tl::unexpected(description.about(
        {ErrorCode::kInvalidData, fmt::format("{} times for {} maps; expected one for each",
                                              description.times.size(), maps.maps.size())},
        "times"));
  }
  layer.times_ = description.times.empty() ? maps.times : description.times;
  if (description.top && maps.maps.size() > 1) {
    return tl::unexpected(description.about(
        {ErrorCode::kUnsupported,
         fmt::format("fog with a top has one map, not a sequence of {}", maps.maps.size())},
        "top"));
  }
  if (description.top) {
    ToldOfMaps toldOfTop;
    VOLUTE_ASSIGN(const auto top, readMap(description.top->file, description.top->placement,
                                          FogColour::kRefuse, "m", toldOfTop, reading));
    tellOfTop(maps.maps.front(), top, description, reading.progress);
    auto fog = FogMedium::make(maps.maps.front(), description.profile, description.options, top);
    if (!fog)
      return aboutEntry(description, fog.error());
    layer.still_ = std::make_shared<const FogMedium>(std::move(*fog));
    layer.describe();
    return opened;
  }
  std::vector<FogSequence::Frame> frames;
  for (std::size_t i = 0; i < maps.maps.size(); ++i)
    frames.push_back({layer.times_[i], std::move(maps.maps[i])});
  auto sequence = FogSequence::make(std::move(frames), description.profile, description.options);
  if (!sequence)
    return aboutEntry(description, sequence.error());
  layer.sequence_ = std::make_shared<const FogSequence>(std::move(*sequence));
  if (said.borderInWind() != FogBorder::kZero) {
    if (const auto filled = layer.bordered(layer.stored(0), Vec3::Zero()); !filled)
      return aboutEntry(description, filled.error());
  }
  layer.describe();
  return opened;
}

void FogSceneMedium::describe() {
  info_.file = description_.maps.front();
  info_.what = "a map of fog";
  info_.kind = "fog";
  info_.bounds = info_.fileBounds = fogAt(0).bounds();
  const Interval seen = description_.profile.seenHeights();
  info_.framed = info_.bounds;
  info_.framed->min.z() = std::max(info_.bounds.min.z(), seen.begin);
  info_.framed->max.z() = std::min(info_.bounds.max.z(), seen.end);
  info_.takeFrames(*this, static_cast<int>(times_.size()), description_.clock);
  info_.endless = true;
  info_.moves = description_.wind != Vec3::Zero();
  info_.measured = true;
}

bool FogSceneMedium::readsTheSame(const FogDescription& a, const FogDescription& b) {
  const auto placed = [](const FogPlacement& p, const FogPlacement& q) {
    return p.cell == q.cell && p.sigmaMax == q.sigmaMax;
  };
  if (a.top.has_value() != b.top.has_value())
    return false;
  if (a.top) {
    const bool same = a.top->file == b.top->file && placed(a.top->placement, b.top->placement) &&
                      a.top->placement.origin == b.top->placement.origin &&
                      a.placement.origin == b.placement.origin;
    if (!same)
      return false;
  }
  return a.maps == b.maps && a.times == b.times && a.rate == b.rate && a.byNumber == b.byNumber &&
         a.registration == b.registration && placed(a.placement, b.placement) &&
         a.colour == b.colour && a.options.degree == b.options.degree &&
         a.options.levels == b.options.levels && a.options.detail.mu == b.options.detail.mu &&
         a.options.detail.cellAngle == b.options.detail.cellAngle &&
         (a.options.color == b.options.color).all();
}

std::shared_ptr<FogSceneMedium> FogSceneMedium::with(const FogDescription& description,
                                                     std::vector<Lamp> lamps) const {
  auto layer = std::make_shared<FogSceneMedium>(*this);
  layer->description_ = description;
  layer->lamps_ = std::move(lamps);
  layer->painted_.reset();
  if (still_)
    layer->still_ = std::make_shared<const FogMedium>(still_->withProfile(description.profile));
  if (sequence_) {
    layer->sequence_ =
        std::make_shared<const FogSequence>(sequence_->withProfile(description.profile));
  }
  layer->describe();
  return layer;
}

double FogSceneMedium::timeOf(int position) const {
  return description_.clock.sceneTime(times_[position]);
}

FogMedium FogSceneMedium::stored(double time) const {
  return still_ ? *still_ : sequence_->at(description_.clock.at(time, times_));
}

/// The wind is the scene's: it blows on where a loop begins again.
FogMedium FogSceneMedium::mapAt(double time) const {
  return stored(time).shifted(time * description_.wind + (description_.placement.origin - readAt_));
}

namespace {

/// What the map and the profile make, whatever the law of the picture.
class FogProbe final : public FieldProbe {
 public:
  explicit FogProbe(std::shared_ptr<const FogSceneMedium> fog) : fog_(std::move(fog)) {}

  Result<std::vector<ProbedField>> at(double time, const Vec3& place) override {
    return std::vector<ProbedField>{{"extinction", {fog_->fogAt(time).extinction(place)}, "1/m"}};
  }

 private:
  std::shared_ptr<const FogSceneMedium> fog_;
};

}  // namespace

std::unique_ptr<FieldProbe> FogSceneMedium::fieldProbe() const {
  return std::make_unique<FogProbe>(shown());
}

FogMedium FogSceneMedium::fogAt(double time) const {
  if (description_.borderInWind() == FogBorder::kZero)
    return mapAt(time);
  const Vec3 placed = description_.placement.origin - readAt_;
  auto filled = bordered(stored(time), time * description_.wind);
  return filled ? filled->shifted(placed) : mapAt(time);  // too large: open() says so
}

/// Whole cells of the way move the coefficients within the map's rectangle, the rest moves the map.
/// Of the pixels that enter and leave, those parts count that have: the rectangle stays that of
/// calm air, with as much fog where the map is of one value, and within it is what an endless map
/// shows.
Result<FogMedium> FogSceneMedium::bordered(const FogMedium& map, const Vec3& blown) const {
  const bool repeats = description_.borderInWind() == FogBorder::kRepeat;
  const double cell = map.cell();
  const int columns = map.levels().columns(), rows = map.levels().rows();
  const double cellsX = std::floor(blown.x() / cell), cellsY = std::floor(blown.y() / cell);
  // A multiple of the map's size changes nothing, or all of it is its border by now.
  const auto whole = [&](double cells, int count) {
    return static_cast<int>(repeats ? std::fmod(cells, count)
                                    : std::clamp<double>(cells, -2.0 * count, 2.0 * count));
  };
  const int wholeX = whole(cellsX, columns), wholeY = whole(cellsY, rows);
  const auto from = [&](int i, int count) {
    return repeats ? ((i % count) + count) % count : std::clamp(i, 0, count - 1);
  };
  const auto share = [](int i, int count, double entered) {
    return i == 0 ? entered : i == count ? 1 - entered : 1;
  };
  const double enteredX = blown.x() / cell - cellsX, enteredY = blown.y() / cell - cellsY;
  const std::vector<double> coefficients = map.coefficients();
  SplineGrid grid(columns + 1, rows + 1);
  for (int j = 0; j < grid.rows; ++j) {
    const int row = from(j - 1 - wholeY, rows);
    for (int i = 0; i < grid.columns; ++i) {
      const int column = from(i - 1 - wholeX, columns);
      grid.at(i, j) = coefficients[static_cast<std::size_t>(row) * columns + column] *
                      share(i, columns, enteredX) * share(j, rows, enteredY);
    }
  }
  FogPlacement placement = registered(description_).placement;
  placement.origin += readAt_ - description_.placement.origin;
  placement.origin +=
      Vec3(blown.x() - (cellsX + 1) * cell, blown.y() - (cellsY + 1) * cell, blown.z());
  VOLUTE_ASSIGN(auto filled, FogMap::fromCoefficients(std::move(grid), placement));
  return FogMedium::make(filled, map.profile(), map.options());
}

Result<std::shared_ptr<const MediumSnapshot>> FogSceneMedium::at(const SnapshotRequest& request,
                                                                 Progress&) {
  FogLight light{description_.scattering,
                 description_.shadows,
                 {},
                 description_.blocks,
                 description_.multiple};
  return std::make_shared<const FogSnapshot>(shown(), request.time, request.factor,
                                             request.lit ? lamps_ : std::vector<Lamp>(),
                                             std::move(light));
}

std::vector<std::string> FogSceneMedium::files() const {
  std::vector<std::string> files = description().maps;
  if (description().top)
    files.push_back(description().top->file);
  return files;
}

/// What was painted are shares of the map's largest value.
std::shared_ptr<const FogSceneMedium> FogSceneMedium::shown() const {
  if (!painted_)
    return std::static_pointer_cast<const FogSceneMedium>(shared_from_this());
  std::vector<double> map = *painted_;
  for (double& value : map) value *= description().placement.sigmaMax / paintedMost_;
  auto shown = std::make_shared<FogSceneMedium>(*this);
  shown->still_ = std::make_shared<const FogMedium>(
      (still_ ? *still_ : sequence_->at(times_.front())).withCoefficients(map));
  return shown;
}

std::size_t FogSceneMedium::values() const {
  const FogLevels& levels = mapAt(0).levels();
  return static_cast<std::size_t>(levels.columns()) * levels.rows();
}

bool FogSceneMedium::paintable() const {
  const FogDescription& fog = description();
  return fog.maps.size() == 1 && isPicturePath(fog.maps.front()) &&
         !namesSeriesOfFiles(fog.maps.front()) && fog.placement.sigmaMax > 0;
}

Status FogSceneMedium::paint(std::vector<double> coefficients, bool unsaved) {
  if (values() != coefficients.size())
    return fail(ErrorCode::kInvalidArgument, "the map of fog has another size by now");
  painted_ = std::move(coefficients);
  paintedMost_ = description().placement.sigmaMax;
  unsaved_ = unsaved;
  return {};
}

void FogSceneMedium::savedAs(const std::string& map) {
  unsaved_ = false;
  description_.maps = {map};
  info_.file = map;
}

void FogSceneMedium::keepPainted(const FogSceneMedium& other) {
  if (!other.painted_ || other.painted_->size() != values())
    return;
  painted_ = other.painted_, paintedMost_ = other.paintedMost_;
  unsaved_ = other.unsaved_;
}

std::optional<PolarOptions> FogSceneMedium::polarFor(const Camera& camera,
                                                     const FogMedium& fog) const {
  const bool serves = lamps_.empty() && description_.options.degree > 0 && !camera.isOrthographic();
  if (description_.path == FogPath::kWalk || !serves)
    return std::nullopt;
  const PolarOptions options{.sector = sectorOf(camera)};
  if (description_.path == FogPath::kPolar)
    return options;
  // A row of the table is a walk; one looks up where that saves most of the rays.
  constexpr int kFineMap = 128;
  constexpr double kRaysARow = 32;
  const auto layout = PolarLayout::of(fog, camera.eye(), options);
  if (!layout || std::max(fog.levels().columns(), fog.levels().rows()) < kFineMap ||
      static_cast<double>(camera.width()) * camera.height() <
          kRaysARow * layout->azimuths * layout->sectors)
    return std::nullopt;
  return options;
}

}  // namespace volute
