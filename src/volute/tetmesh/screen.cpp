// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/screen.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace volute {
namespace {

constexpr double kOffFace = 2e-6;  // share of a tet by which an eye keeps off its faces

Vec3 centreOf(const TetMesh& mesh, std::int32_t tet) {
  Vec3 centre = Vec3::Zero();
  for (const std::int32_t v : mesh.tets()[tet]) centre += 0.25 * mesh.vertices()[v];
  return centre;
}

constexpr float kNear = 1e-6F;    // [m]; what is nearer is cut off
constexpr float kMargin = 2e-3F;  // [pixels]; rounding of the projection

/// The pixels whose centres lie in a range, widened by a margin. Without std::floor, which is a
/// call where there is no instruction for it.
PixelBox boxAround(const ScreenView& view, float x0, float x1, float y0, float y1, float margin) {
  const auto floored = [](double x, int most) {
    return static_cast<int>(std::clamp(x, -1.0, most + 0.0) + 2) - 2;
  };
  const auto ceiled = [](double x, int most) {
    constexpr int kBig = 1 << 20;
    return kBig - static_cast<int>(kBig - std::clamp(x, -1.0, most + 0.0));
  };
  const double cx = 0.5 * view.width - 0.5, cy = 0.5 * view.height - 0.5;
  return {std::max(0, ceiled(x0 + cx - margin, view.width)),
          std::max(0, ceiled(y0 + cy - margin, view.height)),
          std::min(view.width - 1, floored(x1 + cx + margin, view.width)),
          std::min(view.height - 1, floored(y1 + cy + margin, view.height))};
}

}  // namespace

ScreenView::ScreenView(const Camera& camera, const TetLocator& locator)
    : eye(camera.eye()),
      right(camera.right()),
      down(camera.down()),
      forward(camera.forward()),
      perPixel(1 / camera.pixelSize()),
      orthographic(camera.isOrthographic()),
      width(camera.width()),
      height(camera.height()) {
  if (orthographic)
    return;
  const std::int32_t eyeTet = locator.find(eye);
  if (eyeTet < 0)
    return;
  const auto shares = locator.mesh().shares(eyeTet, eye);
  if (*std::ranges::min_element(shares) < kOffFace)
    eye += 4 * kOffFace * (centreOf(locator.mesh(), eyeTet) - eye);
}

ScreenVertex ScreenView::project(const Vec3& point) const {
  const Vec3 from = point - eye;
  const double z = from.dot(forward);
  return {static_cast<float>(from.dot(right) * perPixel),
          static_cast<float>(from.dot(down) * perPixel), static_cast<float>(orthographic ? 1 : z),
          static_cast<float>(z)};
}

PixelBox pixelBox(const ScreenView& view, const ScreenVertex& a, const ScreenVertex& b,
                  const ScreenVertex& c) {
  constexpr float kMax = std::numeric_limits<float>::max();
  float x0 = kMax, x1 = -kMax, y0 = kMax, y1 = -kMax;
  const auto add = [&](float x, float y, float w) {
    x0 = std::min(x0, x / w), x1 = std::max(x1, x / w);
    y0 = std::min(y0, y / w), y1 = std::max(y1, y / w);
  };
  const ScreenVertex* corners[3] = {&a, &b, &c};
  bool cut = false;
  for (int i = 0; i < 3; ++i) {
    const ScreenVertex& p = *corners[i];
    const ScreenVertex& q = *corners[(i + 1) % 3];
    if (p.w > kNear)
      add(p.x, p.y, p.w);
    if ((p.w > kNear) != (q.w > kNear)) {
      const float share = (kNear - p.w) / (q.w - p.w);
      add(p.x + share * (q.x - p.x), p.y + share * (q.y - p.y), kNear);
      cut = true;
    }
  }
  if (!(x0 <= x1))
    return {};
  // Cut edges are projected from near the eye, where a rounding is many pixels.
  return boxAround(view, x0, x1, y0, y1, cut ? 2 : kMargin);
}

PixelPlace pixelPlace(const ScreenVertex& vertex) {
  if (!(vertex.w > kNear))
    return {};
  return {vertex.x / vertex.w, vertex.y / vertex.w, true};
}

}  // namespace volute
