// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/camera_path.hpp"

#include <algorithm>
#include <cmath>

#include "volute/viewer/language.hpp"

namespace volute {
namespace {

constexpr double kApart = 2;    ///< [s] between keys of what does not move
constexpr double kSame = 1e-6;  ///< [s]

CameraDescription described(const StartView& view, std::vector<CameraKey> keys) {
  CameraDescription camera;
  camera.view = {view.eye, view.target, view.up};
  camera.keys = std::move(keys);
  if (view.ortho > 0)
    camera.ortho = view.ortho;
  else
    camera.fov = view.fov;
  return camera;
}

}  // namespace

ViewCamera alongKeys(const ViewCamera& camera, std::vector<CameraKey> keys, double time) {
  StartView view = camera.view();
  const View3 there = described(view, std::move(keys)).viewAt(time);
  view.eye = there.eye, view.target = there.target;
  ViewCamera moved = camera;
  moved.set(view);
  return moved;
}

void CameraPath::take(const DocumentInfo& info) {
  const auto same = [](const CameraKey& a, const CameraKey& b) {
    return a.time == b.time && a.eye == b.eye && a.target == b.target;
  };
  sent_ = sent_ && !std::ranges::equal(keys_, info.cameraKeys, same) && document_.changing();
  if (!sent_)
    keys_ = info.cameraKeys;
}

void CameraPath::send(const ViewCamera& camera) {
  document_.edit({.kind = SceneEdit::Kind::kCamera, .camera = described(camera.view(), keys_)});
  sent_ = true;
}

void CameraPath::set(const ViewCamera& camera, double time) {
  const DocumentInfo* info = document_.info();
  if (!info || !info->editable)
    return document_.say(tr("only a scene keeps a camera path"));
  if (info->rests && keys_.empty())
    time = 0;
  else if (info->rests && (!leads() || time > keys_.back().time - kSame))
    time = keys_.back().time + kApart;
  const StartView view = camera.view();
  auto at = std::ranges::lower_bound(keys_, time - kSame, {}, &CameraKey::time);
  if (at != keys_.end() && at->time < time + kSame)
    *at = {time, view.eye, view.target};
  else
    at = keys_.insert(at, {time, view.eye, view.target});
  const auto number = at - keys_.begin() + 1;
  send(camera);
  seek_ = followed_ = time;
  document_.say(
      fmt::format(fmt::runtime(tr("key {} of the camera path, at {:.3g} s")), number, time));
}

void CameraPath::remove(const ViewCamera& camera, double time) {
  if (keys_.empty())
    return document_.say(tr("the camera path has no keys"));
  const auto nearest = std::ranges::min_element(
      keys_, {}, [&](const CameraKey& key) { return std::abs(key.time - time); });
  const double gone = nearest->time;
  keys_.erase(nearest);
  send(camera);
  document_.say(fmt::format(fmt::runtime(tr("the camera's key at {:.3g} s is removed")), gone));
}

std::optional<ViewCamera> CameraPath::follow(const ViewCamera& camera, double time) {
  if (!leads() || std::exchange(followed_, time) == time)
    return std::nullopt;
  return alongKeys(camera, keys_, time);
}

}  // namespace volute
