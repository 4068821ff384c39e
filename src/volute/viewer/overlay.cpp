// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Lines over the picture: what a scene wants drawn, and the painter's hand.
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "volute/base/plain_number.hpp"
#include "volute/viewer/imgui_spellings.hpp"
#include "volute/viewer/panels.hpp"

namespace volute {
namespace {

constexpr int kRing = 64;

class Lines {
 public:
  explicit Lines(const Camera& camera) : camera_(camera), list_(ImGui::GetBackgroundDrawList()) {}

  /// What is behind the eye is cut off.
  void line(Vec3 from, Vec3 to, ImU32 color, float width = 1) const {
    const auto depth = [&](const Vec3& p) { return (p - camera_.eye()).dot(camera_.forward()); };
    const double nearest = 1e-3, a = depth(from), b = depth(to);
    const bool pinhole = !camera_.isOrthographic();
    if (pinhole && a < nearest && b < nearest)
      return;
    if (pinhole && a < nearest)
      from = from + (to - from) * (nearest - a) / (b - a);
    if (pinhole && b < nearest)
      to = to + (from - to) * (nearest - b) / (a - b);
    const auto first = camera_.project(from), second = camera_.project(to);
    if (first && second)
      list_->AddLine(at(*first), at(*second), color, width);
  }

  void dot(const Vec3& place, float radius, ImU32 color) const {
    if (const auto on = camera_.project(place))
      list_->AddCircleFilled(at(*on), radius, color);
  }

  void ring(const Vec3& middle, double radius, ImU32 color) const {
    const auto point = [&](int i) {
      const double angle = 2 * std::numbers::pi * i / kRing;
      return Vec3(middle + radius * Vec3(std::cos(angle), std::sin(angle), 0));
    };
    for (int i = 0; i < kRing; ++i) line(point(i), point(i + 1), color, 1.5F);
  }

 private:
  static ImVec2 at(const Vec2& place) {
    return {static_cast<float>(place.x()), static_cast<float>(place.y())};
  }

  const Camera& camera_;
  ImDrawList* list_;
};

Vec3 onGround(const PaintTool& paint, const Vec2& at) {
  return {at.x(), at.y(), paint.ground()};
}

/// Coefficients near the hand as stems, as high as they are large; the one that is held stands out.
void drawStems(const PaintTool& paint, const Lines& lines) {
  constexpr int kAround = 5;
  const FogPainter& painter = paint.painter();
  const auto held = paint.held();
  if (!held || !paint.heldAt())
    return;
  for (const auto& [place, at] : painter.around(*paint.heldAt(), kAround)) {
    const bool own = place == *held;
    const Vec3 foot = onGround(paint, at);
    const double height = paint.stem() * painter.valueOf(place) / painter.most();
    const Vec3 top = foot + height * Vec3::UnitZ();
    const ImU32 color = own ? IM_COL32(253, 231, 37, 255) : IM_COL32(94, 201, 178, 130);
    lines.line(foot, top, color, own ? 3.0F : 1.5F);
    lines.dot(top, own ? 5.0F : 2.5F, color);
  }
}

/// Where the next click would put a sign or a lamp: a cross on the wall, and a line away from it.
void drawPlacing(ViewerApp& app, const Camera& camera, const Lines& lines,
                 const ViewerInput& input) {
  if (app.tools().pointer.placing().empty() || ImGui::GetIO().WantCaptureMouse)
    return;
  const WallPlace at = app.tools().pointer.placeAlong(camera.ray(input.mouseX, input.mouseY));
  const double size = 0.03 * (at.position - camera.eye()).norm();
  const Vec3 aside = at.normal.unitOrthogonal(), along = at.normal.cross(aside);
  constexpr ImU32 kColor = IM_COL32(253, 231, 37, 255);
  lines.line(at.position - size * aside, at.position + size * aside, kColor, 2);
  lines.line(at.position - size * along, at.position + size * along, kColor, 2);
  lines.line(at.position, at.position + size * at.normal, kColor, 2);
}

/// From one end to the other, with its length and how far it goes along each axis.
void drawRuler(ViewerApp& app, const Camera& camera, const Lines& lines) {
  constexpr ImU32 kColor = IM_COL32(253, 231, 37, 255);
  const auto& ends = app.tools().pointer.ruler();
  for (const Vec3& end : ends) lines.dot(end, 4, kColor);
  if (ends.size() < 2)
    return;
  lines.line(ends[0], ends[1], kColor, 2);
  const auto at = camera.project(0.5 * (ends[0] + ends[1]));
  if (!at)
    return;
  Vec3 way = ends[1] - ends[0];
  for (double& along : way) {
    if (std::abs(along) < 1e-6 * way.norm())  // rounding
      along = 0;
  }
  const std::string text =
      fmt::format("{} m\nx {}  y {}  z {}", plainNumber(way.norm(), 4), plainNumber(way.x(), 4),
                  plainNumber(way.y(), 4), plainNumber(way.z(), 4));
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  const ImVec2 corner{static_cast<float>(at->x()) + 12, static_cast<float>(at->y()) - size.y / 2};
  list->AddRectFilled({corner.x - 6, corner.y - 4}, {corner.x + size.x + 6, corner.y + size.y + 4},
                      IM_COL32(12, 14, 18, 200), 6);
  list->AddText(corner, kColor, text.c_str());
}

/// Lines behind what there is to see: a dark background's are lighter than it and hidden by what is
/// lighter still, a light one's the other way round.
void drawAids(const ViewScene& scene, const Lines& lines, const Rgb& background) {
  const bool light = background.mean() > 0.5;
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const ImDrawListFlags flags = list->Flags;
  // A soft edge would be as dark or light as the line itself.
  list->Flags &= ~(ImDrawListFlags_AntiAliasedLines | ImDrawListFlags_AntiAliasedLinesUseTex);
  if (light)
    list->AddCallback([](const ImDrawList*, const ImDrawCmd*) { glBlendEquation(GL_MIN); },
                      nullptr);
  else
    list->AddCallback([](const ImDrawList*, const ImDrawCmd*) { glBlendEquation(GL_MAX); },
                      nullptr);
  for (const ViewLine& line : scene.aids) {
    const Rgb color = light ? Rgb(background - line.color) : Rgb(background + line.color);
    const auto byte = [&](int c) {
      return static_cast<int>(std::lround(255 * std::clamp(color[c], 0.0, 1.0)));
    };
    lines.line(line.from, line.to, IM_COL32(byte(0), byte(1), byte(2), 255));
  }
  list->AddCallback(imgui::resetRenderState(), nullptr);
  list->Flags = flags;
}

}  // namespace

void drawOverlay(ViewerApp& app, const ViewerInput& input) {
  const Camera camera = app.view().camera().camera(input.width, input.height);
  const Lines lines(camera);
  if (const ViewScene* scene = app.view().picture().scene()) {
    const auto draw = [&](const ViewLine& line) {
      const auto byte = [&](int c) { return static_cast<int>(std::lround(255 * line.color[c])); };
      lines.line(line.from, line.to, IM_COL32(byte(0), byte(1), byte(2), 255));
    };
    std::ranges::for_each(scene->lines, draw);
    if (app.settings().panels)
      std::ranges::for_each(scene->marks, draw);
    if (app.settings().panels && !scene->aids.empty()) {
      drawAids(*scene, lines, app.view().backgroundShown());
    }
  }
  drawPlacing(app, camera, lines, input);
  drawRuler(app, camera, lines);
  PaintTool& paint = app.tools().painting.tool();
  if (!app.settings().painting || !paint.has() || !paint.at())
    return;
  if (paint.kind == PaintTool::Kind::kCoefficient)
    drawStems(paint, lines);
  else
    lines.ring(onGround(paint, *paint.at()), paint.brush.radius, IM_COL32(255, 255, 255, 220));
}

}  // namespace volute
