// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "volute/viewer/panels.hpp"

namespace volute {
namespace {

constexpr float kParameterLabels = 110;  ///< [pixels] that are left for names
constexpr double kDegree = std::numbers::pi / 180;

/// Where a light's rays come from, or where a sign looks, as two angles. The light stays above the
/// ground.
bool directionControl(ViewerApp& app, const Parameter& parameter, std::vector<double>& value) {
  const bool light = parameter.path.starts_with("/lights/");
  const double sign = light ? -1 : 1;
  const Vec3 v = sign * Vec3(value[0], value[1], value[2]);
  const double length = std::max(v.norm(), 1e-9);
  double azimuth = std::atan2(v.y(), v.x()) / kDegree;
  double elevation = std::asin(std::clamp(v.z() / length, -1.0, 1.0)) / kDegree;
  bool moved = sliderDouble("azimuth", azimuth, -180, 180, "%.0f degrees");
  app.window().mark(parameter.path);
  hint(light ? "azimuth of the light's source, from +x towards +y"
             : "azimuth of the normal, from +x towards +y");
  moved |= sliderDouble("elevation", elevation, light ? 1 : -90, 90, "%.0f degrees");
  app.window().mark(parameter.path + " elevation");
  hint(light ? "elevation of the light's source above the horizon"
             : "elevation of the normal above the horizon");
  if (!moved)
    return false;
  const double level = std::cos(elevation * kDegree) * length;
  value = {sign * level * std::cos(azimuth * kDegree), sign * level * std::sin(azimuth * kDegree),
           sign * length * std::sin(elevation * kDegree)};
  return true;
}

/// So many digits that three numbers fit beside each other, each in `room` [points].
const char* formatOfThree(const std::vector<double>& value, float room) {
  double most = 0;
  for (const double v : value) most = std::max(most, std::abs(v));
  if (ImGui::CalcTextSize("0.000").x > room)
    return most < 9.99 ? "%.2f" : most < 99.9 ? "%.1f" : "%.0f";
  return most < 0.1 ? "%.3f" : most < 9.99 ? "%.2f" : most < 99.9 ? "%.1f" : "%.0f";
}

/// To the centimetre while that fits; finer where it is drawn in finer steps.
const char* formatOfPoint(const std::vector<double>& value, double step) {
  const auto [least, most] = std::ranges::minmax(value);
  if (step < 0.005 && most < 9.99 && least > -9.99)
    return "%.3f";
  if (step >= 0.1)
    return most < 9999 && least > -999 ? "%.1f" : "%.0f";
  return most < 999.9 && least > -99.9 ? "%.2f" : most < 1e4 && least > -999.9 ? "%.1f" : "%.0f";
}

/// Of numbers beside each other: ImGui's names of the first three.
std::array<unsigned, 3> idsOf(const char* label) {
  std::array<unsigned, 3> ids{};
  ImGui::PushID(label);
  for (int i = 0; i < 3; ++i) {
    ImGui::PushID(i);
    ids[static_cast<std::size_t>(i)] = ImGui::GetID("");
    ImGui::PopID();
  }
  ImGui::PopID();
  return ids;
}

/// Linear light: three numbers that may be dragged, and a patch that opens a picker.
bool colorControl(ViewerApp& app, const Parameter& parameter, std::vector<double>& value) {
  constexpr double kNone = 0;
  const float patch = ImGui::GetFrameHeight(), gap = ImGui::GetStyle().ItemInnerSpacing.x;
  const double most = *std::ranges::max_element(value);
  const auto step = static_cast<float>(std::max(1.0 / 255, 0.01 * most));
  const float wide = ImGui::CalcItemWidth() - patch - gap;
  const float room = (wide - 2 * gap) / 3 - 2 * ImGui::GetStyle().FramePadding.x;
  ImGui::SetNextItemWidth(wide);
  ImGui::BeginGroup();
  bool moved =
      ImGui::DragScalarN("##numbers", ImGuiDataType_Double, value.data(), 3, step, &kNone, nullptr,
                         formatOfThree(value, room), ImGuiSliderFlags_NoRoundToFormat);
  ImGui::SameLine(0, gap);
  float shown[] = {static_cast<float>(value[0]), static_cast<float>(value[1]),
                   static_cast<float>(value[2])};
  constexpr ImGuiColorEditFlags kLight = ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR;
  if (ImGui::ColorEdit3("##patch", shown, kLight | ImGuiColorEditFlags_NoInputs)) {
    moved = true;
    value.assign(shown, shown + 3);
  }
  ImGui::SameLine(0, gap);
  ImGui::TextUnformatted(tr(parameter.name).c_str());
  ImGui::EndGroup();
  app.window().mark(parameter.path, idsOf("##numbers"));
  for (double& v : value) v = std::max(0.0, v);
  return moved;
}

std::string formatOf(const Parameter& parameter) {
  const std::string digits = parameter.most >= 1000 ? "%.0f" : "%.3g";
  std::string unit = parameter.unit.empty() ? "" : " " + parameter.unit;
  for (std::size_t at = 0; (at = unit.find('%', at)) != std::string::npos; at += 2)
    unit.insert(at, 1, '%');
  return digits + unit;
}

/// True when a person changed the value.
bool control(ViewerApp& app, const Parameter& parameter, std::vector<double>& value) {
  const std::string label = tr(parameter.name);
  const char* name = label.c_str();
  bool moved = false;
  switch (parameter.kind) {
    case Parameter::Kind::kNumber:
      moved = sliderDouble(parameter.name.c_str(), value.front(), parameter.least, parameter.most,
                           formatOf(parameter).c_str(), parameter.logarithmic);
      break;
    case Parameter::Kind::kInteger: {
      int number = static_cast<int>(value.front());
      moved =
          ImGui::SliderInt(name, &number, static_cast<int>(parameter.least),
                           static_cast<int>(parameter.most), "%d", ImGuiSliderFlags_AlwaysClamp);
      value.front() = number;
      break;
    }
    case Parameter::Kind::kFlag: {
      bool on = value.front() != 0;
      moved = ImGui::Checkbox(name, &on);
      value.front() = on ? 1 : 0;
      break;
    }
    case Parameter::Kind::kChoice: {
      int chosen = static_cast<int>(value.front());
      moved = choiceBox(app, parameter.name.c_str(), parameter.path, parameter.choices, chosen);
      value.front() = chosen;
      return moved;
    }
    case Parameter::Kind::kPoint: {
      const std::string unit = parameter.unit.empty() ? "" : " [" + parameter.unit + "]";
      moved = ImGui::DragScalarN((label + unit).c_str(), ImGuiDataType_Double, value.data(),
                                 static_cast<int>(value.size()), static_cast<float>(parameter.step),
                                 nullptr, nullptr, formatOfPoint(value, parameter.step),
                                 ImGuiSliderFlags_NoRoundToFormat);
      app.window().mark(parameter.path, idsOf((label + unit).c_str()));
      return moved;
    }
    case Parameter::Kind::kColor:
      return colorControl(app, parameter, value);
    case Parameter::Kind::kDirection:
      return directionControl(app, parameter, value);
  }
  app.window().mark(parameter.path);
  return moved;
}

/// What a parameter belongs to: "/signs/0", "/media/1"; empty: the scene itself.
std::string ownerOf(const Parameter& parameter) {
  const auto first = parameter.path.find('/', 1);
  if (first == std::string::npos)
    return "";
  return parameter.path.substr(0, parameter.path.find('/', first + 1));
}

/// A volume can be looked at as a billboard, and back.
void billboardButton(ViewerApp& app, const std::string& owner, const std::string& group) {
  if (!app.document().info()->editable)
    return;
  const bool volume = group.starts_with("volume:"), board = group.starts_with("billboard:");
  if (!volume && !board)
    return;
  if (markedButton(app, volume ? "Show as billboard" : "Show as volume",
                   (volume ? "billboard " : "volume ") + owner)) {
    app.document().edit(
        {.kind = volume ? SceneEdit::Kind::kBillboard : SceneEdit::Kind::kVolume, .path = owner});
  }
  hint(volume ? "a flat picture of it that faces you, fast for small or distant volumes; it "
                "cannot be turned or mirrored"
              : "with its depth");
}

/// What can be done with a sign or a light as a whole.
void ownerButtons(ViewerApp& app, const std::string& owner) {
  const bool sign = owner.starts_with("/signs/");
  const bool clip = owner.starts_with("/clip/");
  if (!app.document().info()->editable || !(sign || clip || owner.starts_with("/lights/")))
    return;
  ImGui::PushID(owner.c_str());
  const auto& all = app.document().info()->parameters;
  const bool somewhere = std::ranges::find(all, owner + "/position", &Parameter::path) != all.end();
  if (somewhere) {
    const bool placing = app.tools().pointer.placing() == owner;
    if (markedButton(app, placing ? "click a wall###place" : "Place###place", "place " + owner))
      app.tools().pointer.place(placing ? "" : owner);
    hint("place it with the next click in the picture");
    ImGui::SameLine();
  }
  if (markedButton(app, "Duplicate", "duplicate " + owner))
    app.document().edit({.kind = SceneEdit::Kind::kDuplicate, .path = owner});
  ImGui::SameLine();
  if (markedButton(app, "Remove", "remove " + owner))
    app.document().edit({.kind = SceneEdit::Kind::kRemove, .path = owner});
  ImGui::PopID();
}

/// What a scene can get, and what can be taken back.
void editPart(ViewerApp& app) {
  if (!app.document().info()->editable)
    return;
  using Kind = SceneEdit::Kind;

  constexpr struct {
    const char *label, *mark, *help;
    Kind kind;
  } kAdded[] = {
      {"Sign", "add sign", "add an exit sign at the centre of the picture", Kind::kAddSign},
      {"Lamp", "add lamp", "add a lamp at the centre of the picture", Kind::kAddSpot},
      {"Sun", "add sun", "light from afar", Kind::kAddSun},
      {"Ambient", "add ambient", "light from everywhere", Kind::kAddAmbient},
      {"Box", "add clip box", "a box outside of which the media are not shown", Kind::kAddClipBox},
      {"Plane", "add clip plane", "a plane before which the media are not shown",
       Kind::kAddClipPlane}};

  for (const auto& added : kAdded) {
    const bool clips = added.kind == Kind::kAddClipBox;
    if (&added == std::begin(kAdded) || clips) {
      ImGui::AlignTextToFramePadding();
      ImGui::TextUnformatted(tr(clips ? "clip" : "add"));
    }
    ImGui::SameLine();
    if (markedButton(app, added.label, added.mark))
      app.tools().pointer.add(added.kind);
    hint(added.help);
  }
  if (markedButton(app, "Undo", "Undo change", app.document().info()->canUndo))
    app.document().undo();
  ImGui::SameLine();
  if (markedButton(app, "Redo", "Redo change", app.document().info()->canRedo))
    app.document().redo();
  hint("undo or redo changes, additions and removals");
}

/// "smoke: hall.pvd" in so many letters; the kind stays.
std::string headingOf(const std::string& group, std::size_t letters) {
  const std::size_t kind = group.find(": ");
  const std::size_t kept = kind == std::string::npos ? 0 : kind + 2;
  if (kept == 0)
    return trName(group);
  return trName(group.substr(0, kind)) + ": " +
         shortened(group.substr(kept), letters - std::min(letters, kept));
}

/// An entry of a list: one more beside it, or it goes.
void entryButtons(ViewerApp& app, const Parameter& parameter) {
  if (!parameter.entry)
    return;
  const std::size_t last = parameter.path.find_last_of('/');
  const std::string list = parameter.path.substr(0, last), place = parameter.path.substr(last + 1);
  const auto button = [&](const char* label, const char* what, SceneEdit::Kind kind) {
    ImGui::SameLine(0, ImGui::GetStyle().ItemInnerSpacing.x);
    if (ImGui::SmallButton(label))
      app.document().edit({.kind = kind, .path = parameter.path});
    app.window().mark(fmt::format("{} {} = {}", what, list, place));
  };
  button("+", "add", SceneEdit::Kind::kDuplicate);
  hint("one more after it");
  if (!parameter.removable)
    return;
  button("x", "remove", SceneEdit::Kind::kRemove);
  hint("remove it");
}

/// What a value that may be wrong was probably meant to be: a click away.
void doubtPart(ViewerApp& app, const Parameter& parameter) {
  if (parameter.offers.empty())
    return;
  wrappedText(parameter.doubt, true);
  for (const int offer : parameter.offers) {
    const std::string& choice = parameter.choices[static_cast<std::size_t>(offer)];
    if (offer != parameter.offers.front())
      ImGui::SameLine();
    if (markedButton(app, (choice + "?").c_str(), "mend " + parameter.path + " = " + choice))
      app.document().set(parameter, {static_cast<double>(offer)});
    hint("takes the values as " + choice);
  }
}

/// Whether the rows that follow are shown. A long list waits until it is asked for.
bool sectionPart(ViewerApp& app, const std::vector<Parameter>& all, const Parameter& first) {
  if (first.section.empty())
    return true;
  constexpr std::ptrdiff_t kLong = 7;  // rows
  const std::string owner = ownerOf(first);
  const auto rows = std::ranges::count_if(all, [&](const Parameter& parameter) {
    return parameter.section == first.section && ownerOf(parameter) == owner;
  });
  ImGui::SetNextItemOpen(rows < kLong, ImGuiCond_Once);
  const bool open =
      ImGui::TreeNodeEx((tr(first.section) + "###" + owner + " " + first.section).c_str(),
                        ImGuiTreeNodeFlags_NoTreePushOnOpen | ImGuiTreeNodeFlags_SpanAvailWidth);
  app.window().mark("group " + first.section + " of " + owner);
  return open;
}

/// All that can be changed, by what it belongs to.
void parametersPart(ViewerApp& app) {
  ImGui::PushItemWidth(-kParameterLabels);
  editPart(app);
  const float arrow = ImGui::GetTreeNodeToLabelSpacing();
  const std::size_t letters = lettersIn(ImGui::GetContentRegionAvail().x - arrow);
  const auto parameters = app.document().info()->parameters;  // changes below
  std::string owner = "none", section;
  bool open = false, shown = false;
  for (const Parameter& parameter : parameters) {
    if (ownerOf(parameter) != owner) {  // two signs may have the same name
      owner = ownerOf(parameter);
      open =
          ImGui::CollapsingHeader((headingOf(parameter.group, letters) + "###of " + owner).c_str(),
                                  ImGuiTreeNodeFlags_DefaultOpen);
      app.window().mark("group " + parameter.group);
      hint(parameter.group.size() > letters ? parameter.group : "");
      if (open) {
        billboardButton(app, owner, parameter.group);
        ownerButtons(app, owner);
      }
      section.clear();
      shown = true;
    }
    if (!open)
      continue;
    if (parameter.section != section) {
      if (parameter.section.empty())
        ImGui::Separator();  // the section ends
      section = parameter.section;
      shown = sectionPart(app, parameters, parameter);
    }
    if (!shown)
      continue;
    ImGui::PushID(parameter.path.c_str());
    if (parameter.path.ends_with("/transfer/points/0"))
      drawTransferChart(app, parameter);
    std::vector<double> value = parameter.value;
    if (control(app, parameter, value))
      app.document().set(parameter, value);
    hint(parameter.help);
    entryButtons(app, parameter);
    doubtPart(app, parameter);
    ImGui::PopID();
  }
  ImGui::PopItemWidth();
}

}  // namespace

void drawParameterPanel(ViewerApp& app, const ViewerInput& input) {
  if (!app.document().info() ||
      (app.document().info()->parameters.empty() && !app.document().info()->editable))
    return;
  const float right = static_cast<float>(input.width) - kPanelMargin;
  const float left = right - app.settings().layout.shownWidth(SidePanel::kScene);
  if (beginSidePanel(app, SidePanel::kScene, "Scene", left, kPanelMargin))
    parametersPart(app);
  endSidePanel(app, SidePanel::kScene);
}

}  // namespace volute
