// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "volute/viewer/imgui_spellings.hpp"
#include "volute/viewer/panels.hpp"

namespace volute {
namespace {

constexpr float kPaintLabels = 70;

/// Which map is painted, where there are several.
void mapPart(ViewerApp& app) {
  FogPainting& painting = app.tools().painting;
  const auto names = painting.names();
  int chosen = static_cast<int>(painting.chosen());
  if (names.size() > 1 && choiceBox(app, "map", "painted map", names, chosen))
    painting.choose(static_cast<std::size_t>(chosen));
}

void toolPart(ViewerApp& app) {
  PaintTool& paint = app.tools().painting.tool();
  int kind = static_cast<int>(paint.kind);
  constexpr std::pair<const char*, const char*> kTools[] = {
      {"add", "more fog under the brush"},
      {"remove", "less fog under the brush"},
      {"smooth", "smooth: each coefficient moves towards the mean of its neighbours"},
      {"coefficient", "drag one coefficient up and down"}};
  for (int i = 0; i < 4; ++i) {
    if (i > 0 && i < 3)  // as many as the panel is wide
      ImGui::SameLine();
    ImGui::RadioButton(tr(kTools[i].first), &kind, i);
    app.window().mark(std::string("tool ") + kTools[i].first);
    hint(kTools[i].second);
  }
  paint.kind = static_cast<PaintTool::Kind>(kind);
  const double size = paint.painter().size().maxCoeff();
  sliderDouble("size", paint.brush.radius, 0.5 * paint.painter().cell(), 0.5 * size, "%.3g m",
               true);
  app.window().mark("brush size");
  sliderDouble("strength", paint.brush.strength, 0.01, 4, "%.2f /s", true);
  app.window().mark("brush strength");
  hint("strength per second: share of the densest fog, or of the way to the mean");
  sliderDouble("softness", paint.brush.softness, 0, 1, "%.2f");
  app.window().mark("brush softness");
  hint("0: constant up to the rim");
}

void historyPart(ViewerApp& app) {
  FogPainter& painter = app.tools().painting.tool().painter();
  if (markedButton(app, "Undo", "Undo", painter.canUndo()))
    app.tools().painting.undo();
  ImGui::SameLine();
  if (markedButton(app, "Redo", "Redo", painter.canRedo()))
    app.tools().painting.redo();
  ImGui::SameLine();
  if (markedButton(app, "Clear", "Clear") && painter.fill(0))
    app.tools().painting.send();
}

/// The map from above as it lies in calm air, to be painted on.
void planPart(ViewerApp& app, const ViewerInput& input) {
  PaintTool& paint = app.tools().painting.tool();
  const FogPainter& painter = paint.painter();
  const Vec2 size = painter.size();
  const float width = ImGui::GetContentRegionAvail().x;
  const float scale =
      std::min(width / static_cast<float>(size.x()), width / static_cast<float>(size.y()));
  const ImVec2 from = ImGui::GetCursorScreenPos();
  const ImVec2 to{from.x + scale * static_cast<float>(size.x()),
                  from.y + scale * static_cast<float>(size.y())};
  ImGui::InvisibleButton("plan", {to.x - from.x, to.y - from.y});
  app.window().mark("plan");
  const Vec2 origin = painter.origin();
  const auto onScreen = [&](const Vec2& at) {
    const Vec2 local = at - origin;
    return ImVec2(from.x + scale * static_cast<float>(local.x()),
                  to.y - scale * static_cast<float>(local.y()));
  };
  // Texel (i, j) is centred on the peak of its coefficient.
  const int columns = painter.coefficients().columns, rows = painter.coefficients().rows;
  const Vec2 half = Vec2::Constant(0.5 * painter.cell());
  const ImVec2 low = onScreen(painter.peakOf({0, 0}) - half);
  const ImVec2 high = onScreen(painter.peakOf({columns - 1, rows - 1}) + half);
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled(from, to, IM_COL32(68, 1, 84, 255));
  list->AddImage(imgui::textureOf(app.tools().painting.plan()), {low.x, high.y}, {high.x, low.y});
  list->AddRect(from, to, IM_COL32(255, 255, 255, 60));
  if (ImGui::IsItemHovered() || ImGui::IsItemActive()) {
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    PaintHand hand;
    hand.onPlan = true;
    hand.at = origin + Vec2((mouse.x - from.x) / scale, (to.y - mouse.y) / scale);
    hand.pressed = ImGui::IsItemActive();
    hand.seconds = input.seconds;
    hand.up = -ImGui::GetIO().MouseDelta.y;
    if (paint.hold(hand))
      app.tools().painting.send();
    const ImU32 color = IM_COL32(255, 255, 255, 220);
    if (paint.kind != PaintTool::Kind::kCoefficient)
      list->AddCircle(onScreen(*hand.at), scale * static_cast<float>(paint.brush.radius), color);
    else if (const auto held = paint.held())
      list->AddCircle(onScreen(painter.peakOf(*held)), 5, color, 0, 2);
  } else if (paint.onPlan() || (!app.settings().painting && ImGui::IsMouseReleased(0))) {
    paint.hold({});
  }
}

/// What the brush is over.
void valuePart(const PaintTool& paint) {
  const FogPainter& painter = paint.painter();
  const auto place = paint.held() ? paint.held()
                     : paint.at() ? painter.nearest(*paint.at())
                                  : std::nullopt;
  if (place) {
    ImGui::TextDisabled(tr("column %d, row %d: %.4f /m"), place->column, place->row,
                        painter.valueOf(*place));
  } else {
    ImGui::TextDisabled(tr("%d x %d values, 0 to %.3g /m"), painter.coefficients().columns,
                        painter.coefficients().rows, painter.most());
  }
}

void savePaintPart(ViewerApp& app) {
  ImGui::SetNextItemWidth(-1);
  nameBox("##map", app.settings().mapName);
  app.window().mark("map");
  const bool unsaved = app.tools().painting.unsaved();
  if (ImGui::Button(tr("Save map")))
    app.tools().painting.save();
  app.window().mark("Save map");
  ImGui::SameLine();
  ImGui::TextDisabled("%s", tr(unsaved ? "not saved yet" : "as in the file"));
}

}  // namespace

void drawPaintPanel(ViewerApp& app, const ViewerInput& input, float below) {
  PanelLayout& layout = app.settings().layout;
  if (!app.tools().painting.tool().has()) {
    layout.measure(SidePanel::kPaint, 0);
    return;
  }
  if (!layout.isOpen(SidePanel::kPaint))
    layout.measure(SidePanel::kPaint, ImGui::GetFrameHeight());
  if (beginSidePanel(app, SidePanel::kPaint, "Paint fog", kPanelMargin, below)) {
    ImGui::PushItemWidth(-kPaintLabels);
    mapPart(app);
    ImGui::Checkbox(tr("paint in the view"), &app.settings().painting);
    app.window().mark("paint in the view");
    hint("left button: paint on the ground; right button: turn");
    toolPart(app);
    planPart(app, input);
    valuePart(app.tools().painting.tool());
    historyPart(app);
    ImGui::Separator();
    savePaintPart(app);
    ImGui::PopItemWidth();
  }
  endSidePanel(app, SidePanel::kPaint);
}

}  // namespace volute
