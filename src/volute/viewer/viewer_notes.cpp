// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The part of a ViewerApp that knows what to say about the picture, and what is under the pointer.
#include <imgui.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/viewer/viewer_app.hpp"

namespace volute {
namespace {

std::string fileName(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

}  // namespace

std::string ViewerApp::title() const {
  if (!document_)
    return "Volute";
  const std::string mark = unsavedMap() || unsavedScene() ? "* " : "";
  return mark + fileName(document_->path) + " - Volute";
}

WorkNotes::Seen ViewerApp::seenWork() const {
  WorkNotes::Seen seen;
  seen.loads = loading_.busy && !timeline_.playing();
  seen.stage = loading_.stage;
  seen.loaded = loading_.share;
  seen.drawn = picture_.progress();
  seen.draws = seen.drawn.busy && !moving_ && !picture_.stopped();
  seen.shown = picture_.shown();
  seen.late = !moving_ && scene_ && picture_.shown() &&
              (picture_.stale() || std::abs(picture_.shownTime() - scene_->time) > 1e-9);
  return seen;
}

std::string ViewerApp::pictureNote() const {
  if (!picture_.shown() || !picture_.scene())
    return "";
  const double scale = picture_.scale();
  std::string size = scale >= 0.99  ? ""
                     : scale == 0.5 ? "half size"
                                    : fmt::format("1/{:.2g} size", 1 / scale);
  if (timeline_.playing())
    return size.empty() ? "" : size + " while it plays";
  if (!picture_.stopped())
    return "";
  return size.empty() ? "stopped before full resolution" : "stopped at " + size;
}

ViewCamera::Insets ViewerApp::insets(int width, int height) const {
  static_cast<void>(height);
  ViewCamera::Insets insets;
  if (!settings_.panels)
    return insets;
  const PanelLayout& layout = settings_.layout;
  const auto taken = [](float panel) {
    return static_cast<double>(kPanelMargin + panel + kPanelGap);
  };
  if (layout.isOpen(SidePanel::kPicture) || layout.isOpen(SidePanel::kPaint))
    insets.left = taken(layout.width(SidePanel::kPicture));
  if (layout.isOpen(SidePanel::kScene) && document_ && !document_->parameters.empty())
    insets.right = taken(layout.width(SidePanel::kScene));
  constexpr double kFree = 0.35;
  if (width - insets.left - insets.right < kFree * width)
    insets.left = insets.right = 0;  // a panel over the picture, for a while
  constexpr double kTimePanel = 84;  // two rows, about; it may not have been drawn yet
  if (timeline_.moves())
    insets.bottom = kTimePanel;
  return insets;
}

void ViewerApp::lookFromAxis(const Vec3& side) {
  camera_.setMode(ViewCamera::Mode::kOrbit);
  camera_.lookAlong(-side);
}

/// A surface, else a place as far away as the pivot.
Vec3 ViewerApp::placeUnder(double x, double y) const {
  const Segment ray = camera_.camera(seen_.width, seen_.height).ray(x, y);
  if (scene_) {
    if (const auto wall = pickWall(*scene_->scene, ray))
      return wall->position;
  }
  const double slope = ray.direction.dot(camera_.forward());
  const double depth = (camera_.pivot() - ray.origin).dot(camera_.forward());
  return ray.at(depth > 0 && slope > 0 ? depth / slope : camera_.distance());
}

void ViewerApp::pivotAt(double x, double y) {
  const auto probe = probeAt(x, y);
  camera_.setPivot(probe ? probe->place : placeUnder(x, y));
  say("set the centre of rotation");
}

std::optional<MediumProbe::Reading> ViewerApp::probeAt(double x, double y) {
  if (!scene_ || !document_)
    return std::nullopt;
  return probe_.read(scene_->scene, camera_.camera(seen_.width, seen_.height).ray(x, y),
                     document_->bounds.size().norm());
}

/// As a scene's "camera" is written.
void ViewerApp::copyCamera() {
  const StartView view = startView();
  const auto list = [](const Vec3& v) {
    return nlohmann::ordered_json::array({v.x(), v.y(), v.z()});
  };
  nlohmann::ordered_json camera{
      {"eye", list(view.eye)}, {"target", list(view.target)}, {"up", list(view.up)}};
  if (view.ortho > 0)
    camera["ortho"] = view.ortho;
  else
    camera["fov"] = view.fov;
  ImGui::SetClipboardText(camera.dump().c_str());
  say("the camera is copied, as JSON");
}

void ViewerApp::askToOpen() {
  std::error_code unknown;
  std::filesystem::path folder = std::filesystem::current_path(unknown);
  if (document_ && !document_->path.empty())
    folder = std::filesystem::absolute(document_->path, unknown).parent_path();
  files_.askToOpen(folder, options_.desktop);
}

void ViewerApp::chooseFile(const std::filesystem::path& path) {
  const std::string chosen = path.string();  // the path may be the list's own
  files_.closeBrowser();
  leaveFor(chosen);
}

}  // namespace volute
