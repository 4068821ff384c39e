// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/viewer_tools.hpp"

#include <algorithm>

#include "volute/viewer/language.hpp"

namespace volute {

void FogPainting::take(const DocumentInfo& info, bool another) {
  if (info.canvases.empty())
    return drop();
  const std::size_t number = std::min(tool_.number(), info.canvases.size() - 1);
  tool_.take(info.canvases[number], number, info.opened);
  if (savedVersion_ && !info.canvases[number].unsaved)
    tool_.painter().markSaved(*std::exchange(savedVersion_, std::nullopt));
  plan_.invalidate();
  if (settings_.mapName.empty() || another)
    settings_.mapName = tool_.canvas().file;
  if (tool_.takeUnsent())
    send();
}

void FogPainting::drop() {
  tool_.drop();
  savedVersion_.reset();
  settings_.painting = false;
}

void FogPainting::send() {
  plan_.invalidate();
  document_.loader().change(
      fmt::format("map {}", tool_.number()),
      [number = tool_.number(), map = tool_.painter().coefficients().c, unsaved = unsaved()](
          Document& document, Progress&) -> Result<std::string> {
        VOLUTE_TRY(document.setFogMap(number, map, unsaved));
        return "";
      });
}

void FogPainting::save() {
  if (!tool_.has())
    return;
  const std::string target = settings_.mapName;
  if (target == tool_.canvas().file)
    document_.files().allow(target);
  if (!document_.files().mayWrite(target, [this] { save(); }))
    return;
  send();
  savedVersion_ = tool_.painter().version();
  tool_.savesAs(target);
  document_.loader().change("save map",
                            [target, number = tool_.number(), map = tool_.painter().picture()](
                                Document& document, Progress&) -> Result<std::string> {
                              VOLUTE_TRY(document.saveFogMap(number, target, map));
                              return target + " is written";
                            });
}

void FogPainting::undo() {
  if (tool_.has() && tool_.painter().undo())
    send();
}

void FogPainting::redo() {
  if (tool_.has() && tool_.painter().redo())
    send();
}

GLuint FogPainting::plan() {
  if (plan_.stale())
    plan_.draw(tool_.painter().picture());
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
