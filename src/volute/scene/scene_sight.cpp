// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_sight.hpp"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "volute/media/occluded_sight.hpp"
#include "volute/media/ray_sight.hpp"
#include "volute/scene/kinds.hpp"

namespace volute {
namespace {

/// About volumes of which a scene says neither what they take away of light nor what else they are.
std::vector<Remark> hidingNothing(const Scene& scene) {
  std::vector<Remark> remarks;
  const auto& media = scene.json()["media"];
  for (std::size_t i = 0; i < media.size(); ++i) {
    const auto& entry = media[i];
    if (entry.value("kind", "") != "volume" ||
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

  std::vector<Remark> remarks() const override { return hidingNothing(scene_); }

 protected:
  Box3 ownBounds() const override { return bounds_; }

  Result<std::shared_ptr<const SightSnapshot>> readOwn(std::size_t time) override {
    Progress quiet;
    VOLUTE_ASSIGN(const auto snapshot, scene_.at({.time = times_[time], .lit = false}, quiet));
    std::vector<AnyMedium> all;
    for (const auto& medium : snapshot.media) medium->addMedia(all);
    auto media = sightThrough(std::move(all));
    if (snapshot.geometry.empty())
      return media;
    return std::make_shared<const OccludedSight>(std::move(media), snapshot.geometry);
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
  for (Remark& remark : hidingNothing(scene))
    scene.media()[0]->remarks.push_back(std::move(remark));
  Reading reading{progress, options.maxMemory, options.files.volumes.get()};
  VOLUTE_ASSIGN(auto only, scene.media()[0]->sight(reading));
  if (!scene.geometry().empty()) {
    only->wrap(
        [surfaces = scene.geometry()](std::shared_ptr<const SightSnapshot> media) {
          return std::make_shared<const OccludedSight>(std::move(media), surfaces);
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
                         fmt::format("{} does not reach all of z = {:g} m: nothing is known of the "
                                     "rest, and no verdict is of it",
                                     field->description(), *beyond)});
    }
    return field;
  }
  SceneOptions other = options;
  (*other.members)["field"] = taller;
  remarks.push_back(
      {RemarkCode::kFallback,
       fmt::format(
           "at z = {:g} m, where eyes or signs are, extinction is read from {} alone, because {} "
           "leaves out places at that height; name a source to use it all the same: those "
           "places are then not known",
           *beyond, taller, field->description()),
       {Hint::choose("field")}});
  return openSight(path, other, progress);
}

}  // namespace volute
