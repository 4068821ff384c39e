// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "volute/base/read_text.hpp"
#include "volute/base/remark_log.hpp"
#include "volute/io/json_file.hpp"
#include "volute/lighting/fewer_lamps.hpp"
#include "volute/media/light_blockers.hpp"
#include "volute/render/scaled_medium.hpp"
#include "volute/scene/kinds.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr double kRate = 25;      ///< frames a second of what has no times of its own
constexpr double kBlown = 10;     ///< [s] for which what moves is shown at least
constexpr double kHighest = 1e6;  ///< [m] that counts as an end

/// What is infinite ends a little above the ground.
Box3 finite(Box3 box) {
  const double width = box.size().head<2>().maxCoeff();
  if (!(box.max.z() < kHighest))
    box.max.z() = std::max(box.min.z() > -kHighest ? box.min.z() : 0.0, 0.0) + 0.25 * width;
  if (!(box.min.z() > -kHighest))
    box.min.z() = box.max.z() - 0.25 * width;
  return box;
}

/// Merges lamps where there are more than each has a light of its own. What they were; empty: they
/// are as they were.
std::vector<Lamp> joinLamps(std::vector<Lamp>& lamps) {
  constexpr std::size_t kMaxLamps = 64;
  if (lamps.size() <= kMaxLamps)
    return {};
  const auto suns =
      static_cast<std::size_t>(std::ranges::count(lamps, Lamp::Kind::kSun, &Lamp::kind));
  return std::exchange(lamps, fewerLamps(lamps, std::max(kMaxLamps, suns + 1) - suns));
}

Remark joined(std::span<const Lamp> all, std::span<const Lamp> few, const Box3& box,
              const std::string& path) {
  return {RemarkCode::kChanged,
          fmt::format("{}: /lights: {} lamps are drawn as {}, each for some that are near each "
                      "other; without shadows their light differs by {:.2g} % in the mean",
                      path, all.size(), few.size(), 100 * lampsDiffer(few, all, box))};
}

/// What media that take no ambient light have no other light for. What else may glow lights them.
void tellOfIdleLight(const SceneDescription& scene, const TriangleScene& geometry,
                     const std::string& file, Progress& progress) {
  const auto takes = [](const MediumEntry& entry) { return entry.kind->takesAmbient(); };
  if (scene.media.empty() || !geometry.empty() || std::ranges::any_of(scene.media, takes))
    return;
  const auto tell = [&](const std::string& place, std::string_view why) {
    progress.remark(
        Remark{RemarkCode::kLeftOut, fmt::format("{}: {} has no effect: {}", file, place, why)}.in(
            file, place));
  };
  if (scene.lights.ambient.maxCoeff() > 0)
    tell("/lights", fmt::format("{} takes no ambient light; its color is the light it adds",
                                scene.media.front().kind->name()));
  if (!scene.lights.lamps.empty())
    return;
  if (scene.lights.multiple)
    tell("/scattering", "there is no light to scatter");
  for (const MediumEntry& entry : scene.media) {
    for (const char* member : {"albedo", "asymmetry"}) {
      if (entry.json->contains(member))
        tell(entry.path + '/' + member, "there is neither a sun nor a spot");
    }
  }
}

/// An entry of a scene file, in which settings of its kind are members.
struct SceneEntry {
  const std::string& file;
  const MediumEntry& entry;

  bool has(const std::string& setting) const {
    return isScenePath(file) && entry.kind->fields().find(setting);
  }

  Hints here(Hints hints) const {
    for (Hint& hint : hints) {
      if (has(hint.setting))
        hint.setting = entry.path + '/' + hint.setting;
    }
    return hints;
  }

  Error here(Error error) const {
    error.hints = here(std::move(error.hints));
    if (error.path.empty() && has(error.member)) {
      const std::string member = entry.path + '/' + error.member;
      return inFile(std::move(error), file, member);
    }
    return error;
  }
};

/// Advises on members of the entry where its medium advises on settings.
class EntryProgress final : public Progress {
 public:
  EntryProgress(Progress& outer, SceneEntry entry) : outer_(outer), entry_(entry) {}

  void report(std::string_view stage, double done, double total) override {
    outer_.report(stage, done, total);
  }

  void detail(std::string_view text) override { outer_.detail(text); }

  void remark(const Remark& remark) override {
    Remark here = remark;
    here.hints = entry_.here(std::move(here.hints));
    outer_.remark(here);
  }

  bool cancelled() const override { return outer_.cancelled(); }

 private:
  Progress& outer_;
  SceneEntry entry_;
};

/// As it is written, with its members in their order.
Result<OrderedJson> readScene(const std::string& path) {
  // Whatever is wrong with it is said there. A member of an ordered object is found by looking
  // through the others, and no object of ours has more than some tens.
  constexpr std::size_t kMaxMembers = 2000;
  VOLUTE_TRY(readJson(path, {.members = kMaxMembers}));
  VOLUTE_ASSIGN(const auto text, readText(path));
  return OrderedJson::parse(text, nullptr, false);
}

}  // namespace

bool isScenePath(const std::string& path) {
  return extensionOf(path) == ".json";
}

bool SceneSnapshot::hasWalls() const {
  return std::ranges::any_of(media, [](const auto& medium) { return medium->hasWalls(); });
}

std::optional<SceneSnapshot> SceneSnapshot::quick() const {
  SceneSnapshot other = *this;
  bool sooner = !geometry.empty() && !lights.lamps.empty();
  for (auto& medium : other.media) {
    if (auto quick = medium->quick()) {
      medium = std::move(quick);
      sooner = true;
    }
  }
  if (!sooner)
    return std::nullopt;
  other.shadows = false;
  return other;
}

Result<Scene> Scene::open(const std::string& path, const SceneOptions& options,
                          Progress& progress) {
  registerUsualMedia();
  if (isScenePath(path)) {
    VOLUTE_ASSIGN(auto json, readScene(path));
    return make(std::move(json), path, options, progress);
  }
  const MediumKind* kind = mediumKindOf(path, options.assume);
  OrderedJson json = kind->sceneOf(std::filesystem::path(path).filename().string());
  OrderedJson& entry = json["media"][0];
  if (const auto said = options.members->find("kind");
      said != options.members->end() && *said != entry["kind"]) {
    return failIn(path, "/media/0/kind", ErrorCode::kInvalidArgument,
                  "is {}, and this is {}, of kind \"{}\"; leave it out", said->dump(),
                  kind->singular(), kind->name());
  }
  entry.update(*options.members);
  const std::string assumption = options.assume ? kind->assume(json) : "";
  auto scene = make(json, path, options, progress);
  if (!scene && scene.error().code != ErrorCode::kCancelled && options.assume) {
    for (OrderedJson& other : kind->alternatives(json["media"][0])) {
      json["media"][0] = std::move(other);
      auto found = make(json, path, options, progress);
      if (found) {
        scene = std::move(found);
        break;
      }
    }
  }
  VOLUTE_TRY(scene);
  scene->isFile_ = false;
  scene->assumption_ = assumption;
  return scene;
}

Result<Scene> Scene::make(OrderedJson json, const std::string& file, const SceneOptions& options,
                          Progress& progress) {
  registerUsualMedia();
  Scene scene;
  scene.path_ = file;
  scene.options_ = options;
  const nlohmann::json plain = json;
  VOLUTE_ASSIGN(scene.description_, parseScene(plain, file));
  scene.chooseScattering(scene.description_, progress);
  const std::vector<Lamp> all = joinLamps(scene.description_.lights.lamps);
  Reading reading{progress, options.maxMemory, options.files.volumes.get()};
  VOLUTE_ASSIGN(scene.geometry_, loadGeometry(scene.description_.geometry, reading));
  scene.surfaces_ = scene.geometry_;
  VOLUTE_ASSIGN(scene.media_, scene.openMedia(scene.description_, false, progress));
  VOLUTE_TRY(scene.checkLaws());
  tellOfIdleLight(scene.description_, scene.geometry_, file, progress);
  if (!all.empty())
    progress.remark(joined(all, scene.description_.lights.lamps, scene.bounds(), file));
  scene.json_ = std::move(json);
  return scene;
}

namespace {

/// Media that are one surface for ever, such as a level set.
std::vector<const SceneMedium*> stillSurfaces(std::span<const std::shared_ptr<SceneMedium>> media) {
  std::vector<const SceneMedium*> still;
  for (const auto& medium : media) {
    const MediumInfo& info = medium->info();
    if (medium->surfacesKey({}) != 0 && info.times.size() == 1 && !info.moves)
      still.push_back(medium.get());
  }
  return still;
}

}  // namespace

/// Media of which nothing is said anew stay; what was read serves the others. An error leaves
/// everything as it was.
Result<std::vector<std::shared_ptr<SceneMedium>>> Scene::openMedia(
    const SceneDescription& description, bool sameLights, Progress& progress) {
  const auto entries = std::span(description.media);
  const bool same = entries.size() == media_.size() && description.version == description_.version;
  std::vector<std::shared_ptr<SceneMedium>> earlier = media_, media(entries.size());
  const auto open = [&](std::size_t i, const TriangleScene& geometry,
                        std::shared_ptr<SceneMedium> before) -> Status {
    const MediumEntry& entry = entries[i];
    const SceneEntry here{path_, entry};
    EntryProgress entryProgress(progress, here);
    Reading reading{entryProgress, options_.maxMemory, options_.files.volumes.get()};
    nlohmann::json json = *entry.json;
    for (const auto& [name, value] : options_.overrides->items()) {
      if (entry.kind->fields().find(name))
        json[name] = value;
    }
    MediumContext context{reading,    options_.files,      description.lights, geometry, path_,
                          entry.path, description.version, std::move(before),  &earlier};
    auto opened = entry.kind->open(json, context).map_error([&](const Error& error) {
      return here.here(error);
    });
    VOLUTE_ASSIGN(media[i], ofFile(std::move(opened), path_, entry.path));
    return {};
  };
  for (std::size_t i = 0; same && sameLights && i < entries.size(); ++i) {
    const MediumEntry& before = description_.media[i];
    if (before.kind != entries[i].kind || *before.json != *entries[i].json)
      continue;
    media[i] = media_[i];
    std::erase(earlier, media[i]);
  }
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (media[i])
      kept.push_back(i);
    else
      VOLUTE_TRY(open(i, geometry_, same ? media_[i] : nullptr));
  }
  // Surfaces among the media shadow the others as the scene's own do.
  const auto surfaces = stillSurfaces(media);
  const bool sameSurfaces = surfaces == stillSurfaces(media_);
  if (surfaces.empty() && sameSurfaces)
    return media;
  TriangleMesh mesh = geometry_.mesh();
  for (const SceneMedium* surface : surfaces) VOLUTE_TRY(surface->addSurfaces({}, mesh));
  VOLUTE_ASSIGN(const auto all, TriangleScene::of(std::move(mesh)));
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const bool stays = sameSurfaces && std::ranges::find(kept, i) != kept.end();
    if (stays || std::ranges::find(surfaces, media[i].get()) != surfaces.end())
      continue;
    earlier.push_back(media[i]);
    VOLUTE_TRY(open(i, all, earlier.back()));
  }
  return media;
}

void Scene::chooseScattering(SceneDescription& description, Progress& progress) const {
  bool& multiple = description.lights.multiple;
  multiple = options_.multiple.value_or(multiple);
  if (!multiple || !options_.files.measured)
    return;
  multiple = false;
  progress.remark(
      {RemarkCode::kDoubtful,
       fmt::format("{}: /scattering: light scattered more than once is approximate, and "
                   "is left out of what is measured",
                   path_)});
}

/// One picture has one mode.
Status Scene::checkLaws() const {
  const MediumInfo* first = nullptr;
  std::string where;
  for (std::size_t i = 0; i < media_.size(); ++i) {
    const MediumInfo& info = media_[i]->info();
    if (!info.law)
      continue;
    const std::string here = fmt::format("{}: {}", path_, description_.media[i].path);
    if (first && !(*first->law == *info.law)) {
      return fail(ErrorCode::kInvalidData,
                  "{}/mode: {} with C = {:g}, but {} is {} with C = {:g}; one picture has one mode",
                  here, nameOf(info.law->mode), info.law->c, where, nameOf(first->law->mode),
                  first->law->c);
    }
    first = &info;
    where = here;
  }
  return {};
}

Status Scene::change(OrderedJson json, Progress& progress) {
  const nlohmann::json plain = json;
  VOLUTE_ASSIGN(auto description, parseScene(plain, path_));
  chooseScattering(description, progress);
  joinLamps(description.lights.lamps);
  const bool sameLights =
      json.value("lights", OrderedJson()) == json_->value("lights", OrderedJson()) &&
      description.lights.multiple == description_.lights.multiple;
  VOLUTE_ASSIGN(auto media, openMedia(description, sameLights, progress));
  std::swap(media_, media);
  std::swap(description_, description);
  if (auto laws = checkLaws(); !laws) {
    std::swap(media_, media);
    std::swap(description_, description);
    return laws;
  }
  json_ = std::move(json);
  surfacesOf_.clear();
  surfaces_ = geometry_;
  setViews(std::move(views_));
  return {};
}

void Scene::setViews(std::vector<Camera> views) {
  views_ = std::move(views);
  for (const auto& medium : media_) {
    if (!views_.empty())
      medium->chooseLook(views_);
  }
}

Status Scene::reconsider(Progress& progress) {
  if (isFile_ || assumption_.empty() || media_.empty())
    return {};
  OrderedJson json = *json_;
  const MediumKind* kind = mediumKindOf(path_, options_.assume);
  std::string guessed = kind->guess(json["media"][0], *media_.front());
  if (guessed.empty())
    return {};
  VOLUTE_TRY(change(std::move(json), progress));
  assumption_ = std::move(guessed);
  return {};
}

void Scene::note(OrderedJson json) {
  json_ = std::move(json);
  const nlohmann::json meant = upgradedScene(*json_);
  for (MediumEntry& entry : description_.media)
    entry.json = meant.at(nlohmann::json::json_pointer(entry.path));
}

Box3 Scene::boundsOf(Box3 (*ofMedium)(const MediumInfo&)) const {
  Box3 bounds;
  for (const auto& medium : media_) bounds.extend(finite(ofMedium(medium->info())));
  if (!geometry_.empty())
    bounds.extend(geometry_.bounds());
  if (!bounds.empty())
    return bounds;
  const Vec3 target = description_.camera ? description_.camera->view.target : Vec3(Vec3::Zero());
  return {target - Vec3::Ones(), target + Vec3::Ones()};
}

Box3 Scene::bounds() const {
  return boundsOf([](const MediumInfo& medium) { return medium.bounds; });
}

Box3 Scene::framed() const {
  return boundsOf([](const MediumInfo& medium) { return medium.framed.value_or(medium.bounds); });
}

std::vector<double> Scene::times() const {
  const bool moves =
      std::ranges::any_of(media_, [](const auto& medium) { return medium->info().moves; });
  if (media_.size() == 1 && (media_[0]->info().times.size() > 1 || !moves))
    return media_[0]->info().times;
  double last = moves ? kBlown : 0;
  for (const auto& medium : media_) last = std::max(last, medium->info().times.back());
  std::vector<double> times{0.0};
  const double frames = std::min(std::round(last * kRate), 1e6);
  for (int frame = 1; frame <= static_cast<int>(frames); ++frame) times.push_back(frame / kRate);
  return times;
}

PictureLaw Scene::law() const {
  if (law_)
    return *law_;
  for (const auto& medium : media_) {
    if (medium->info().law)
      return *medium->info().law;
  }
  return {};
}

std::optional<CameraDescription> Scene::camera() const {
  if (description_.camera || media_.size() != 1)
    return description_.camera;
  return media_[0]->firstCamera();
}

/// `surfaces_` becomes the scene's and all that is opaque in its media at a time.
Status Scene::placeSurfaces(const SnapshotRequest& request) {
  std::vector<std::uint64_t> wanted;
  for (const auto& medium : media_) wanted.push_back(medium->surfacesKey(request));
  if (std::ranges::all_of(wanted, [](std::uint64_t key) { return key == 0; }) ||
      wanted == surfacesOf_)
    return {};
  TriangleMesh all = geometry_.mesh();
  for (const auto& medium : media_) VOLUTE_TRY(medium->addSurfaces(request, all));
  VOLUTE_ASSIGN(surfaces_, TriangleScene::of(std::move(all)));
  surfacesOf_ = std::move(wanted);
  return {};
}

Result<SceneSnapshot> Scene::at(const SnapshotRequest& request, Progress& progress) {
  SceneSnapshot snapshot;
  snapshot.time = request.time;
  snapshot.law = law();
  SnapshotRequest seen = request;
  seen.factor = snapshot.law.factor();
  for (std::size_t i = 0; i < media_.size(); ++i) {
    const SceneEntry here{path_, description_.media[i]};
    VOLUTE_ASSIGN(auto now, media_[i]->at(seen, progress).map_error([&](const Error& error) {
      return here.here(error);
    }));
    snapshot.media.push_back(std::move(now));
  }
  VOLUTE_TRY(placeSurfaces(request));
  snapshot.geometry = surfaces_;
  snapshot.fixedGeometry = geometry_;
  snapshot.lights = description_.lights;
  snapshot.signs = description_.signs;
  snapshot.background = description_.background;
  if (!request.coarse && request.lit)
    shine(snapshot, progress);
  if (description_.clip.empty())
    return snapshot;
  const auto clip = std::make_shared<const SceneClip>(description_.clip);
  for (std::size_t i = 0; i < media_.size(); ++i) {
    if (media_[i]->info().shared) {
      return fail(ErrorCode::kUnsupported,
                  "{}: /clip: processes that share a mesh draw it whole; leave clip out, or use "
                  "one process",
                  path_);
    }
    snapshot.media[i] = clipped(std::move(snapshot.media[i]), clip);
  }
  return snapshot;
}

void Scene::shine(SceneSnapshot& snapshot, Progress& progress) {
  if (media_.size() < 2 && snapshot.geometry.empty())
    return;  // there is nothing else to be lit, or in the way
  std::vector<std::vector<Lamp>> lamps;
  std::size_t count = 0;
  for (const auto& medium : snapshot.media) {
    lamps.push_back(medium->lightSources());
    // What glows is a spot; a sun is a light of the picture.
    count +=
        static_cast<std::size_t>(std::ranges::count(lamps.back(), Lamp::Kind::kSpot, &Lamp::kind));
  }
  const std::vector<std::shared_ptr<const MediumSnapshot>> plain = snapshot.media;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    std::vector<Lamp> others;
    for (std::size_t k = 0; k < plain.size(); ++k) {
      if (k != i)
        others.insert(others.end(), lamps[k].begin(), lamps[k].end());
    }
    std::vector<AnyMedium> between;
    for (std::size_t k = 0; k < plain.size(); ++k) {
      // Of what ranks share each knows its own part: they would not agree.
      if (k != i && !media_[k]->info().shared)
        plain[k]->addExtinction(between);
    }
    if (others.empty() && between.empty())
      continue;
    for (AnyMedium& medium : between) medium = scaledBy(1 / snapshot.law.factor(), medium);
    if (auto lit = plain[i]->litBy({others, between}))
      snapshot.media[i] = std::move(lit);
  }
  for (const auto& some : lamps)
    snapshot.lights.lamps.insert(snapshot.lights.lamps.end(), some.begin(), some.end());
  if (count == 0 || toldOfGlow_)
    return;
  toldOfGlow_ = true;
  Rgb power = Rgb::Zero();
  for (const auto& some : lamps) {
    for (const Lamp& lamp : some) power += lamp.intensity;
  }
  progress.remark(fmt::format(
      "what glows lights the rest of the scene, as {} lamp{} of {:.3g}, {:.3g}, {:.3g} per solid "
      "angle in all; \"lights_scene\": \"never\" of a volume leaves that out",
      count, count == 1 ? "" : "s", power[0], power[1], power[2]));
}

std::vector<std::string> Scene::files() const {
  std::vector<std::string> files{path_};
  for (const auto& medium : media_) {
    for (std::string& file : medium->files()) files.push_back(std::move(file));
  }
  for (const SceneGeometry& geometry : description_.geometry) files.push_back(geometry.file);
  const auto signs = json_->find("signs");
  if (signs == json_->end() || !signs->is_array())
    return files;
  for (const auto& sign : *signs) {
    if (const std::string picture = sign.value("picture", ""); !picture.empty())
      files.push_back((std::filesystem::path(path_).parent_path() / picture).string());
  }
  return files;
}

Vec3 seenFrom(const Camera& camera) {
  constexpr double kBehind = 1e6;  // [m]
  return camera.isOrthographic() ? Vec3(camera.eye() - kBehind * camera.forward()) : camera.eye();
}

}  // namespace volute
