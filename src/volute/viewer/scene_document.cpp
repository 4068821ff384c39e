// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/scene_document.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "volute/base/output_file.hpp"
#include "volute/base/remark_log.hpp"
#include "volute/fds/smv_index.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/image_file.hpp"
#include "volute/scene/volume_input.hpp"
#include "volute/viewer/scene_parameters.hpp"
#include "volute/viewer/watched_files.hpp"

namespace volute {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kRate = 25;      ///< frames a second of what has no times of its own
constexpr double kBlown = 10;     ///< [s] for which wind is shown at least
constexpr double kHighest = 1e6;  ///< [m] that counts as an end

std::string absolute(const std::string& path) {
  std::error_code ignored;
  const auto found = std::filesystem::absolute(path, ignored);
  return ignored ? path : found.lexically_normal().string();
}

/// The member of a medium that names its file.
const char* fileKey(const Json& medium) {
  const std::string kind = medium.value("kind", "");
  return kind == "volume" ? "file" : kind == "fog" ? "map" : "case";
}

/// A file's name as a scene at `target` would say it.
std::string nameFrom(const std::string& scene, const std::string& target, const std::string& name) {
  const std::filesystem::path file =
      absolute((std::filesystem::path(scene).parent_path() / name).string());
  const auto folder = std::filesystem::path(absolute(target)).parent_path();
  const auto near = file.lexically_relative(folder);
  const bool below = !near.empty() && *near.begin() != "..";
  return below ? near.string() : file.string();
}

void moveNames(Json& names, const std::string& from, const std::string& to) {
  if (names.is_string()) {
    names = nameFrom(from, to, names.get<std::string>());
  } else if (names.is_array()) {
    for (Json& name : names) moveNames(name, from, to);
  }
}

/// Names in the JSON of a scene at `from`, as one at `to` says them.
void moveAllNames(Json& json, const std::string& from, const std::string& to) {
  const auto each = [&](const char* list, auto key) {
    if (!json.contains(list))
      return;
    for (Json& entry : json[list]) {
      const char* name = key(entry);
      if (entry.contains(name))
        moveNames(entry[name], from, to);
      if (entry.contains("top"))
        moveNames(entry["top"]["map"], from, to);
    }
  };
  each("media", fileKey);
  each("geometry", [](const Json&) { return "file"; });
  each("signs", [](const Json&) { return "picture"; });
  each("billboards", [](const Json&) { return "volume"; });
}

/// A remark without the name of the file that it is about, which the title has, or without that
/// file's folder before the name of one beside it.
std::string withoutPlace(std::string remark, const std::string& path) {
  const std::string own = path + ": ";
  if (remark.starts_with(own))
    return remark.substr(own.size());
  const std::string folder = (std::filesystem::path(path).parent_path() / "").string();
  return remark.starts_with(folder) ? remark.substr(folder.size()) : remark;
}

/// "3 frames", "1 frame".
std::string countOf(std::ptrdiff_t number, const char* one) {
  return fmt::format("{} {}{}", number, one, number == 1 ? "" : "s");
}

Json vectorOf(const Vec3& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

}  // namespace

Result<std::unique_ptr<Document>> SceneDocument::open(const std::string& path,
                                                      const DocumentOptions& options,
                                                      Progress& progress) {
  std::unique_ptr<SceneDocument> document(new SceneDocument(path, options));
  VOLUTE_TRY(document->readJsonOfScene(progress));
  return std::unique_ptr<Document>(std::move(document));
}

Status SceneDocument::readJsonOfScene(Progress& progress) {
  if (extensionOf(path_) != ".json") {
    file_ = path_ + ".json";
    Json json = sceneOfFile();
    const Json& medium = json["media"][0];
    const bool search = medium["kind"] == "smoke" && !isSmvPath(path_) && !medium.contains("field");
    VOLUTE_TRY(search ? loadMesh(std::move(json), progress) : load(std::move(json), progress));
    start_.reset();
    if (media_.front().fds)
      lookInside(*media_.front().fds);
    return {};
  }
  file_ = path_;
  VOLUTE_TRY(readScene(path_));  // whatever is wrong with it is said there
  std::ifstream stream(path_);
  return load(Json::parse(stream, nullptr, false), progress);
}

/// A closed building shows nothing from outside.
void SceneDocument::lookInside(const FdsLayer& fds) {
  if (const auto inside = fds.firstCamera())
    start_ = StartView{.eye = inside->view.eye,
                       .target = inside->view.target,
                       .up = inside->view.up,
                       .fov = *inside->fov,
                       .walks = true};
}

/// Of several fields the one with a usual name.
Status SceneDocument::loadMesh(Json json, Progress& progress) {
  const Status only = load(json, progress);
  if (only || only.error().code == ErrorCode::kCancelled)
    return only;
  for (const char* name : {"smoke", "soot", "SOOT DENSITY", "soot_density", "extinction"}) {
    json["media"][0]["field"] = name;
    if (load(json, progress))
      return {};
  }
  return only;
}

/// The scene that a single file stands for.
Json SceneDocument::sceneOfFile() {
  const Json& smoke = options_.smoke;
  Json scene = {{"format", "volute-scene-1"},
                {"camera", {{"eye", {0, -1, 0}}, {"target", {0, 0, 0}}, {"fov", 40}}}};
  const std::string name = std::filesystem::path(path_).filename().string();
  Json medium;
  if (isPicturePath(path_)) {
    medium = {{"kind", "fog"},
              {"map", name},
              {"convert", "luma"},
              {"cell", 1.0},
              {"sigma_max", 0.05},
              {"degree", 2},
              {"profile", {{"kind", "slab"}, {"bottom", 0.0}, {"top", 10.0}}}};
    guess_ = "cells of 1 m, 10 m high, 0.05 /m at most, unless you say otherwise";
    // Against a dim sky fog is seen from all sides.
    scene["background"] = {0.02, 0.03, 0.05};
  } else if (isSmvPath(path_) || isSmokeCase(path_)) {
    // Black or lit smoke before white: the picture is what passes of the light.
    scene["background"] = {1, 1, 1};
    medium = {{"kind", "smoke"}, {"case", name}};
    if (isSmvPath(path_)) {
      scene["lights"] = Json::array({{{"kind", "ambient"}, {"radiance", {1, 1, 1}}}});
    } else {
      medium["quantity"] = "soot-density";
      if (!smoke.contains("quantity"))
        medium["unit"] = "kg/m3";
      medium["negatives"] = "clamp";
      if (!smoke.contains("quantity") && !smoke.contains("unit"))
        guess_ = "the field is taken for soot in kg/m3, unless you say otherwise";
    }
    medium.update(smoke);
  } else {
    medium = {{"kind", "volume"}, {"file", name}};
  }
  scene["media"] = Json::array({std::move(medium)});
  return scene;
}

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

SceneFacts SceneDocument::facts() const {
  SceneFacts facts;
  const auto span = [](const auto& layer, int frames) {
    return frames > 1 ? std::abs(layer.timeOf(frames - 1) - layer.timeOf(0)) : 0.0;
  };
  const auto ofVolume = [&](const VolumeLayer& layer) {
    const VolumeInfo& info = layer.info();
    return MediumFacts{info.frames, span(layer, info.frames) * layer.appearance().clock.rate,
                       layer.fileBounds()};
  };
  for (const Medium& medium : media_) {
    MediumFacts& of = facts.media.emplace_back();
    if (medium.volume)
      of = ofVolume(*medium.volume);
    if (medium.fog)
      of = {medium.fog->frames(),
            span(*medium.fog, medium.fog->frames()) * medium.fogWords.clock.rate,
            medium.fog->fogAt(0).bounds()};
    if (medium.smoke)
      of = {medium.smoke->steps(),
            span(*medium.smoke, medium.smoke->steps()) * medium.smoke->description().clock.rate,
            medium.smoke->bounds(), medium.smoke->largestExtinction()};
    if (medium.fds)
      of = {medium.fds->steps(),
            span(*medium.fds, medium.fds->steps()) * medium.fds->description().clock.rate,
            medium.fds->bounds()};
  }
  for (const Board& board : boards_) facts.billboards.push_back(ofVolume(board.volume));
  return facts;
}

void SceneDocument::gatherRemarks() {
  remarks_ = sceneRemarks_;
  for (const Medium& medium : media_)
    remarks_.insert(remarks_.end(), medium.remarks.begin(), medium.remarks.end());
  for (const Board& board : boards_)
    remarks_.insert(remarks_.end(), board.remarks.begin(), board.remarks.end());
  if (!guess_.empty())
    remarks_.push_back(guess_);
  for (std::string& remark : remarks_) remark = withoutPlace(std::move(remark), path_);
}

bool SceneDocument::checked() const {
  const auto waits = [](const VolumeLayer& volume, bool seen) { return volume.reader() && !seen; };
  return std::ranges::none_of(media_,
                              [&](const Medium& medium) {
                                return medium.volume && waits(*medium.volume, medium.checked);
                              }) &&
         std::ranges::none_of(
             boards_, [&](const Board& board) { return waits(board.volume, board.checked); });
}

void SceneDocument::check(Progress& progress) {
  const auto look = [&](const VolumeLayer& volume, auto& of) {
    if (of.checked || !volume.reader())
      return true;
    const auto integrity = volume.reader()->verify(progress);
    if (!integrity)
      return false;  // stopped
    of.checked = true;
    of.damaged = !integrity->complete();
    if (of.damaged) {
      const std::string& fault = integrity->firstFault;
      of.remarks.push_back(fmt::format("{}; {} of {} parts are whole and shown",
                                       fault.substr(0, fault.find("; --partial")),
                                       integrity->intactSegments, integrity->segments));
    }
    return true;
  };
  for (Medium& medium : media_) {
    if (medium.volume && !look(*medium.volume, medium))
      return;
  }
  for (Board& board : boards_) {
    if (!look(board.volume, board))
      return;
  }
  gatherRemarks();
}

/// What is infinite ends a little above the ground.
void SceneDocument::include(const Box3& bounds) {
  Box3 finite = bounds;
  const double width = bounds.size().head<2>().maxCoeff();
  if (!(finite.max.z() < kHighest))
    finite.max.z() =
        std::max(finite.min.z() > -kHighest ? finite.min.z() : 0.0, 0.0) + 0.25 * width;
  if (!(finite.min.z() > -kHighest))
    finite.min.z() = finite.max.z() - 0.25 * width;
  bounds_.extend(finite.min);
  bounds_.extend(finite.max);
}

void SceneDocument::findExtent() {
  bounds_ = Box3();
  for (const Medium& medium : media_) {
    if (medium.volume)
      include(medium.volume->boundsInScene());
    if (medium.fog)
      include(medium.fog->fogAt(0).bounds());
    if (medium.smoke)
      include(medium.smoke->bounds());
    if (medium.fds)
      include(medium.fds->bounds());
  }
  for (const Board& board : boards_) {
    const Vec3 reach = Vec3::Constant(0.5 * std::hypot(board.options.width, board.options.height));
    include({board.options.position - reach, board.options.position + reach});
  }
  if (!geometry_.empty()) {
    bounds_.extend(geometry_.bounds().min);
    bounds_.extend(geometry_.bounds().max);
  }
  const Vec3& target = scene_.camera.view.target;
  if (bounds_.empty())
    bounds_ = {target - Vec3::Ones(), target + Vec3::Ones()};
}

/// A single medium has its own frames; a scene 25 a second, and so has fog that the wind blows.
void SceneDocument::findTimes() {
  times_ = {0.0};
  std::vector<double> own;
  double last = 0;
  const auto take = [&](int count, const auto& timeOf) {
    own.clear();
    for (int i = 0; i < count; ++i) own.push_back(timeOf(i));
    last = std::max(last, own.back());
  };
  for (const Medium& medium : media_) {
    if (medium.volume)
      take(medium.volume->info().frames, [&](int i) { return medium.volume->timeOf(i); });
    if (medium.fog)
      take(medium.fog->frames(), [&](int i) { return medium.fog->timeOf(i); });
    if (medium.smoke)
      take(medium.smoke->steps(), [&](int i) { return medium.smoke->timeOf(i); });
    if (medium.fds)
      take(medium.fds->steps(), [&](int i) { return medium.fds->timeOf(i); });
  }
  for (const Board& board : boards_)
    take(board.volume.info().frames, [&](int i) { return board.volume.timeOf(i); });
  const bool blown =
      std::ranges::any_of(scene_.fogs, [](const auto& fog) { return fog.wind != Vec3::Zero(); });
  if (media_.size() + boards_.size() == 1 && (own.size() > 1 || !blown)) {
    times_ = own;
    return;
  }
  if (blown)
    last = std::max(last, kBlown);
  const double frames = std::min(std::round(last * kRate), 1e6);
  for (int frame = 1; frame <= static_cast<int>(frames); ++frame) times_.push_back(frame / kRate);
}

std::string SceneDocument::title() const {
  const std::string name = std::filesystem::path(path_).filename().string();
  const bool damaged = std::ranges::any_of(media_, &Medium::damaged);
  if (media_.size() == 1 && media_.front().volume) {
    const VolumeInfo& info = media_.front().volume->info();
    return fmt::format("{}: {} x {} x {} voxels, {}{}", name, info.x, info.y, info.z,
                       countOf(info.frames, "frame"), damaged ? ", DAMAGED" : "");
  }
  if (extensionOf(path_) != ".json") {
    return fmt::format("{}: {}", name,
                       media_.empty()       ? "a billboard"
                       : media_.front().fog ? "a map of fog"
                       : media_.front().fds ? "an FDS case"
                                            : "smoke on a mesh");
  }
  const auto count = [&](const auto& is) { return std::ranges::count_if(media_, is); };
  std::vector<std::string> parts;
  const auto add = [&](std::ptrdiff_t number, const char* one) {
    if (number > 0)
      parts.push_back(countOf(number, one));
  };
  add(count([](const Medium& m) { return m.volume.has_value(); }), "volume");
  add(count([](const Medium& m) { return m.fog.has_value(); }), "fog");
  add(count([](const Medium& m) { return m.smoke || m.fds; }), "smoke");
  add(std::ssize(scene_.lights.lamps), "light");
  add(std::ssize(scene_.signs), "sign");
  add(std::ssize(geometry_.triangles()), "triangle");
  add(std::ssize(boards_), "billboard");
  return fmt::format("{}: {}{}", name,
                     parts.empty() ? "an empty scene" : fmt::to_string(fmt::join(parts, ", ")),
                     damaged ? ", DAMAGED" : "");
}

bool SceneDocument::grey() const {
  return !media_.empty() && geometry_.empty() && scene_.signs.empty() &&
         std::ranges::all_of(media_, [](const Medium& medium) {
           return medium.volume && medium.volume->info().channels == 1;
         });
}

/// Smoke and fog are seen as they are; fire of unknown brightness gets an exposure.
bool SceneDocument::measured() const {
  return boards_.empty() && std::ranges::none_of(media_, [](const Medium& medium) {
           return medium.volume.has_value();
         });
}

std::vector<std::filesystem::path> SceneDocument::files() const {
  auto files = filesOf(scene_, json_, file_);
  files.insert(files.begin(), path_);
  return files;
}

std::vector<Parameter> SceneDocument::parameters() const {
  return sceneParameters(json_, scene_, facts());
}

Status SceneDocument::set(const std::string& path, const std::vector<double>& value,
                          Progress& progress) {
  Json before = json_, changed = json_;
  VOLUTE_TRY(setParameter(changed, scene_, facts(), path, value));
  VOLUTE_TRY(changeTo(std::move(changed), progress));
  history_.note(std::move(before), path);
  return {};
}

/// From where it is looked at first stays.
Status SceneDocument::changeTo(Json json, Progress& progress) {
  const auto start = start_;
  VOLUTE_TRY(load(std::move(json), progress));
  start_ = start;
  return {};
}

/// With what only the files know.
SceneEdit SceneDocument::withBounds(SceneEdit edit) const {
  for (std::size_t i = 0; i < media_.size(); ++i) {
    if (media_[i].volume && edit.path == fmt::format("/media/{}", i))
      edit.bounds = media_[i].volume->fileBounds();
  }
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    if (edit.path == fmt::format("/billboards/{}", i))
      edit.bounds = boards_[i].volume.fileBounds();
  }
  return edit;
}

Result<std::string> SceneDocument::edit(const SceneEdit& edit, Progress& progress) {
  Json before = json_, changed = json_;
  VOLUTE_ASSIGN(auto done, applyEdit(changed, withBounds(edit)));
  VOLUTE_TRY(changeTo(std::move(changed), progress));
  history_.note(std::move(before), "");
  return done;
}

Status SceneDocument::undo(Progress& progress) {
  if (!history_.canUndo())
    return {};
  Json now = json_;
  VOLUTE_TRY(changeTo(history_.before(), progress));
  history_.undone(std::move(now));
  return {};
}

Status SceneDocument::redo(Progress& progress) {
  if (!history_.canRedo())
    return {};
  Json now = json_;
  VOLUTE_TRY(changeTo(history_.after(), progress));
  history_.redone(std::move(now));
  return {};
}

/// A map that is one picture for all times.
bool SceneDocument::paintable(const Medium& medium) {
  if (!medium.fog)
    return false;
  const FogDescription& words = medium.fogWords;
  return words.maps.size() == 1 && isPicturePath(words.maps.front()) &&
         !FramePattern::isPattern(words.maps.front()) && words.placement.sigmaMax > 0;
}

Result<SceneDocument::Medium*> SceneDocument::canvasMedium(std::size_t canvas) {
  std::size_t count = 0;
  for (Medium& medium : media_) {
    if (paintable(medium) && count++ == canvas)
      return &medium;
  }
  return fail(ErrorCode::kNotFound, "{}: there is no map of fog to paint on any more", path_);
}

std::vector<FogCanvas> SceneDocument::canvases() const {
  std::vector<FogCanvas> canvases;
  for (const Medium& medium : media_) {
    if (!paintable(medium))
      continue;
    const FogDescription& words = medium.fogWords;
    const std::string& file = words.maps.front();
    const FogLayer layer = shownFog(medium);
    canvases.push_back({std::filesystem::path(file).filename().string(), file,
                        words.placement.sigmaMax, layer.fogAt(0), words.wind, medium.unsaved});
  }
  return canvases;
}

Status SceneDocument::setFogMap(std::size_t canvas, std::vector<double> coefficients,
                                bool unsaved) {
  VOLUTE_ASSIGN(Medium* const found, canvasMedium(canvas));
  Medium& medium = *found;
  const FogLevels& levels = medium.fog->fogAt(0).levels();
  if (static_cast<std::size_t>(levels.columns()) * levels.rows() != coefficients.size())
    return fail(ErrorCode::kInvalidArgument, "the map of fog has another size by now");
  medium.painted = std::move(coefficients);
  medium.paintedMost = medium.fogWords.placement.sigmaMax;
  medium.unsaved = unsaved;
  return {};
}

Status SceneDocument::saveFogMap(std::size_t canvas, const std::string& target, const Image& map) {
  const float most = *std::ranges::max_element(map.pixels);
  if (most > 1 && extensionOf(target) == ".png") {
    return fail(ErrorCode::kInvalidArgument,
                "{}: the map is up to {:.3g} times its largest value, which a .png cannot hold; "
                "save an .exr",
                target, most);
  }
  VOLUTE_ASSIGN(Medium* const found, canvasMedium(canvas));
  VOLUTE_TRY(writeMap(target, map));
  Medium& medium = *found;
  medium.unsaved = false;
  medium.json["map"] = nameFrom(target, file_, std::filesystem::path(target).filename().string());
  json_["media"][static_cast<std::size_t>(&medium - media_.data())] = medium.json;
  medium.fogWords.maps = {target};
  history_.clear();  // of a scene with another map
  const nlohmann::json plain = json_;
  VOLUTE_ASSIGN(scene_, parseScene(plain, file_));
  return {};
}

Status SceneDocument::save(const std::string& target, const StartView& view, const ViewLook& look) {
  Json json = json_;
  Json& camera = json["camera"];
  camera["eye"] = vectorOf(view.eye);
  camera["target"] = vectorOf(view.target);
  camera["up"] = vectorOf(view.up);
  camera.erase(view.ortho > 0 ? "fov" : "ortho");
  if (view.ortho > 0)
    camera["ortho"] = view.ortho;
  else
    camera["fov"] = view.fov;
  json["view"] = toJson(look);
  moveAllNames(json, file_, target);
  VOLUTE_ASSIGN(auto file, OutputFile::create(target));
  const std::string text = json.dump(2) + "\n";
  VOLUTE_TRY(file.write(std::as_bytes(std::span(text))));
  return file.commit();
}

}  // namespace volute
