// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The part of a ViewerApp that knows what to say about the picture, and what is under the pointer.
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/viewer/viewer_app.hpp"

namespace volute {
namespace {

using NoteClock = std::chrono::steady_clock;

constexpr double kMoment = 0.4;   ///< [s] that nothing need be said of
constexpr double kStale = 0.5;    ///< [s]
constexpr double kToast = 6;      ///< [s]
constexpr int kProbes = 256;      ///< places along a ray

/// How long it has been so [s]; 0 where it is not.
double lasting(bool is, std::optional<NoteClock::time_point>& since) {
  if (!is) {
    since.reset();
    return 0;
  }
  if (!since)
    since = NoteClock::now();
  return std::chrono::duration<double>(NoteClock::now() - *since).count();
}

std::string fileName(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

std::string timeLeft(double seconds) {
  if (seconds < 1)
    return "";
  return seconds < 100 ? fmt::format(", {:.0f} s left", seconds)
                       : fmt::format(", {:.0f} min left", seconds / 60);
}

}  // namespace

std::string ViewerApp::title() const {
  if (!document_)
    return "Volute";
  const std::string mark = unsavedMap() || unsavedScene() ? "* " : "";
  return mark + fileName(document_->path) + " - Volute";
}

void ViewerApp::noteWork() {
  work_ = {};
  const CpuProgress drawn = picture_.progress();
  const bool loads = loading_.busy && !timeline_.playing();
  const bool draws = drawn.busy && !moving_ && !picture_.stopped();
  const double working = lasting(loads || draws, workingSince_);
  const bool late = scene_ && picture_.shown() &&
                    (picture_.stale() || std::abs(picture_.shownTime() - scene_->time) > 1e-9);
  work_.stale = lasting(late && !moving_, staleSince_) > kStale;
  if (working < kMoment && picture_.shown())
    return;
  if (loads) {
    work_.text = loading_.stage.empty() ? "loading" : loading_.stage;
    work_.share = loading_.share;
  } else if (draws) {
    work_.text = fmt::format("drawing, {:.0f} %{}", 100 * drawn.share, timeLeft(drawn.secondsLeft));
    work_.share = drawn.share;
    work_.stops = picture_.shown();
  }
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
  return size.empty() ? "stopped before it was as fine as it gets" : "stopped at " + size;
}

void ViewerApp::noteToast() {
  if (message_ != toasted_) {
    toast_ = toasted_ = message_;
    toastUntil_ = NoteClock::now() + std::chrono::milliseconds(static_cast<int>(1000 * kToast));
  }
  if (toastUntil_ && NoteClock::now() > *toastUntil_) {
    toastUntil_.reset();
    toast_.clear();
  }
}

ViewCamera::Insets ViewerApp::insets(int width, int height) const {
  static_cast<void>(height);
  ViewCamera::Insets insets;
  if (!settings_.panels)
    return insets;
  const PanelLayout& layout = settings_.layout;
  const auto taken = [](float panel) { return static_cast<double>(kPanelMargin + panel + kPanelGap); };
  if (layout.isOpen(SidePanel::kPicture) || layout.isOpen(SidePanel::kPaint))
    insets.left = taken(layout.width(SidePanel::kPicture));
  if (layout.isOpen(SidePanel::kScene) && document_ && !document_->parameters.empty())
    insets.right = taken(layout.width(SidePanel::kScene));
  constexpr double kFree = 0.35;
  if (width - insets.left - insets.right < kFree * width)
    insets.left = insets.right = 0;  // a panel over the picture, for a while
  constexpr double kTimePanel = 84;  // two rows, about; it may not have been drawn yet
  if (timeline_.moves())
    insets.bottom = kTimePanel * options_.scale;
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
  say("turning around what you pressed");
}

std::optional<ViewerApp::Probe> ViewerApp::probeAt(double x, double y) {
  if (!scene_ || !document_)
    return std::nullopt;
  const ViewScene& scene = *scene_->scene;
  if (probedOf_ != &scene) {
    probed_.clear();
    for (const auto& medium : scene.now) medium->addMedia(probed_.emplace_back());
    probedOf_ = &scene;
  }
  Segment ray = camera_.camera(seen_.width, seen_.height).ray(x, y);
  Probe probe;
  if (const auto wall = pickWall(scene, ray)) {
    probe.onSurface = true;
    probe.place = wall->position;
    ray.end = std::max(ray.begin, (wall->position - ray.origin).dot(ray.direction));
  }
  const double size = document_->bounds.size().norm();
  const auto parts = [&](const AnyMedium& medium) {
    const Interval inside = medium.bounds().intersect(ray.origin, ray.direction);
    return inside.intersect({std::max(ray.begin, -1e9), std::min(ray.end, ray.begin > -1e8 ? ray.begin + 1e3 * size + 1e3 : 1e9)});
  };
  double best = 0;
  for (const auto& media : probed_) {
    for (const AnyMedium& medium : media) {
      const Interval part = parts(medium);
      if (part.empty() || probe.onSurface)
        continue;
      for (int i = 0; i < kProbes; ++i) {
        const Vec3 at = ray.at(part.begin + (i + 0.5) / kProbes * (part.end - part.begin));
        const double value = medium.extinction(at) + medium.emission(at).sum();
        if (value > best) {
          best = value;
          probe.place = at;
        }
      }
    }
  }
  if (!probe.onSurface && best == 0)
    return std::nullopt;
  for (std::size_t m = 0; m < probed_.size(); ++m) {
    Probe::Medium found;
    found.name = probed_.size() == 1 ? "medium" : fmt::format("medium {}", m + 1);
    for (const AnyMedium& medium : probed_[m]) {
      double depth = 0;
      medium.opticalDepth({&ray, 1}, {&depth, 1});
      found.extinction += medium.extinction(probe.place);
      found.emission += medium.emission(probe.place);
      found.opticalDepth += depth;
    }
    probe.media.push_back(std::move(found));
  }
  return probe;
}

void ViewerApp::setClipboard(std::function<std::string()> get,
                             std::function<void(const std::string&)> set) {
  getClipboard_ = std::move(get);
  setClipboard_ = std::move(set);
}

/// As a scene's "camera" is written.
void ViewerApp::copyCamera() {
  const StartView view = startView();
  const auto list = [](const Vec3& v) {
    return nlohmann::ordered_json::array({v.x(), v.y(), v.z()});
  };
  nlohmann::ordered_json camera{{"eye", list(view.eye)}, {"target", list(view.target)},
                                {"up", list(view.up)}};
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
  if (options_.desktop) {
    if (dialog_)
      return;
    dialog_ = DesktopDialog::open(folder);
    if (dialog_)
      return;
  }
  browse(folder);
}

void ViewerApp::browse(const std::filesystem::path& folder) {
  browser_ = Browser{folder, folderEntries(folder)};
}

void ViewerApp::chooseFile(const std::filesystem::path& path) {
  const std::string chosen = path.string();  // the path may be the browser's own
  browser_.reset();
  leaveFor(chosen);
}

void ViewerApp::pollDialog() {
  if (!dialog_)
    return;
  const auto chosen = dialog_->poll();
  if (!chosen)
    return;
  dialog_.reset();
  if (!chosen->empty())
    leaveFor(*chosen);
}

}  // namespace volute
