// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_sight.hpp"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "volute/media/ray_sight.hpp"
#include "volute/scene/kinds.hpp"

namespace volute {
namespace {

/// Another instant, with surfaces in the way. Derives from the pure interface, not from
/// BasicSightInstant, so that no function of the other instant is lost.
class BehindSurfaces final : public SightInstant {
 public:
  BehindSurfaces(std::shared_ptr<const SightInstant> media, TriangleScene surfaces)
      : media_(std::move(media)), surfaces_(std::move(surfaces)) {}

  void look(std::span<const SightLine> lines, std::span<Sight> sights) const override {
    media_->look(lines, sights);
    const auto behind = occluded(lines);
    for (std::size_t i = 0; i < sights.size(); ++i) sights[i].blocked |= behind[i] != 0;
  }

  void bounds(std::span<const SightLine> lines, std::span<double> low,
              std::span<double> high) const override {
    media_->bounds(lines, low, high);
  }

  void blocked(std::span<const SightLine> lines, std::span<unsigned char> out) const override {
    media_->blocked(lines, out);
    const auto behind = occluded(lines);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] |= behind[i];
  }

  void places(std::span<const Vec3> points, std::span<Place> places) const override {
    media_->places(points, places);
  }

  void extinction(std::span<const Vec3> points, std::span<double> extinction) const override {
    media_->extinction(points, extinction);
  }

  void extinctionBounds(std::span<const Vec3> points, std::span<double> low,
                        std::span<double> high) const override {
    media_->extinctionBounds(points, low, high);
  }

  void floors(std::span<const Vec3> points, double drop, std::span<double> z) const override {
    media_->floors(points, drop, z);
    // Or a surface, if it is higher.
    std::vector<Segment> down;
    for (const Vec3& point : points) down.push_back({point, Vec3(0, 0, -1), 0, drop});
    std::vector<Hit> hits(points.size());
    surfaces_.nearest(down, hits);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (hits[i].found() && !(points[i].z() - hits[i].distance < z[i]))
        z[i] = points[i].z() - hits[i].distance;
    }
  }

  std::vector<PlanShape> shapes(double z) const override { return media_->shapes(z); }

  std::uint64_t geometry() const override { return media_->geometry(); }

  void weigh(const SightLine& line, std::vector<SightWeight>& weights,
             Sight& sight) const override {
    media_->weigh(line, weights, sight);
    sight.blocked |= occluded({&line, 1}).front() != 0;
  }

  SightData data() const override { return media_->data(); }

 private:
  static constexpr double kShort = 1e-9;  ///< a target on a surface is seen

  std::vector<std::uint8_t> occluded(std::span<const SightLine> lines) const {
    std::vector<Segment> segments;
    for (const SightLine& line : lines) {
      const double length = line.length();
      const Vec3 way = line.target - line.eye;
      segments.push_back(
          {line.eye, length > 0 ? Vec3(way / length) : Vec3::UnitX(), 0, length * (1 - kShort)});
    }
    std::vector<std::uint8_t> blocked(lines.size(), 0);
    surfaces_.occluded(segments, blocked);
    return blocked;
  }

  std::shared_ptr<const SightInstant> media_;
  TriangleScene surfaces_;
};

/// All media of a scene, along rays, with its surfaces in the way.
class SceneSight final : public SightField {
 public:
  explicit SceneSight(Scene scene) : scene_(std::move(scene)), bounds_(scene_.bounds()) {
    scene_.setLaw({});
    for (const auto& medium : scene_.media())
      times_.insert(times_.end(), medium->info().times.begin(), medium->info().times.end());
    std::ranges::sort(times_);
    times_.erase(std::ranges::unique(times_).begin(), times_.end());
    if (times_.empty())
      times_ = {0};
  }

  std::string description() const override {
    return fmt::format("{}: {} media, along rays", scene_.path(), scene_.media().size());
  }

  std::span<const double> times() const override { return times_; }

 protected:
  Box3 ownBounds() const override { return bounds_; }

  Result<std::shared_ptr<const SightInstant>> readOwn(std::size_t time) override {
    Progress quiet;
    VOLUTE_ASSIGN(const auto snapshot, scene_.at({.time = times_[time], .lit = false}, quiet));
    std::vector<AnyMedium> all;
    for (const auto& medium : snapshot.media) medium->addMedia(all);
    auto media = sightThrough(std::move(all));
    if (snapshot.geometry.empty())
      return media;
    return std::make_shared<const BehindSurfaces>(std::move(media), snapshot.geometry);
  }

 private:
  Scene scene_;
  Box3 bounds_;
  std::vector<double> times_;
};

}  // namespace

Result<std::unique_ptr<SightField>> sightOf(Scene scene, const SceneOptions& options,
                                            Progress& progress) {
  if (scene.media().size() != 1)
    return std::make_unique<SceneSight>(std::move(scene));
  const MediumEntry& entry = scene.description().media.front();
  Reading reading{progress, options.maxMemory, options.files.volumes.get()};
  MediumContext context{reading,      options.files, scene.description().lights,  scene.geometry(),
                        scene.path(), entry.path,    scene.description().version, scene.media()[0]};
  VOLUTE_ASSIGN(auto only, entry.kind->openSight(*entry.json, context));
  if (!scene.geometry().empty()) {
    only->wrap(
        [surfaces = scene.geometry()](std::shared_ptr<const SightInstant> media) {
          return std::make_shared<const BehindSurfaces>(std::move(media), surfaces);
        },
        scene.bounds());
  }
  return only;
}

Result<std::unique_ptr<SightField>> openSight(const std::string& path, const SceneOptions& options,
                                              Progress& progress) {
  registerUsualMedia();
  if (isScenePath(path)) {
    VOLUTE_ASSIGN(auto scene, Scene::open(path, options, progress));
    return sightOf(std::move(scene), options, progress);
  }
  const MediumKind& kind = *mediumKindOf(path, false);
  auto entry = kind.sceneOf(std::filesystem::path(path).filename().string())["media"][0];
  entry.update(*options.members);
  Reading reading{progress, options.maxMemory, options.files.volumes.get()};
  const SceneLights lights;
  const TriangleScene geometry;
  MediumContext context{reading, options.files, lights, geometry, path, "/media/0"};
  return kind.openSight(nlohmann::json(entry), context);
}

Result<std::unique_ptr<SightField>> openSight(const std::string& path, const SceneOptions& options,
                                              std::span<const double> heights,
                                              std::vector<Remark>& remarks, Progress& progress) {
  VOLUTE_ASSIGN(auto field, openSight(path, options, progress));
  const double low = field->bounds().min.z(), high = field->bounds().max.z();
  const bool outside = std::ranges::any_of(heights, [&](double z) { return z < low || z > high; });
  // A scene says itself which source it shows; members are for a file alone.
  if (!outside || isScenePath(path) || options.members->contains("field"))
    return field;
  const std::string taller = field->tallerSource();
  if (taller.empty())
    return field;
  SceneOptions other = options;
  (*other.members)["field"] = taller;
  remarks.push_back(
      {RemarkCode::kFallback,
       fmt::format(
           "{} reaches from z = {:g} to {:g} m only, and eyes or signs are outside; {} is read "
           "instead",
           field->description(), low, high, taller),
       {Hint::choose("field")}});
  return openSight(path, other, progress);
}

}  // namespace volute
