// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/scene_document.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/input_file.hpp"
#include "volute/base/write_file.hpp"
#include "volute/fds/smv_index.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/json_depth.hpp"
#include "volute/scene/scene_names.hpp"
#include "volute/scene/scene_parameters.hpp"
#include "volute/scene/volume_input.hpp"
#include "volute/viewer/watched_files.hpp"

namespace volute {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kRate = 25;      ///< frames a second of what has no times of its own
constexpr double kBlown = 10;     ///< [s] for which wind is shown at least
constexpr double kHighest = 1e6;  ///< [m] that counts as an end

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
  VOLUTE_ASSIGN(const auto file, InputFile::open(path_));
  std::string text(file.size(), '\0');
  VOLUTE_TRY(file.read(0, std::as_writable_bytes(std::span(text))));
  VOLUTE_TRY(checkJsonDepth(text, path_));
  return load(Json::parse(text, nullptr, false), progress);
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
  return writeFile(target, json.dump(2) + "\n");
}

}  // namespace volute
