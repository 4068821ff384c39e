// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_sight.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "volute/base/assert.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/media/occluded_sight.hpp"
#include "volute/scene/kinds.hpp"

namespace volute {
namespace {

/// About volumes of which a scene says neither what they take away of light nor what else they are.
std::vector<Remark> hidingNothing(const Scene& scene) {
  std::vector<Remark> remarks;
  const auto& media = scene.json()["media"];
  for (std::size_t i = 0; i < media.size(); ++i) {
    const auto& entry = media[i];
    if (entry.value("kind", "") != "volume" || scene.media()[i]->info().absorbs ||
        std::ranges::any_of(std::array{"extinction", "emission", "transfer", "preset"},
                            [&](const char* name) { return entry.contains(name); }))
      continue;
    remarks.push_back(
        Remark(
            RemarkCode::kDoubtful,
            fmt::format("warning: {}: /media/{} takes no light away and hides nothing: state its "
                        "\"extinction\" in 1/m, 0 for what only shines",
                        scene.path(), i))
            .in(scene.path(), fmt::format("/media/{}", i)));
  }
  return remarks;
}

/// A medium of several, and where it knows something.
struct Part {
  std::shared_ptr<const SightSnapshot> sight;
  Box3 bounds;
  bool clearBeyond = false;  ///< SightField::clearBeyond()
};

/// Several media at one time: depths and bounds add up, and what is opaque in one of them is. Where
/// one of them ends, another has to know what is beyond.
class SumOfSights final : public SightSnapshot {
 public:
  explicit SumOfSights(std::vector<Part> parts)
      : parts_(std::move(parts)), clear_(std::ranges::all_of(parts_, &Part::clearBeyond)) {}

  void look(std::span<const SightLine> lines, std::span<Sight> sights) const override {
    std::ranges::fill(sights, Sight{});
    std::vector<Sight> own(lines.size());
    for (const Part& part : parts_) {
      part.sight->look(lines, own);
      for (std::size_t i = 0; i < lines.size(); ++i) {
        Sight& sum = sights[i];
        sum.depth += own[i].depth, sum.low += own[i].low, sum.high += own[i].high;
        sum.blocked |= own[i].blocked;
        sum.covered &= own[i].covered || isCoveredWithin(part, lines[i]);
      }
    }
    for (std::size_t i = 0; i < lines.size(); ++i)
      sights[i].covered &= clear_ || isWithinParts(lines[i]);
  }

  void bounds(std::span<const SightLine> lines, std::span<double> low,
              std::span<double> high) const override {
    std::ranges::fill(low, 0.0), std::ranges::fill(high, 0.0);
    std::vector<double> ownLow(lines.size()), ownHigh(lines.size());
    for (const Part& part : parts_) {
      part.sight->bounds(lines, ownLow, ownHigh);
      for (std::size_t i = 0; i < lines.size(); ++i) low[i] += ownLow[i], high[i] += ownHigh[i];
    }
  }

  void blocked(std::span<const SightLine> lines, std::span<unsigned char> out) const override {
    std::ranges::fill(out, static_cast<unsigned char>(0));
    std::vector<unsigned char> own(lines.size());
    for (const Part& part : parts_) {
      part.sight->blocked(lines, own);
      for (std::size_t i = 0; i < lines.size(); ++i) out[i] |= own[i];
    }
  }

  void places(std::span<const Vec3> points, std::span<Place> places) const override {
    std::ranges::fill(places, Place::kOutside);
    std::vector<Place> own(points.size());
    for (const Part& part : parts_) {
      part.sight->places(points, own);
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (own[i] == Place::kSolid)
          places[i] = Place::kSolid;
        else if (own[i] == Place::kGas && places[i] == Place::kOutside && knows(part, points[i]))
          places[i] = Place::kGas;
      }
    }
  }

  std::vector<PlanShape> shapes(double z) const override {
    std::vector<PlanShape> all;
    for (const Part& part : parts_) {
      const auto own = part.sight->shapes(z);
      all.insert(all.end(), own.begin(), own.end());
    }
    return all;
  }

  void extinction(std::span<const Vec3> points, std::span<double> extinction) const override {
    std::vector<double> own(points.size());
    std::vector<std::uint8_t> known(points.size(), 0);
    std::ranges::fill(extinction, 0.0);
    for (const Part& part : parts_) {
      part.sight->extinction(points, own);
      add(part, points, own, extinction, known);
    }
    setUnknown(known, extinction);
  }

  void extinctionBounds(std::span<const Vec3> points, std::span<double> low,
                        std::span<double> high) const override {
    std::vector<double> ownLow(points.size()), ownHigh(points.size());
    std::vector<std::uint8_t> known(points.size(), 0);
    std::ranges::fill(low, 0.0), std::ranges::fill(high, 0.0);
    for (const Part& part : parts_) {
      part.sight->extinctionBounds(points, ownLow, ownHigh);
      add(part, points, ownLow, low, known);
      add(part, points, ownHigh, high, known);
    }
    setUnknown(known, low), setUnknown(known, high);
  }

  void floors(std::span<const Vec3> points, double drop, std::span<double> z) const override {
    std::ranges::fill(z, kUnknown);
    std::vector<double> own(points.size());
    for (const Part& part : parts_) {
      part.sight->floors(points, drop, own);
      for (std::size_t i = 0; i < points.size(); ++i) z[i] = std::fmax(z[i], own[i]);
    }
  }

  std::uint64_t geometry() const override { return 0; }

  void weigh(const SightLine&, std::vector<SightWeight>&, Sight&) const override {}

  SightData data() const override { return {}; }

 private:
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  /// Whether what a part says of a point counts: the clear air beyond a part does not where another
  /// ends.
  bool knows(const Part& part, const Vec3& point) const {
    return clear_ || part.bounds.contains(point);
  }

  static Interval within(const Part& part, const SightLine& line) {
    const double length = line.length();
    if (!(length > 0))
      return part.bounds.contains(line.eye) ? Interval{0, length} : Interval{};
    return part.bounds.intersect(line.eye, (line.target - line.eye) / length)
        .intersect({0, length});
  }

  /// Of a line that leaves a part's bounds: whether the part knows what lies in them.
  static bool isCoveredWithin(const Part& part, const SightLine& line) {
    const Interval inside = within(part, line);
    if (inside.empty())
      return true;
    const double length = line.length();
    if (!(inside.begin > 0) && !(inside.end < length))
      return false;  // the whole line, of which it said so
    const Vec3 along = (line.target - line.eye) / length;
    const SightLine own{line.eye + inside.begin * along, line.eye + inside.end * along};
    Sight sight;
    part.sight->look({&own, 1}, {&sight, 1});
    return sight.covered;
  }

  /// Whether each place of a line is within a part's bounds.
  bool isWithinParts(const SightLine& line) const {
    const double length = line.length(), rounding = 1e-6 * (1 + length);
    std::vector<Interval> inside;
    for (const Part& part : parts_) inside.push_back(within(part, line));
    std::erase_if(inside, [](const Interval& one) { return one.empty(); });
    std::ranges::sort(inside, {}, &Interval::begin);
    double reached = 0;
    for (const Interval& one : inside) {
      if (one.begin > reached + rounding)
        return false;
      reached = std::max(reached, one.end);
    }
    return reached >= length - rounding;
  }

  /// NaN within a part's bounds is unknown, or solid; outside another has to know.
  void add(const Part& part, std::span<const Vec3> points, std::span<const double> own,
           std::span<double> sum, std::vector<std::uint8_t>& known) const {
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!std::isnan(own[i])) {
        sum[i] += own[i];
        known[i] |= knows(part, points[i]) ? 1 : 0;
      } else if (part.bounds.contains(points[i])) {
        sum[i] = kUnknown;
      }
    }
  }

  static void setUnknown(std::span<const std::uint8_t> known, std::span<double> values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (known[i] == 0)
        values[i] = kUnknown;
    }
  }

  std::vector<Part> parts_;
  bool clear_;  // beyond all of them
};

/// The media of a scene, each by its own sight, at the times that all of those that change store.
class SceneSight final : public SightField {
 public:
  static Result<std::unique_ptr<SightField>> make(const Scene& scene, Reading& reading) {
    auto sight = std::make_unique<SceneSight>();
    sight->remarks_ = hidingNothing(scene);
    for (const auto& medium : scene.media()) {
      VOLUTE_ASSIGN(auto field, medium->sight(reading));
      sight->fields_.push_back({std::move(field), nullptr, medium->info().moves});
    }
    VOLUTE_TRY(sight->setTimes(scene.path()));
    return sight;
  }

  std::string description() const override {
    std::string text;
    for (const Field& one : fields_) text += (text.empty() ? "" : " + ") + one.sight->description();
    return text;
  }

  bool reaches(double z) const override {
    return std::ranges::any_of(fields_, [&](const Field& one) { return one.sight->reaches(z); });
  }

  std::span<const double> times() const override { return times_; }

  double begin() override {
    double first = times_.front();
    for (const Field& one : fields_)
      first = std::min(first, one.moves() ? one.sight->begin() : first);
    return first;
  }

  double end() override {
    double last = times_.back();
    for (const Field& one : fields_) last = std::max(last, one.moves() ? one.sight->end() : last);
    return last;
  }

  std::vector<Remark> remarks() const override {
    std::vector<Remark> all = remarks_;
    for (const Field& one : fields_) {
      const auto own = one.sight->remarks();
      all.insert(all.end(), own.begin(), own.end());
    }
    return all;
  }

  std::optional<double> largestRead() const override {
    std::optional<double> largest;
    for (const Field& one : fields_) {
      if (const auto own = one.sight->largestRead())
        largest = std::max(largest.value_or(*own), *own);
    }
    return largest;
  }

  std::vector<Remark> remarksOn(double) const override {
    std::vector<Remark> all;
    for (const Field& one : fields_) {
      const auto own = one.sight->largestRead();
      const auto said = own ? one.sight->remarksOn(*own) : std::vector<Remark>();
      all.insert(all.end(), said.begin(), said.end());
    }
    return all;
  }

  std::optional<double> north() const override {
    for (const Field& one : fields_) {
      if (const auto own = one.sight->north())
        return own;
    }
    return std::nullopt;
  }

  Result<std::unique_ptr<PointField>> conditions(std::string_view quantity) override {
    std::vector<std::unique_ptr<PointField>> found;
    std::optional<Error> missing;
    for (Field& one : fields_) {
      auto own = one.sight->conditions(quantity);
      if (own)
        found.push_back(std::move(*own));
      else if (own.error().code != ErrorCode::kNotFound)
        return own;
      else if (!missing)
        missing = std::move(own.error());
    }
    if (found.empty() && missing)
      return tl::unexpected(std::move(*missing));
    return std::make_unique<BestPoints>(std::move(found));
  }

  Result<std::vector<FirePlace>> fires() override {
    std::vector<FirePlace> all;
    for (Field& one : fields_) {
      VOLUTE_ASSIGN(const auto own, one.sight->fires());
      all.insert(all.end(), own.begin(), own.end());
    }
    return all;
  }

  /// Of the first that says something.
  Result<CaseFacts> facts() override {
    for (Field& one : fields_) {
      VOLUTE_ASSIGN(auto own, one.sight->facts());
      if (!own.title.empty() || !own.fire.empty())
        return own;
    }
    return CaseFacts{};
  }

 protected:
  Box3 ownBounds() const override {
    Box3 all;
    for (const Field& one : fields_) all.extend(one.sight->bounds());
    return all;
  }

  Result<std::shared_ptr<const SightSnapshot>> readOwn(std::size_t time) override {
    std::vector<Part> parts;
    for (Field& one : fields_) {
      auto& still = one.still;
      if (!one.moves() && !one.blows && !still) {
        VOLUTE_ASSIGN(still, one.sight->read(0));
      }
      auto own = still;
      if (!own) {
        VOLUTE_ASSIGN(own, one.blows ? one.sight->readAt(times_[time])
                                     : one.sight->read(placeOf(*one.sight, times_[time])));
      }
      parts.push_back({std::move(own), one.sight->bounds(), one.sight->clearBeyond()});
    }
    return std::make_shared<const SumOfSights>(std::move(parts));
  }

 private:
  struct Field {
    std::unique_ptr<SightField> sight;
    std::shared_ptr<const SightSnapshot> still;  ///< of one that does not move
    bool blows = false;                          ///< as MediumInfo::moves

    bool moves() const { return sight->times().size() > 1; }
  };

  /// The position of a time that a field stores.
  static std::size_t placeOf(const SightField& field, double time) {
    const auto place = storedPlace(field.times(), time);
    VOLUTE_ASSERT(place);
    return place->share > 0.5 ? place->second : place->first;
  }

  Status setTimes(const std::string& scene) {
    const Field* fewest = nullptr;
    std::size_t most = 0;
    for (const Field& one : fields_) {
      const std::size_t count = one.sight->times().size();
      if (one.moves() && (!fewest || count < fewest->sight->times().size()))
        fewest = &one;
      most = std::max(most, count);
    }
    if (!fewest) {
      times_ = {fields_.empty() ? 0 : fields_.front().sight->times().front()};
      return {};
    }
    for (const double time : fewest->sight->times()) {
      if (std::ranges::all_of(fields_, [&](const Field& one) {
            return !one.moves() || isStored(one.sight->times(), time);
          }))
        times_.push_back(time);
    }
    if (times_.empty()) {
      return fail(ErrorCode::kInvalidArgument,
                  "{}: no time is stored by all of its media that change, so that nothing is known "
                  "of them together; expected media with times in common",
                  scene);
    }
    if (times_.size() < most) {
      remarks_.push_back(
          Remark(RemarkCode::kLeftOut,
                 fmt::format("{}: sight lines are of the times that all of its media "
                             "store, which are {}; one of them stores {}",
                             scene, times_.size(), most))
              .in(scene));
    }
    return {};
  }

  std::vector<Field> fields_;
  std::vector<double> times_;
  std::vector<Remark> remarks_;
};

}  // namespace

Result<std::unique_ptr<SightField>> sightOf(Scene scene, const SceneOptions& options,
                                            Progress& progress) {
  Reading reading{progress, options.maxMemory, options.files.volumes.get()};
  if (scene.json().contains("clip")) {
    progress.remark(Remark(RemarkCode::kLeftOut,
                           fmt::format("{}: its clip is for pictures: sight lines go through all "
                                       "that it cuts off",
                                       scene.path()))
                        .in(scene.path(), "/clip"));
  }
  std::unique_ptr<SightField> field;
  if (scene.media().size() == 1) {
    for (Remark& remark : hidingNothing(scene))
      scene.media()[0]->remarks.push_back(std::move(remark));
    VOLUTE_ASSIGN(field, scene.media()[0]->sight(reading));
  } else {
    VOLUTE_ASSIGN(field, SceneSight::make(scene, reading));
  }
  const bool blows =
      std::ranges::any_of(scene.media(), [](const auto& medium) { return medium->info().moves; });
  if (blows && field->times().size() == 1) {
    progress.remark(Remark(RemarkCode::kLeftOut,
                           fmt::format("{}: its wind is for pictures: nothing is stored over time, "
                                       "and sight lines see the media as they are at {} s",
                                       scene.path(), plainNumber(field->times().front())))
                        .in(scene.path()));
  }
  if (!scene.geometry().empty()) {
    field->wrap(
        [surfaces = scene.geometry()](std::shared_ptr<const SightSnapshot> media) {
          return std::make_shared<const OccludedSight>(std::move(media), surfaces);
        },
        scene.bounds());
  }
  return field;
}

Result<std::unique_ptr<SightField>> openSight(const std::string& path, const SceneOptions& options,
                                              Progress& progress) {
  registerUsualMedia();
  if (isScenePath(path)) {
    SceneOptions measuring = options;
    measuring.files.depths = true;
    VOLUTE_ASSIGN(auto scene, Scene::open(path, measuring, progress));
    return sightOf(std::move(scene), options, progress);
  }
  const MediumKind& kind = *mediumKindOf(path, false);
  auto entry = kind.sceneOf(std::filesystem::path(path).filename().string())["media"][0];
  entry.update(*options.members);
  Reading reading{progress, options.maxMemory, options.files.volumes.get()};
  const SceneLights lights;
  const TriangleScene geometry;
  OpenOptions files = options.files;
  files.sightOnly = true;
  MediumContext context{reading, files, lights, geometry, path, "/media/0"};
  VOLUTE_ASSIGN(const auto medium, kind.open(nlohmann::json(entry), context));
  return medium->sight(reading);
}

Result<std::unique_ptr<SightField>> openSight(const std::string& path, const SceneOptions& options,
                                              std::span<const double> heights,
                                              std::vector<Remark>& remarks, Progress& progress) {
  VOLUTE_ASSIGN(auto field, openSight(path, options, progress));
  const auto beyond = std::ranges::find_if(heights, [&](double z) { return !field->reaches(z); });
  // A scene says itself which source it shows; members are for a file alone.
  if (beyond == heights.end() || isScenePath(path) || options.members->contains("field"))
    return field;
  const std::string taller = field->tallerSource();
  if (taller.empty()) {
    const Box3 bounds = field->bounds();
    if (*beyond >= bounds.min.z() && *beyond <= bounds.max.z()) {
      remarks.push_back({RemarkCode::kDoubtful,
                         fmt::format("{} does not reach all of z = {} m: nothing is known of the "
                                     "rest, and no verdict is of it",
                                     field->description(), plainNumber(*beyond))});
    }
    return field;
  }
  SceneOptions other = options;
  (*other.members)["field"] = taller;
  remarks.push_back(
      {RemarkCode::kFallback,
       fmt::format(
           "at z = {} m, where eyes or signs are, extinction is read from {} alone, because {} "
           "leaves out places at that height; name a source to use it all the same: those "
           "places are then not known",
           plainNumber(*beyond), taller, field->description()),
       {Hint::choose("field")}});
  return openSight(path, other, progress);
}

}  // namespace volute
