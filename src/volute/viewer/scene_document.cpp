// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/scene_document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "volute/base/read_text.hpp"
#include "volute/base/remark_log.hpp"
#include "volute/base/write_file.hpp"
#include "volute/io/output_names.hpp"
#include "volute/lighting/light_memory.hpp"
#include "volute/scene/scene_end.hpp"
#include "volute/scene/scene_names.hpp"
#include "volute/viewer/recovery.hpp"
#include "volute/viewer/watched_files.hpp"

namespace volute {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kEnough = 1 << 25;  ///< bytes in which something to see is looked for

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

SceneOptions sceneOptions(const DocumentOptions& options) {
  SceneOptions scene;
  scene.maxMemory = options.maxMemory;
  scene.files = {
      .partial = true, .verify = false, .measured = false, .lightCache = options.lightCache};
  scene.assume = true;
  return scene;
}

/// The same scene where what is not said means what it means today.
Json inNewestFormat(Json json) {
  if (json.at("format") == kSceneFormat)
    return json;
  json = Json(upgradedScene(nlohmann::json(json)));
  json["format"] = kSceneFormat;
  for (std::size_t i = 0; json.contains("media") && i < json["media"].size(); ++i) {
    Json& entry = json["media"][i];
    if (entry.value("kind", "") == "volume" && !entry.contains("emission"))
      entry.emplace("preset", "none");
  }
  return json;
}

StartView startOf(const CameraDescription& camera) {
  return {camera.view.eye, camera.view.target, camera.view.up,
          camera.fov.value_or(Camera::kUsualFov), camera.ortho.value_or(0)};
}

}  // namespace

SceneDocument::SceneDocument(std::string path, Scene scene, const DocumentOptions& options)
    : path_(std::move(path)), options_(options), scene_(std::move(scene)) {
  file_ = scene_.isFile() ? path_ : path_ + ".json";
  const auto camera = scene_.camera();
  if (!camera)
    return;
  start_ = startOf(*camera);
  // A medium's own camera may stand within it.
  start_->walks = !scene_.isFile() && !scene_.bounds().empty() &&
                  (camera->view.eye.array() >= scene_.bounds().min.array()).all() &&
                  (camera->view.eye.array() <= scene_.bounds().max.array()).all();
  start_->moves = !scene_.isFile() && !start_->walks;
}

Result<std::unique_ptr<Document>> SceneDocument::open(const std::string& path,
                                                      const DocumentOptions& options,
                                                      Progress& progress) {
  SceneOptions scene = sceneOptions(options);
  scene.files.lightMemory = std::make_shared<LightMemory>(kLightBytes);
  if (path == options.file)
    scene.members = options.members;
  const auto onDisk = isScenePath(path) ? readText(path) : Result<std::string>("");
  RemarkLog remarkLog(progress);
  VOLUTE_ASSIGN(auto opened, Scene::open(path, scene, remarkLog));
  if (options.beginAt && path == options.file)
    VOLUTE_TRY(checkSceneTime(opened, *options.beginAt));
  std::unique_ptr<SceneDocument> document(new SceneDocument(path, std::move(opened), options));
  document->onDisk_ = onDisk.value_or("");
  document->sceneRemarks_ = remarkLog.sentences();
  for (const auto& medium : document->scene_.media()) {
    for (const Remark& remark : medium->remarks)
      std::erase(document->sceneRemarks_, remark.sentence);
  }
  if (path == options.file) {
    for (const std::string& more : options.more) {
      VOLUTE_ASSIGN(auto json, document->withFile(more, progress));
      VOLUTE_TRY(document->scene_.change(std::move(json), progress));
    }
  }
  document->saved_ = document->scene_.json();
  if (!document->scene_.isFile() || !document->start_) {
    auto sight = firstSight(document->scene_, progress, kEnough);
    if (sight)  // else sceneAt() says what is wrong
      document->sight_ = *sight;
    else if (sight.error().code == ErrorCode::kCancelled)
      return tl::unexpected<Error>(sight.error());
    VOLUTE_TRY(document->scene_.reconsider(progress));
    document->saved_ = document->scene_.json();
  }
  // As large as most windows are.
  constexpr int kWidth = 1280, kHeight = 720;
  const auto given = document->scene_.camera();
  document->scene_.setViews({given ? makeCamera(*given, {kWidth, kHeight})
                                   : Camera::framing(document->content(), kWidth, kHeight)});
  if (const auto name = Recovery::nameOf(path)) {
    document->file_ = *name;
    document->saved_ = {};  // nowhere
  }
  return std::unique_ptr<Document>(std::move(document));
}

std::vector<std::string> SceneDocument::remarks() const {
  std::vector<std::string> remarks = sceneRemarks_;
  for (const auto& medium : scene_.media())
    for (const Remark& remark : medium->remarks) remarks.push_back(remark.sentence);
  if (!scene_.assumption().empty())
    remarks.push_back(scene_.assumption());
  std::vector<std::string> all;  // a medium that is opened again after a change says all again
  for (std::string& remark : remarks) {
    remark = withoutPlace(std::move(remark), path_);
    if (std::ranges::find(all, remark) == all.end())
      all.push_back(std::move(remark));
  }
  return all;
}

/// Where the scene's file is another, what it says is the change before: Undo shows it.
Result<std::string> SceneDocument::goOnFrom(const Document& before, Progress& progress) {
  const auto* other = dynamic_cast<const SceneDocument*>(&before);
  if (!other || other->path_ != path_)
    return "";
  const bool same = onDisk_ == other->onDisk_;
  const Json& theirs = other->scene_.json();
  const bool unsaved = theirs != other->saved_;
  if (!unsaved && (!same || (!other->history_.canUndo() && !other->history_.canRedo())))
    return "";
  Json read = scene_.json();
  if (theirs != read)
    VOLUTE_TRY(scene_.change(theirs, progress));
  history_ = other->history_;
  overwritten_ = !same || other->overwritten_;
  if (same) {
    saved_ = other->saved_;
    return "";
  }
  history_.note(std::move(read), "");
  return fmt::format(
      "{} has changed on disk; your unsaved changes are kept, and Ctrl Z shows what the file says",
      std::filesystem::path(path_).filename().string());
}

bool SceneDocument::checked() const {
  return std::ranges::all_of(scene_.media(), [](const auto& medium) { return medium->checked(); });
}

void SceneDocument::check(Progress& progress) {
  for (const auto& medium : scene_.media()) {
    if (medium->checked())
      continue;
    const auto damage = medium->check(progress);
    if (!damage)
      return;  // stopped
    if (*damage)
      medium->remarks.push_back(**damage);
  }
}

std::string SceneDocument::title() const {
  const bool restored = Recovery::nameOf(path_).has_value();
  const std::string name = std::filesystem::path(restored ? file_ : path_).filename().string() +
                           (restored ? " (restored)" : "");
  const auto media = scene_.media();
  const bool damaged =
      std::ranges::any_of(media, [](const auto& medium) { return medium->damaged(); });
  const char* const end = damaged ? ", DAMAGED" : "";
  if (media.size() == 1 && !media[0]->info().size.empty())
    return fmt::format("{}: {}{}", name, media[0]->info().size, end);
  if (!scene_.isFile() && media.size() < 2)
    return fmt::format("{}: {}", name, media.empty() ? "nothing" : media[0]->info().what);
  std::vector<std::pair<std::string, std::ptrdiff_t>> counts;
  const auto count = [&](const std::string& what, std::ptrdiff_t more) {
    const auto found =
        std::ranges::find(counts, what, &std::pair<std::string, std::ptrdiff_t>::first);
    if (found != counts.end())
      found->second += more;
    else if (more > 0)
      counts.emplace_back(what, more);
  };
  for (const auto& medium : media) count(medium->info().kind, 1);
  count("light", std::ssize(scene_.description().lights.lamps));
  count("sign", std::ssize(scene_.description().signs));
  count("triangle", std::ssize(scene_.geometry().triangles()));
  std::vector<std::string> parts;
  for (const auto& [what, number] : counts) parts.push_back(countOf(number, what.c_str()));
  return fmt::format("{}: {}{}", name,
                     parts.empty() ? "an empty scene" : fmt::to_string(fmt::join(parts, ", ")),
                     end);
}

DocumentInfo SceneDocument::info() const {
  const auto media = scene_.media();
  const auto all = [&](auto holds) {
    return std::ranges::all_of(media, [&](const auto& medium) { return holds(medium->info()); });
  };
  DocumentInfo info{.title = title(), .bounds = scene_.bounds(), .times = scene_.times()};
  info.content = content();
  info.firstTime = sight_ ? sight_->time : info.times.front();
  info.grey = !media.empty() && scene_.geometry().empty() && scene_.description().signs.empty() &&
              all([](const auto& medium) { return medium.channels == 1; });
  // From 0 or 1 on, without gaps, they say nothing.
  if (media.size() == 1 && media[0]->info().numbers.size() == info.times.size()) {
    const auto& numbers = media[0]->info().numbers;
    const auto last = static_cast<std::size_t>(std::max(numbers.back(), 0));
    if (numbers.front() > 1 || last >= numbers.size() + static_cast<std::size_t>(numbers.front()))
      info.numbers = numbers;
  }
  // Several media have 25 frames a second, each of which is one.
  info.interpolates =
      media.size() == 1 && (media[0]->info().interpolates || media[0]->info().moves);
  // What is seen as it is; fire of unknown brightness gets an exposure.
  info.measured = all([](const auto& medium) { return medium.measured; });
  info.burns = scene_.law().mode != PictureMode::kThreshold &&
               !all([](const auto& medium) { return !medium.burns; });
  info.startView = start_;
  if (const auto camera = scene_.camera())
    info.cameraKeys = camera->keys;
  info.rests = info.times.size() == 1;
  if (info.rests && info.cameraKeys.size() > 1) {
    info.times = {info.cameraKeys.front().time, info.cameraKeys.back().time};
    info.interpolates = true;
  }
  info.look = scene_.description().look;
  info.background = scene_.description().background;
  info.remarks = remarks();
  info.parameters = scene_.parameters();
  info.canvases = canvases();
  info.sceneName = file_;
  info.editable = true;
  info.changed = scene_.json() != saved_;
  if (info.changed) {
    Json json = scene_.json();
    moveAllNames(json, file_, "/nowhere/scene.json");
    info.unsaved = json.dump(2) + "\n";
  }
  info.overwritten = overwritten_;
  info.canUndo = history_.canUndo();
  info.canRedo = history_.canRedo();
  info.snapshotMemory = options_.maxMemory / 4;
  return info;
}

std::vector<std::filesystem::path> SceneDocument::files() const {
  std::vector<std::filesystem::path> files;
  for (const std::string& name : scene_.files()) {
    const auto some = filesOf(name);
    files.insert(files.end(), some.begin(), some.end());
  }
  return files;
}

/// Media are shared: a change makes others in their place. The renderer is not, so that the window
/// does not wait for pictures of a long job.
std::shared_ptr<Document> SceneDocument::frozen() const {
  std::shared_ptr<SceneDocument> copy(new SceneDocument(*this));
  copy->drawer_ = std::make_shared<Drawer>();
  return copy;
}

Status SceneDocument::set(const std::string& path, const std::vector<double>& value,
                          Progress& progress) {
  VOLUTE_ASSIGN(auto changed, scene_.with(path, value));
  Json before = scene_.json();
  VOLUTE_TRY(scene_.change(std::move(changed), progress));
  history_.note(std::move(before), path);
  return {};
}

/// With what only the files know.
SceneEdit SceneDocument::withBounds(SceneEdit edit) const {
  for (std::size_t i = 0; i < scene_.media().size(); ++i) {
    if (scene_.description().media[i].path == edit.path)
      edit.bounds = scene_.media()[i]->info().fileBounds;
  }
  return edit;
}

Result<std::string> SceneDocument::edit(const SceneEdit& edit, Progress& progress) {
  Json before = scene_.json(), changed = scene_.json();
  VOLUTE_ASSIGN(auto done, applyEdit(changed, withBounds(edit)));
  VOLUTE_TRY(scene_.change(std::move(changed), progress));
  history_.note(std::move(before), "");
  return done;
}

/// The scene with what another file holds. Lights are ours where we have some: those that a medium
/// alone is shown in would shine twice.
Result<Json> SceneDocument::withFile(const std::string& path, Progress& progress) const {
  VOLUTE_ASSIGN(const auto other, Scene::open(path, sceneOptions(options_), progress));
  Json theirs = other.json(), json = scene_.json();
  if (theirs.at("format") != json.at("format"))
    theirs = inNewestFormat(std::move(theirs)), json = inNewestFormat(std::move(json));
  moveAllNames(theirs, path, file_);
  for (const std::string list : {"media", "billboards", "geometry", "signs", "lights"}) {
    const Json entries = theirs.value(list, Json::array());
    if (entries.empty() || (list == "lights" && json.contains(list)))
      continue;
    if (!json.contains(list))
      json[list] = Json::array();
    json[list].insert(json[list].end(), entries.begin(), entries.end());
  }
  return json;
}

Result<std::string> SceneDocument::add(const std::string& path, Progress& progress) {
  VOLUTE_ASSIGN(auto changed, withFile(path, progress));
  Json before = scene_.json();
  VOLUTE_TRY(scene_.change(std::move(changed), progress));
  history_.note(std::move(before), "");
  return std::filesystem::path(path).filename().string() + " is added; Ctrl Z takes it out again";
}

Status SceneDocument::undo(Progress& progress) {
  if (!history_.canUndo())
    return {};
  Json now = scene_.json();
  VOLUTE_TRY(scene_.change(history_.before(), progress));
  history_.undone(std::move(now));
  return {};
}

Status SceneDocument::redo(Progress& progress) {
  if (!history_.canRedo())
    return {};
  Json now = scene_.json();
  VOLUTE_TRY(scene_.change(history_.after(), progress));
  history_.redone(std::move(now));
  return {};
}

/// That `target` is none of the files that the scene shows, but for `own`, which is written. The
/// first of Scene::files() is what was opened: the scene's own file, or what is shown.
Status SceneDocument::checkNotShown(const std::string& target, const std::string& own) const {
  const auto names = scene_.files();
  for (auto name = names.begin() + (scene_.isFile() ? 1 : 0); name != names.end(); ++name) {
    for (const auto& file : filesOf(*name)) {
      if (file != own && replaces(target, file.string())) {
        return fail(ErrorCode::kInvalidArgument,
                    "{}: is shown and would be replaced; give another name", target);
      }
    }
  }
  return {};
}

Status SceneDocument::save(const std::string& target, const StartView& view, const ViewLook& look) {
  VOLUTE_TRY(checkNotShown(target, ""));
  Json json = scene_.json();
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
  const std::string text = json.dump(2) + "\n";
  VOLUTE_TRY(writeFile(target, text));
  if (target == path_) {
    onDisk_ = text;
    overwritten_ = false;
  }
  saved_ = scene_.json();
  return {};
}

}  // namespace volute
