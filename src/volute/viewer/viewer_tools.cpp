// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/viewer_tools.hpp"

#include <algorithm>
#include <iterator>

#include "volute/io/frame_file.hpp"
#include "volute/viewer/language.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {

namespace {

/// Whether a map that replaces this file loses nothing: it holds grey values, or is not there.
bool greyOnly(const std::string& file) {
  if (extensionOf(file) == ".png") {
    const auto kind = readPngKind(file);
    return !kind || (kind->channels == 1 && !kind->alpha);
  }
  const auto info = readFrameInfo(file);
  return !info || info->channels.size() <= 1;
}

/// Where a map that was read from this file would be saved: beside it where it holds more.
std::string targetFor(const std::string& file) {
  if (greyOnly(file))
    return file;
  const std::filesystem::path path(file);
  std::error_code unknown;
  for (int i = 1;; ++i) {
    const std::string end = i == 1 ? "_grey" : fmt::format("_grey_{}", i);
    const auto free = path.parent_path() / (path.stem().string() + end + path.extension().string());
    if (!std::filesystem::exists(free, unknown))
      return free.string();
  }
}

}  // namespace

std::vector<std::string> FogPainting::names() const {
  std::vector<std::string> names;
  for (const Map& map : maps_) {
    if (!map.tool.has())
      continue;
    const std::string& name = map.tool.canvas().name;
    std::string unlike = name;
    for (int i = 2; std::ranges::count(names, unlike) > 0; ++i)
      unlike = fmt::format("{} ({})", name, i);
    names.push_back(std::move(unlike));
  }
  return names;
}

void FogPainting::choose(std::size_t map) {
  if (map == chosen_ || map >= maps_.size())
    return;
  if (tool().has())
    tool().hold({});
  maps_[chosen_].target = settings_.mapName;
  const PaintTool& before = tool();
  PaintTool& next = maps_[map].tool;
  next.kind = before.kind;
  next.brush.strength = before.brush.strength, next.brush.softness = before.brush.softness;
  chosen_ = map;
  settings_.mapName = maps_[map].target;
  plan_.invalidate();
}

bool FogPainting::unsaved() const {
  return std::ranges::any_of(maps_, &Map::unsaved);
}

bool FogPainting::chooseUnsaved(std::size_t passed) {
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    if (maps_[i].unsaved() && passed-- == 0) {
      choose(i);
      return true;
    }
  }
  return false;
}

/// Each canvas goes on with what is held of it: first with what had its number, for two may show
/// the same file.
void FogPainting::take(const DocumentInfo& info, bool another) {
  maps_[chosen_].target = settings_.mapName;
  const auto kind = tool().kind;
  const FogBrush brush = tool().brush;
  std::vector<Map> held = std::exchange(maps_, {});
  const std::size_t shown = held.size();
  std::ranges::move(std::exchange(others_, {}), std::back_inserter(held));
  std::vector<bool> taken(held.size());
  std::vector<std::size_t> unsent;
  std::size_t chosen = 0;
  for (std::size_t i = 0; i < info.canvases.size(); ++i) {
    const FogCanvas& canvas = info.canvases[i];
    const auto free = [&](std::size_t k) { return !taken[k] && held[k].tool.holds(canvas); };
    std::size_t k = i < shown && free(i) ? i : 0;
    while (k < held.size() && !free(k)) ++k;
    Map& map = maps_.emplace_back();
    map.tool.kind = kind, map.tool.brush = brush;
    if (k < held.size()) {
      taken[k] = true;
      map = std::move(held[k]);
      chosen = k == chosen_ ? i : chosen;
    }
    map.tool.take(canvas, info.opened);
    if (map.savedVersion && !canvas.unsaved)
      map.tool.painter().markSaved(*std::exchange(map.savedVersion, std::nullopt));
    if (map.target.empty() || another)
      map.target = targetFor(canvas.file);
    const bool back = k >= shown && k < held.size();  // as its file has it
    if (map.tool.takeUnsent() || (back && map.unsaved()))
      unsent.push_back(i);
  }
  for (std::size_t k = 0; k < held.size(); ++k) {
    if (!taken[k] && held[k].tool.has())
      others_.push_back(std::move(held[k]));
  }
  chosen_ = chosen;
  if (maps_.empty()) {
    maps_.emplace_back();
    tool().kind = kind, tool().brush = brush;
    settings_.painting = false;
  }
  settings_.mapName = maps_[chosen_].target;
  plan_.invalidate();
  for (const std::size_t map : unsent) send(map);
}

void FogPainting::drop() {
  Map none;
  none.tool.kind = tool().kind, none.tool.brush = tool().brush;
  maps_.clear(), others_.clear();
  maps_.push_back(std::move(none));
  chosen_ = 0;
  settings_.painting = false;
}

void FogPainting::send(std::size_t map) {
  plan_.invalidate();
  document_.loader().change(
      fmt::format("map {}", map),
      [map, values = maps_[map].tool.painter().coefficients().c, unsaved = maps_[map].unsaved()](
          Document& document, Progress&) -> Result<std::string> {
        VOLUTE_TRY(document.setFogMap(map, values, unsaved));
        return "";
      });
}

void FogPainting::save() {
  if (!tool().has())
    return;
  const std::string target = settings_.mapName;
  const bool grey = greyOnly(target);
  if (target == tool().canvas().file && grey)
    document_.files().allow(target);
  if (!document_.files().mayWrite(
          target, [this] { save(); },
          grey ? "" : "A map is grey: its colours or transparency are lost."))
    return;
  send();
  maps_[chosen_].savedVersion = tool().painter().version();
  tool().savesAs(target);
  document_.loader().change(fmt::format("save map {}", chosen_),
                            [target, number = chosen_, map = tool().painter().picture()](
                                Document& document, Progress&) -> Result<std::string> {
                              VOLUTE_TRY(document.saveFogMap(number, target, map));
                              return target + " is written";
                            });
}

void FogPainting::endSaving() {
  for (Map& map : maps_) map.savedVersion.reset();
}

void FogPainting::undo() {
  if (tool().has() && tool().painter().undo())
    send();
}

void FogPainting::redo() {
  if (tool().has() && tool().painter().redo())
    send();
}

GLuint FogPainting::plan() {
  if (plan_.stale())
    plan_.draw(tool().painter().picture());
  return plan_.texture();
}

std::optional<MediumProbe::Reading> PointerTools::probeIn(const ViewerDocument& document,
                                                          MediumProbe& probe, double x,
                                                          double y) const {
  if (!document.scene() || !document.info())
    return std::nullopt;
  return probe.read(document.scene()->scene, rayAt(x, y), document.info()->bounds.size().norm());
}

Vec3 PointerTools::placeUnder(double x, double y) const {
  const Segment ray = rayAt(x, y);
  const ViewCamera& camera = view_.camera();
  if (const LoadedScene* scene = document_.scene()) {
    if (const auto wall = pickWall(*scene->scene, ray))
      return wall->position;
  }
  const double slope = ray.direction.dot(camera.forward());
  const double depth = (camera.pivot() - ray.origin).dot(camera.forward());
  return ray.at(depth > 0 && slope > 0 ? depth / slope : camera.distance());
}

WallPlace PointerTools::placeAlong(const Segment& ray) const {
  if (const LoadedScene* scene = document_.scene()) {
    if (const auto wall = pickWall(*scene->scene, ray))
      return *wall;
  }
  return {ray.at(view_.camera().distance()), -ray.direction};
}

void PointerTools::pivotAt(double x, double y) {
  const auto probe = probeAt(x, y);
  view_.camera().setPivot(probe ? probe->place : placeUnder(x, y));
  document_.say(tr("set the centre of rotation"));
}

void PointerTools::measureAt(double x, double y) {
  if (ruler_.size() > 1)
    ruler_.clear();
  const auto probe = probeAt(x, y);
  ruler_.push_back(probe ? probe->place : placeUnder(x, y));
}

void PointerTools::add(SceneEdit::Kind kind) {
  if (kind == SceneEdit::Kind::kAddClipBox || kind == SceneEdit::Kind::kAddClipPlane) {
    const DocumentInfo& info = *document_.info();
    return document_.edit({.kind = kind,
                           .position = info.content.centre(),
                           .normal = -view_.camera().forward(),
                           .bounds = info.content});
  }
  const WallPlace place = placeAlong(rayAt(0.5 * width_, 0.5 * height_));
  document_.edit({.kind = kind,
                  .position = place.position,
                  .normal = place.normal,
                  .reach = 0.25 * document_.info()->bounds.size().norm()});
}

void PointerTools::putAt(double x, double y) {
  const WallPlace at = placeAlong(rayAt(x, y));
  document_.edit({.kind = SceneEdit::Kind::kPlace,
                  .path = std::exchange(placing_, ""),
                  .position = at.position,
                  .normal = at.normal});
}

}  // namespace volute
