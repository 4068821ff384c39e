// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What a scene's document has read of its media, and what of it serves when words about them
// change.
#include <algorithm>

#include "volute/base/remark_log.hpp"
#include "volute/fds/smv_index.hpp"
#include "volute/viewer/scene_document.hpp"

namespace volute {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

/// What was read of the files serves as long as the same is read from them.
Result<SmokeLayer> SceneDocument::openSmoke(const SmokeDescription& smoke, const Medium* before,
                                            const SceneLights& lights, Reading& reading) const {
  auto lighting = std::make_shared<SmokeLighting>();
  lighting->lights = lights;
  if (!lights.lamps.empty())
    lighting->cache = options_.lightCache;
  lighting->blocks = blocksOf(geometry_);
  lighting->blocksKey = keyOf(geometry_);
  lighting->memory = light_;
  if (before && before->smoke && SmokeLayer::readsTheSame(before->smoke->description(), smoke))
    return before->smoke->with(smoke, lighting, reading);
  return SmokeLayer::open(smoke, lighting, reading);
}

/// The volumes that were read, whether as media or as billboards: they serve any other words about
/// the same file. What is not taken goes.
class SceneDocument::Volumes {
 public:
  Volumes(std::vector<Medium>& media, std::vector<Board>& boards) {
    for (std::size_t i = 0; i < media.size(); ++i) {
      if (media[i].volume)
        held_.push_back({&*media[i].volume, &media[i], nullptr, i});
    }
    for (std::size_t i = 0; i < boards.size(); ++i)
      held_.push_back({&boards[i].volume, nullptr, &boards[i], i});
  }

  struct Held {
    /// What is known of its file.
    template <class To>
    void tell(To& to) const {
      const auto take = [&](const auto& from) {
        to.checked = from.checked, to.damaged = from.damaged, to.remarks = from.remarks;
      };
      medium ? take(*medium) : take(*board);
    }

    VolumeLayer* layer = nullptr;
    Medium* medium = nullptr;  ///< null: it is a billboard's
    Board* board = nullptr;    ///< null: it is a medium's
    std::size_t place = 0;     ///< among the media or the billboards
    bool taken = false;
  };

  /// One of this file that was not taken yet, if there is one: rather that in the same place.
  Held* take(const std::string& file, bool medium, std::size_t place) {
    Held* found = nullptr;
    for (Held& held : held_) {
      if (held.taken || held.layer->path() != file)
        continue;
      if (!found || ((held.medium != nullptr) == medium && held.place == place))
        found = &held;
    }
    if (found)
      found->taken = true;
    return found;
  }

 private:
  std::vector<Held> held_;
};

Result<VolumeLayer> SceneDocument::openVolumeFile(const std::string& file,
                                                  Progress& progress) const {
  Reading reading{progress, options_.maxMemory};
  return VolumeLayer::open(file, {.grid = {}, .bounds = {}, .partial = true, .verify = false}, {},
                           reading);
}

/// Anything but a volume.
/// @param before  what was read of the medium in its place; may be null
Status SceneDocument::openMedium(Medium& medium, const Medium* before,
                                 const SceneDescription& scene, std::size_t place,
                                 Progress& progress) const {
  RemarkLog heard(progress);
  Reading reading{heard, options_.maxMemory};
  const std::string kind = medium.json.value("kind", "");
  if (kind == "fog") {
    medium.fogWords = scene.fogs[place];
    medium.fogWords.scattering.shadows = fogShadows(geometry_, scene.lights.suns);
    if (before && before->fog && FogLayer::readsTheSame(before->fogWords, medium.fogWords)) {
      medium.fog = before->fog->with(medium.fogWords, scene.lights.suns);
      medium.remarks = before->remarks;
      return {};
    }
    VOLUTE_ASSIGN(medium.fog, FogLayer::open(medium.fogWords, scene.lights.suns, reading));
  } else if (isSmvPath(scene.smokes[place].file)) {
    const SmokeDescription& smoke = scene.smokes[place];
    if (before && before->fds && FdsLayer::readsTheSame(before->fds->description(), smoke)) {
      medium.fds = before->fds->with(smoke, scene.lights);
      medium.remarks = before->remarks;
      return {};
    }
    VOLUTE_ASSIGN(medium.fds, FdsLayer::open(smoke, scene.lights, blocksOf(geometry_), reading));
  } else {
    VOLUTE_ASSIGN(medium.smoke, openSmoke(scene.smokes[place], before, scene.lights, reading));
  }
  medium.remarks = heard.remarks();
  return {};
}

/// Whether what was read of a medium serves these words about it. Of volumes see Volumes.
bool SceneDocument::serves(const Medium& old, const Json& wanted, bool lightsChanged) {
  return !old.volume && !lightsChanged && old.json == wanted;
}

void SceneDocument::keepPainted(const Medium& old, Medium& medium) {
  const FogLevels& levels = medium.fog->fogAt(0).levels();
  if (old.painted->size() != static_cast<std::size_t>(levels.columns()) * levels.rows())
    return;
  medium.painted = old.painted, medium.paintedMost = old.paintedMost;
  medium.unsaved = old.unsaved;
}

/// What was painted are shares of the map's largest value.
FogLayer SceneDocument::shownFog(const Medium& medium) {
  if (!medium.painted)
    return *medium.fog;
  std::vector<double> map = *medium.painted;
  for (double& value : map) value *= medium.fogWords.placement.sigmaMax / medium.paintedMost;
  return medium.fog->withMap(map);
}

/// First what has to be read, so that an error leaves everything as it was.
Result<std::vector<SceneDocument::Medium>> SceneDocument::mediaOf(const Json& json,
                                                                  const SceneDescription& scene,
                                                                  bool lightsChanged,
                                                                  Volumes& volumes,
                                                                  Progress& progress) {
  std::vector<Medium> media;
  std::vector<std::size_t> places;
  std::size_t counts[3] = {};
  for (const Json& entry : json.value("media", Json::array())) {
    const std::string kind = entry.value("kind", "");
    places.push_back(counts[kind == "volume" ? 0 : kind == "fog" ? 1 : 2]++);
    media.push_back({entry});
  }
  const bool same = media.size() == media_.size();
  std::vector<Medium*> kept(media.size(), nullptr);  // what was read of it
  std::vector<Volumes::Held*> held(media.size(), nullptr);
  const auto find = [&](std::size_t i) -> Medium* {
    if (same)
      return serves(media_[i], media[i].json, lightsChanged) ? &media_[i] : nullptr;
    for (Medium& old : media_) {  // one came or went
      if (serves(old, media[i].json, lightsChanged) && std::ranges::find(kept, &old) == kept.end())
        return &old;
    }
    return nullptr;
  };
  for (std::size_t i = 0; i < media.size(); ++i) {
    Medium& medium = media[i];
    if (medium.json.value("kind", "") == "volume") {
      const std::string& file = scene.volumes[places[i]].file;
      held[i] = volumes.take(file, true, i);
      if (!held[i]) {
        RemarkLog heard(progress);
        VOLUTE_ASSIGN(medium.volume, openVolumeFile(file, heard));
        medium.remarks = heard.remarks();
      }
      continue;
    }
    kept[i] = find(i);
    if (kept[i])
      continue;
    VOLUTE_TRY(openMedium(medium, same ? &media_[i] : nullptr, scene, places[i], progress));
    if (same && media_[i].fog && medium.fog && media_[i].painted)
      keepPainted(media_[i], medium);
  }
  for (std::size_t i = 0; i < media.size(); ++i) {
    Medium* const old = held[i] ? held[i]->medium : kept[i];
    Json words = std::move(media[i].json);
    if (old)
      media[i] = std::move(*old);
    else if (held[i])
      held[i]->tell(media[i]), media[i].volume = std::move(*held[i]->layer);
    media[i].json = std::move(words);
    if (media[i].volume)
      media[i].volume->setAppearance(scene.volumes[places[i]].appearance);
  }
  return media;
}

Status SceneDocument::load(Json json, Progress& progress) {
  const bool first = json_.is_null();
  const nlohmann::json plain = json;
  VOLUTE_ASSIGN(auto scene, parseScene(plain, file_));
  RemarkLog heard(progress);
  Reading reading{heard, options_.maxMemory};
  const bool lightsChanged =
      !first && json.value("lights", Json()) != json_.value("lights", Json());
  if (first) {
    VOLUTE_ASSIGN(geometry_, loadGeometry(scene.geometry, reading));
  }
  Volumes volumes(media_, boards_);
  std::vector<Volumes::Held*> held;
  std::vector<std::optional<Board>> opened(scene.billboards.size());
  for (std::size_t i = 0; i < scene.billboards.size(); ++i) {
    const std::string& file = scene.billboards[i].file;
    held.push_back(volumes.take(file, false, i));
    if (!held.back()) {
      RemarkLog said(progress);
      VOLUTE_ASSIGN(auto layer, openVolumeFile(file, said));
      opened[i] = Board{std::move(layer), {}, false, false, said.remarks()};
    }
  }
  VOLUTE_ASSIGN(auto media, mediaOf(json, scene, lightsChanged, volumes, progress));
  std::vector<Board> boards;
  for (std::size_t i = 0; i < scene.billboards.size(); ++i) {
    if (held[i]) {
      Board board{std::move(*held[i]->layer), {}};
      held[i]->tell(board);
      opened[i] = std::move(board);
    }
    opened[i]->volume.setAppearance(scene.billboards[i].appearance);
    opened[i]->options = scene.billboards[i].options;
    boards.push_back(std::move(*opened[i]));
  }
  boards_ = std::move(boards);
  media_ = std::move(media);
  json_ = std::move(json);
  scene_ = std::move(scene);
  if (lightsChanged)
    surfaces_.reset();
  if (first)
    sceneRemarks_ = heard.remarks();
  gatherRemarks();
  findExtent();
  findTimes();
  const CameraDescription& camera = scene_.camera;
  start_ = StartView{camera.view.eye, camera.view.target, camera.view.up, camera.fov.value_or(40),
                     camera.ortho.value_or(0)};
  return {};
}

}  // namespace volute
