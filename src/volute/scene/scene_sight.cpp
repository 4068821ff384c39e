// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_sight.hpp"

#include <algorithm>

#include "volute/media/ray_sight.hpp"

namespace volute {
namespace {

/// Another instant, with surfaces in the way.
class BehindSurfaces final : public SightInstant {
 public:
  BehindSurfaces(std::shared_ptr<const SightInstant> media, TriangleScene surfaces)
      : media_(std::move(media)), surfaces_(std::move(surfaces)) {}

  void look(std::span<const SightLine> lines, std::span<Sight> sights) const override {
    media_->look(lines, sights);
    std::vector<Segment> segments;
    for (const SightLine& line : lines) {
      const double length = line.length();
      const Vec3 way = line.target - line.eye;
      segments.push_back({line.eye, length > 0 ? Vec3(way / length) : Vec3::UnitX(), 0,
                          length * (1 - kShort)});
    }
    std::vector<std::uint8_t> blocked(lines.size(), 0);
    surfaces_.occluded(segments, blocked);
    for (std::size_t i = 0; i < sights.size(); ++i) sights[i].blocked |= blocked[i] != 0;
  }

  void places(std::span<const Vec3> points, std::span<Place> places) const override {
    media_->places(points, places);
  }

  void extinction(std::span<const Vec3> points, std::span<double> extinction) const override {
    media_->extinction(points, extinction);
  }

 private:
  static constexpr double kShort = 1e-9;  ///< a target on a surface is seen

  std::shared_ptr<const SightInstant> media_;
  TriangleScene surfaces_;
};

class SceneSight final : public SightField {
 public:
  /// @param only  of the scene's only medium; null: rays through all of them
  SceneSight(Scene scene, std::unique_ptr<SightField> only)
      : scene_(std::move(scene)), only_(std::move(only)), bounds_(scene_.bounds()) {
    scene_.setLaw({});
    for (const auto& medium : scene_.media())
      times_.insert(times_.end(), medium->info().times.begin(), medium->info().times.end());
    std::ranges::sort(times_);
    times_.erase(std::ranges::unique(times_).begin(), times_.end());
    if (times_.empty())
      times_ = {0};
  }

  std::string description() const override {
    if (only_)
      return only_->description();
    return fmt::format("{}: {} media, along rays", scene_.path(), scene_.media().size());
  }

  std::vector<std::string> remarks() const override {
    return only_ ? only_->remarks() : std::vector<std::string>();
  }

  std::span<const double> times() const override { return only_ ? only_->times() : times_; }

  int numberOf(std::size_t time) const override {
    return only_ ? only_->numberOf(time) : static_cast<int>(time);
  }

  Box3 bounds() const override { return bounds_; }

  Result<std::shared_ptr<const SightInstant>> read(std::size_t time) override {
    Progress quiet;
    std::shared_ptr<const SightInstant> media;
    TriangleScene surfaces = scene_.geometry();
    if (only_) {
      VOLUTE_ASSIGN(media, only_->read(time));
    } else {
      VOLUTE_ASSIGN(const auto snapshot, scene_.at({.time = times_[time]}, quiet));
      std::vector<AnyMedium> all;
      for (const auto& medium : snapshot.media) medium->addMedia(all);
      media = sightThrough(std::move(all));
      surfaces = snapshot.geometry;
    }
    if (surfaces.empty())
      return media;
    return std::make_shared<const BehindSurfaces>(std::move(media), std::move(surfaces));
  }

 private:
  Scene scene_;
  std::unique_ptr<SightField> only_;
  Box3 bounds_;
  std::vector<double> times_;
};

}  // namespace

Result<std::unique_ptr<SightField>> sightOf(Scene scene, const SceneOptions& options,
                                            Progress& progress) {
  std::unique_ptr<SightField> only;
  if (scene.media().size() == 1) {
    const MediumEntry& entry = scene.description().media.front();
    Reading reading{progress, options.maxMemory};
    MediumContext context{reading,           options.files, scene.description().lights,
                          scene.geometry(),  scene.path(),  entry.path,
                          scene.media()[0],  nullptr};
    VOLUTE_ASSIGN(only, entry.kind->openSight(entry.json, context));
  }
  return std::make_unique<SceneSight>(std::move(scene), std::move(only));
}

}  // namespace volute
