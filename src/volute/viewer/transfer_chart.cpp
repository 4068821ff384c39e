// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The curve of a transfer function over how often values occur; its points are drawn by hand.
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "volute/image/colormap.hpp"
#include "volute/viewer/panels.hpp"

namespace volute {
namespace {

constexpr float kChartHigh = 120, kMapHigh = 8;
constexpr ImU32 kMark = IM_COL32(235, 238, 242, 235), kCounts = IM_COL32(120, 130, 142, 110);

/// One transfer function, as the document's parameters have it.
struct Curve {
  std::vector<const Parameter*> points;
  ColorMap map = ColorMap::kViridis;
  double least = 0, most = 1;  ///< values with the first and the last colour

  Curve(const std::vector<Parameter>& all, const std::string& begin) {
    for (const Parameter& parameter : all) {
      if (!parameter.path.starts_with(begin))
        continue;
      const std::string key = parameter.path.substr(begin.size());
      if (key.starts_with("points/"))
        points.push_back(&parameter);
      else if (key == "map")
        map = static_cast<ColorMap>(std::max(parameter.value[0] - 1, 0.0));  // after "off"
      else if (key == "range/0")
        least = parameter.value[0];
      else if (key == "range/1")
        most = parameter.value[0];
    }
  }

  double at(double value) const {
    if (value <= points.front()->value[0])
      return points.front()->value[1];
    for (std::size_t i = 1; i < points.size(); ++i) {
      const auto &a = points[i - 1]->value, &b = points[i]->value;
      if (value < b[0])
        return a[1] + (b[1] - a[1]) * (value - a[0]) / (b[0] - a[0]);
    }
    return points.back()->value[1];
  }
};

}  // namespace

void drawTransferChart(ViewerApp& app, const Parameter& first) {
  const std::string begin = first.path.substr(0, first.path.rfind("points/"));
  const Curve curve(app.document().info()->parameters, begin);
  double left = first.least, right = first.most, highest = 0;
  for (const Parameter* point : curve.points) {
    left = std::min(left, point->value[0]), right = std::max(right, point->value[0]);
    highest = std::max(highest, point->value[1]);
  }
  if (!(left < right))
    right = left + 1;
  const float width = ImGui::GetContentRegionAvail().x;
  const ImVec2 from = ImGui::GetCursorScreenPos();
  ImGui::InvisibleButton("##chart", {width, kChartHigh + kMapHigh});
  app.window().mark(begin + "chart");
  hint("drag a point: value and extinction; + beside its numbers adds one");
  // While a point is drawn the scale stays.
  ImGuiStorage* held = ImGui::GetStateStorage();
  const ImGuiID scaleOf = ImGui::GetID("scale"), pointOf = ImGui::GetID("point");
  const auto top = static_cast<float>(1.15 * std::max(highest, 1e-6));
  if (!ImGui::IsItemActive())
    held->SetFloat(scaleOf, top);
  const double most = held->GetFloat(scaleOf, top);
  const auto x = [&](double value) {
    return from.x + width * static_cast<float>((value - left) / (right - left));
  };
  const auto y = [&](double extinction) {
    return from.y + kChartHigh * static_cast<float>(1 - std::clamp(extinction / most, 0.0, 1.0));
  };
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled(from, {from.x + width, from.y + kChartHigh}, IM_COL32(12, 14, 18, 255), 3);
  constexpr float kColumn = 2;
  for (float at = 0; at < width; at += kColumn) {
    const double value = left + (right - left) * (at + 0.5 * kColumn) / width;
    const Rgb shown =
        displayColor(curve.map, (value - curve.least) / std::max(curve.most - curve.least, 1e-300));
    const auto byte = [&](int c) { return static_cast<int>(255 * shown[c]); };
    const float end = std::min(at + kColumn, width);
    list->AddRectFilled({from.x + at, y(curve.at(value))}, {from.x + end, from.y + kChartHigh},
                        IM_COL32(byte(0), byte(1), byte(2), 150));
    list->AddRectFilled({from.x + at, from.y + kChartHigh},
                        {from.x + end, from.y + kChartHigh + kMapHigh},
                        IM_COL32(byte(0), byte(1), byte(2), 255));
  }
  const auto& counts = first.counts;
  const double many = counts.empty() ? 0 : std::log1p(*std::ranges::max_element(counts));
  for (std::size_t i = 0; many > 0 && i < counts.size(); ++i) {
    const double step = (first.most - first.least) / static_cast<double>(counts.size());
    const double value = first.least + step * static_cast<double>(i);
    const auto high = static_cast<float>(std::log1p(counts[i]) / many);
    list->AddRectFilled({x(value), from.y + kChartHigh * (1 - high)},
                        {x(value + step) - 0.5F, from.y + kChartHigh}, kCounts);
  }
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const auto& point = curve.points[i]->value;
    const ImVec2 here{x(point[0]), y(point[1])};
    if (i > 0) {
      const auto& before = curve.points[i - 1]->value;
      list->AddLine({x(before[0]), y(before[1])}, here, kMark, 1.5F);
    }
    list->AddCircleFilled(here, 4.5F, kMark);
    list->AddCircle(here, 4.5F, IM_COL32(12, 14, 18, 255));
  }
  const std::string label = fmt::format("{:.3g} /m", most);
  list->AddText({from.x + 4, from.y + 2}, kMark, label.c_str());
  if (!ImGui::IsItemActive())
    return;
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  if (ImGui::IsItemActivated()) {
    const auto far = [&](const Parameter* point) {
      return std::hypot(x(point->value[0]) - mouse.x, y(point->value[1]) - mouse.y);
    };
    const auto nearest = std::ranges::min_element(curve.points, {}, far);
    held->SetInt(pointOf, static_cast<int>(nearest - curve.points.begin()));
  }
  const auto number = static_cast<std::size_t>(held->GetInt(pointOf));
  const ImVec2 moved = ImGui::GetIO().MouseDelta;
  if (number >= curve.points.size() || (moved.x == 0 && moved.y == 0))
    return;
  const Parameter point = *curve.points[number];  // its list changes
  const double value = left + (right - left) * (mouse.x - from.x) / width;
  const double extinction = most * (1 - (mouse.y - from.y) / kChartHigh);
  app.document().set(point, {std::clamp(value, left, right), std::max(extinction, 0.0)});
}

}  // namespace volute
