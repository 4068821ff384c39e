// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What stands on the picture between the panels: how far it has come, how large things are, which
// way is up, what is under the pointer, what has just been done.
#include <fmt/ranges.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "volute/base/plain_number.hpp"
#include "volute/image/colormap.hpp"
#include "volute/viewer/error_text.hpp"
#include "volute/viewer/panels.hpp"

namespace volute {
namespace {

constexpr ImU32 kInk = IM_COL32(235, 238, 242, 235), kShade = IM_COL32(12, 14, 18, 150);
constexpr ImU32 kAmber = IM_COL32(255, 190, 70, 255);

constexpr ImGuiWindowFlags kPlain =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
    ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing;

/// The part of the window that no panel covers [pixels].
struct FreeArea {
  float left, top, right, bottom;

  float middle() const { return 0.5F * (left + right); }

  /// Where what stands in the middle ends: above the scale bar where that reaches below it.
  float middleBottom() const {
    constexpr float kBar = 160, kMiddle = 300, kHigh = 46;
    return right - left < 2 * kBar + kMiddle ? bottom - kHigh : bottom;
  }
};

FreeArea freeArea(ViewerApp& app, const ViewerInput& input) {
  const auto insets = app.view().insets(input.width);
  const auto at = [](double value) { return static_cast<float>(value); };
  return {at(insets.left) + kPanelMargin, at(insets.top) + kPanelMargin,
          at(input.width - insets.right) - kPanelMargin,
          at(input.height) -
              (app.playback().timeline().moves() ? app.settings().timeHeight + kPanelMargin : 0) -
              kPanelMargin};
}

std::string lengthText(double metres) {
  if (metres >= 1000)
    return fmt::format("{:g} km", metres / 1000);
  if (metres >= 1)
    return fmt::format("{:g} m", metres);
  return metres >= 0.01 ? fmt::format("{:g} cm", 100 * metres)
                        : fmt::format("{:g} mm", 1000 * metres);
}

/// The largest of 1, 2, 5 times a power of ten that is not above it.
double roundLength(double most) {
  const double power = std::pow(10, std::floor(std::log10(most)));
  for (const double first : {5.0, 2.0}) {
    if (first * power <= most)
      return first * power;
  }
  return power;
}

/// What is being done, how far it is, and a way to end it.
void drawProgress(ViewerApp& app, const FreeArea& free) {
  const ViewerWork work = app.window().notes().work();
  if (work.text.empty())
    return;
  const bool nothing = !app.view().picture().shown();  // then it is all that there is to see
  const float width = std::min(nothing ? 360.0F : 300.0F, free.right - free.left);
  const float y = nothing ? 0.5F * (free.top + free.bottom) : free.middleBottom();
  ImGui::SetNextWindowPos({free.middle(), y}, 0, {0.5F, nothing ? 0.5F : 1.0F});
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, 1e4F});
  ImGui::SetNextWindowBgAlpha(0.8F);
  ImGui::Begin("Progress", nullptr, kPlain);
  if (work.stale)
    ImGui::TextColored({1, 0.75F, 0.3F, 1}, "%s", tr("not up to date:"));
  wrappedText(work.text);
  const float button = work.stops ? ImGui::CalcTextSize(tr("Stop")).x +
                                        2 * ImGui::GetStyle().FramePadding.x +
                                        ImGui::GetStyle().ItemSpacing.x
                                  : 0;
  if (work.share >= 0) {
    ImGui::ProgressBar(static_cast<float>(work.share), {-std::max(button, 1.0F), 8}, "");
    ImGui::SameLine();
    if (!work.stops)
      ImGui::Dummy({1, ImGui::GetFrameHeight()});  // it is as high when the button comes
  }
  if (work.stops && markedButton(app, "Stop", "stop drawing"))
    app.view().picture().stopRefining();
  ImGui::End();
}

/// What the picture that is shown lacks: "half size while it plays"; empty: nothing.
std::string pictureNote(ViewerApp& app) {
  const ViewPicture& picture = app.view().picture();
  if (!picture.shown() || !picture.scene())
    return "";
  const double scale = picture.state().scale;
  const std::string size = scale >= 0.99 ? ""
                           : scale == 0.5
                               ? tr("half size")
                               : fmt::format(fmt::runtime(tr("1/{:.2g} size")), 1 / scale);
  if (app.playback().timeline().playing())
    return size.empty() ? "" : fmt::format(fmt::runtime(tr("{} while it plays")), size);
  if (!picture.stopped())
    return "";
  return size.empty() ? tr("stopped before full resolution")
                      : fmt::format(fmt::runtime(tr("stopped at {}")), size);
}

/// One line at the top: what the picture is not.
void drawBadge(ViewerApp& app, const FreeArea& free) {
  const std::string text = pictureNote(app);
  if (text.empty() || !app.window().notes().work().text.empty())
    return;
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  const ImVec2 at{free.middle() - 0.5F * size.x, free.middleBottom() - size.y - 6};
  list->AddRectFilled({at.x - 10, at.y - 4}, {at.x + size.x + 10, at.y + size.y + 4}, kShade, 9);
  list->AddText(at, kInk, text.c_str());
}

void drawToast(ViewerApp& app, const FreeArea& free) {
  const std::string& text = app.window().notes().toast();
  if (text.empty())
    return;
  constexpr float kBelowTitles = 38;  // of panels that are closed, in small windows
  const float above = std::max(free.top, kPanelMargin + app.settings().alertsHeight);
  ImGui::SetNextWindowPos({free.middle(), std::max(above, kBelowTitles)}, 0, {0.5F, 0});
  const float width = std::max(std::min(460.0F, free.right - free.left), 120.0F);
  ImGui::SetNextWindowSizeConstraints({0, 0}, {width, 1e4F});
  ImGui::SetNextWindowBgAlpha(0.92F);
  ImGui::Begin("Toast", nullptr, kPlain | ImGuiWindowFlags_NoInputs);
  ImGui::PushTextWrapPos(width - 20);
  if (app.document().saysFailure())
    ImGui::PushStyleColor(ImGuiCol_Text, kFailure);
  ImGui::TextUnformatted(text.c_str());
  if (app.document().saysFailure())
    ImGui::PopStyleColor();
  ImGui::PopTextWrapPos();
  ImGui::End();
}

/// How long things are where the camera turns around.
void drawScaleBar(ViewerApp& app, const FreeArea& free, const ViewerInput& input) {
  if (!app.document().info() || !app.view().picture().shown() ||
      app.document().info()->bounds.empty())
    return;
  const ViewCamera& view = app.view().camera();
  const Camera camera = view.camera(input.width, input.height);
  const double depth =
      camera.isOrthographic() ? 1 : (view.pivot() - camera.eye()).dot(camera.forward());
  if (!(depth > 0))
    return;
  constexpr double kMax = 120;  // pixels
  const double metres = roundLength(kMax * depth * camera.pixelSize());
  const auto length = static_cast<float>(metres / (depth * camera.pixelSize()));
  const std::string text = lengthText(metres);
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const float x = free.left + 8, y = free.bottom - 10;
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  list->AddRectFilled({x - 8, y - size.y - 12}, {x + std::max(length, size.x) + 8, y + 8}, kShade,
                      6);
  list->AddText({x, y - size.y - 7}, kInk, text.c_str());
  list->AddLine({x, y}, {x + length, y}, kInk, 2);
  for (const float end : {x, x + length}) list->AddLine({end, y - 4}, {end, y + 4}, kInk, 2);
}

/// The colours of a quantity, with its numbers, from `bottom` up; returns where it ends. Lower
/// where there is little room.
float drawColorBar(const ViewScene::Scale& scale, const FreeArea& free, float bottom) {
  constexpr float kWide = 12, kOther = 150, kSteps = 44;
  const float high = std::clamp(free.bottom - free.top - kOther, 30.0F, 110.0F);
  const ColorScale& colors = scale.colors;
  const std::string most = fmt::format("{:.4g} {}", colors.most, colors.unit);
  const std::string least = fmt::format("{:.4g} {}", colors.least, colors.unit);
  const float line = ImGui::GetTextLineHeight();
  const float text =
      std::max({ImGui::CalcTextSize(most.c_str()).x, ImGui::CalcTextSize(least.c_str()).x, 40.0F});
  const float wrap = std::max(text + kWide + 6, 150.0F);
  const std::string lines = inLines(scale.name, wrap);
  const ImVec2 name = ImGui::CalcTextSize(lines.c_str());
  const float width = std::max(name.x, text + kWide + 6), left = free.right - width - 8;
  const float top = bottom - high - 8, head = top - name.y - 6;
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  list->AddRectFilled({left - 8, head - 6}, {free.right, bottom}, kShade, 6);
  list->AddText({left, head}, kInk, lines.c_str());
  for (int i = 0; i < static_cast<int>(kSteps); ++i) {
    const Rgb color = displayColor(colors.map, 1 - (i + 0.5) / kSteps);
    const auto byte = [&](int c) { return static_cast<int>(255 * color[c]); };
    const float y = top + high * static_cast<float>(i) / kSteps;
    list->AddRectFilled({left, y}, {left + kWide, y + high / kSteps + 0.5F},
                        IM_COL32(byte(0), byte(1), byte(2), 255));
  }
  list->AddText({left + kWide + 6, top - 2}, kInk, most.c_str());
  list->AddText({left + kWide + 6, top + high - line}, kInk, least.c_str());
  return head - 14;
}

/// Wherever a colour is a number.
void drawColorBars(ViewerApp& app, const FreeArea& free) {
  const ViewScene* scene = app.view().picture().scene();
  if (!scene || !app.view().picture().shown())
    return;
  float bottom = free.bottom;
  for (const ViewScene::Scale& scale : scene->scales) bottom = drawColorBar(scale, free, bottom);
  DisplayLook look = app.view().display();
  app.comparison().addTo(look);
  if (!(look.exposure > 0))
    return;
  if (look.other.picture)
    drawColorBar({tr("difference"), {*look.map, look.other.span, 0, tr("of white")}}, free, bottom);
  else if (look.map)
    drawColorBar({tr("light along the ray"), {*look.map, 1 / look.exposure, 0, ""}}, free, bottom);
}

/// Which file is on which side of the border.
void drawBorder(ViewerApp& app, const FreeArea& free, const ViewerInput& input) {
  const Comparison& comparison = app.comparison();
  if (!comparison.active() || !app.document().info() || comparison.mode != Comparison::Mode::kWiper)
    return;
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const auto x = static_cast<float>(comparison.border * input.width);
  list->AddLine({x, 0}, {x, static_cast<float>(input.height)}, kInk, 1.5F);
  const auto label = [&](const std::string& path, bool left) {
    const std::string name = std::filesystem::path(path).filename().string();
    const ImVec2 size = ImGui::CalcTextSize(name.c_str());
    const ImVec2 at{left ? x - size.x - 12 : x + 12, free.top + 4};
    if (at.x < free.left || at.x + size.x > free.right)
      return;
    list->AddRectFilled({at.x - 6, at.y - 3}, {at.x + size.x + 6, at.y + size.y + 3}, kShade, 6);
    list->AddText(at, kInk, name.c_str());
  };
  label(app.document().info()->path, true);
  label(comparison.path(), false);
}

struct AxisEnd {
  const char* name;
  const char* mark;
  Vec3 direction;
  ImU32 color;
};

/// The world's axes as the camera sees them; a click on an end looks from there.
void drawGizmo(ViewerApp& app, const FreeArea& free) {
  constexpr float kRadius = 34, kEnd = 9;
  static const AxisEnd kEnds[] = {{"x", "axis +x", Vec3::UnitX(), IM_COL32(236, 95, 88, 255)},
                                  {"", "axis -x", -Vec3::UnitX(), IM_COL32(140, 62, 60, 255)},
                                  {"y", "axis +y", Vec3::UnitY(), IM_COL32(125, 196, 95, 255)},
                                  {"", "axis -y", -Vec3::UnitY(), IM_COL32(72, 112, 58, 255)},
                                  {"z", "axis +z", Vec3::UnitZ(), IM_COL32(92, 151, 240, 255)},
                                  {"", "axis -z", -Vec3::UnitZ(), IM_COL32(56, 88, 140, 255)}};
  const bool covered = app.settings().layout.isOpen(SidePanel::kScene) &&
                       free.right > ImGui::GetIO().DisplaySize.x - 2 * kPanelMargin;
  const bool small = free.right - free.left < 6 * kRadius || free.bottom - free.top < 10 * kRadius;
  if (!app.document().info() || small || covered || !app.settings().layout.roomy())
    return;
  const ImVec2 middle{free.right - kRadius - kEnd, free.top + kRadius + kEnd};
  constexpr float kSide = 2 * (kRadius + kEnd);
  ImGui::SetNextWindowPos({middle.x - 0.5F * kSide, middle.y - 0.5F * kSide});
  ImGui::SetNextWindowSize({kSide, kSide});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::Begin("Orientation", nullptr,
               (kPlain & ~ImGuiWindowFlags_AlwaysAutoResize) | ImGuiWindowFlags_NoBackground);
  const ViewCamera& camera = app.view().camera();
  const Vec3 right = camera.right(), forward = camera.forward(), up = right.cross(forward);
  std::array<int, 6> order{0, 1, 2, 3, 4, 5};
  std::ranges::sort(order, std::greater<>(),
                    [&](int i) { return kEnds[i].direction.dot(forward); });
  ImDrawList* list = ImGui::GetWindowDrawList();
  for (const int i : order) {
    const AxisEnd& end = kEnds[i];
    const ImVec2 at{middle.x + kRadius * static_cast<float>(end.direction.dot(right)),
                    middle.y - kRadius * static_cast<float>(end.direction.dot(up))};
    const bool named = end.name[0] != 0;
    ImGui::SetCursorScreenPos({at.x - kEnd, at.y - kEnd});
    const bool pressed = ImGui::InvisibleButton(end.mark, {2 * kEnd, 2 * kEnd});
    const bool over = ImGui::IsItemHovered();
    app.window().mark(end.mark);
    if (named)
      list->AddLine(middle, at, end.color, 2);
    list->AddCircleFilled(at,
                          over    ? kEnd
                          : named ? kEnd - 1
                                  : kEnd - 4,
                          over ? kInk : end.color, 20);
    if (named) {
      const ImVec2 size = ImGui::CalcTextSize(end.name);
      list->AddText({at.x - 0.5F * size.x, at.y - 0.5F * size.y}, IM_COL32(16, 18, 22, 255),
                    end.name);
    }
    if (pressed)
      app.view().lookFrom(end.direction);
  }
  ImGui::End();
  ImGui::PopStyleVar();
}

/// What all fields of the files are there, shown or not; while it plays they would be late.
void drawFields(ViewerApp& app, ViewerDocument& document, const MediumProbe::Reading& probe) {
  if (app.playback().timeline().playing())
    return;
  const LoadedFields* read = document.fieldsAt(probe.inside);
  if (!read)
    return;
  if (!read->fields) {
    ImGui::Separator();
    wrappedText(viewerText(read->fields.error()), true);
    return;
  }
  for (const PlaceFields& medium : *read->fields) {
    ImGui::Separator();
    if (read->fields->size() > 1 || probe.media.empty())
      ImGui::TextDisabled("%s", medium.medium.c_str());
    for (const ProbedField& field : medium.fields)
      ImGui::TextUnformatted(
          fmt::format("{}  {:.4g} {}", field.name, fmt::join(field.values, " "), field.unit)
              .c_str());
  }
}

/// What the media are under the pointer.
void drawProbe(ViewerApp& app, const ViewerInput& input) {
  if (!app.settings().probe || ImGui::GetIO().WantCaptureMouse || input.mouseX < 0)
    return;
  PointerTools& pointer = app.tools().pointer;
  const bool other = app.comparison().isAt(input.mouseX, input.width);
  ViewerDocument& document = other ? *app.comparison().document() : app.document();
  const auto probe = other ? pointer.probeOther(document, input.mouseX, input.mouseY)
                           : pointer.probeAt(input.mouseX, input.mouseY);
  if (!probe)
    return;
  ImGui::BeginTooltip();
  if (app.comparison().active() && document.info())
    ImGui::TextUnformatted(
        std::filesystem::path(document.info()->path).filename().string().c_str());
  const Vec3& p = probe->place;
  ImGui::TextUnformatted(fmt::format("x {}  y {}  z {} m", plainNumber(p.x(), 4),
                                     plainNumber(p.y(), 4), plainNumber(p.z(), 4))
                             .c_str());
  ImGui::TextDisabled("%s",
                      tr(probe->onSurface ? "on a surface" : "where most of the light comes from"));
  for (const auto& medium : probe->media) {
    ImGui::Separator();
    ImGui::TextUnformatted(medium.name.c_str());
    ImGui::Text(tr("extinction %.4g /m"), medium.extinction);
    const PictureLaw law = document.scene()->scene->law;
    if (medium.extinction > 0 && medium.name.starts_with("smoke"))
      ImGui::Text(tr("visibility %.3g m (C = %g)"), law.c * law.factor() / medium.extinction,
                  law.c);
    if ((medium.emission > 0).any())
      ImGui::Text(tr("light %.3g %.3g %.3g /m"), medium.emission[0], medium.emission[1],
                  medium.emission[2]);
    ImGui::Text(tr("optical depth along the ray %.4g"), medium.opticalDepth);
  }
  drawFields(app, document, *probe);
  ImGui::EndTooltip();
}

}  // namespace

void drawStage(ViewerApp& app, const ViewerInput& input) {
  const FreeArea free = freeArea(app, input);
  if (!app.settings().panels) {  // then the picture is all there is
    if (!app.view().picture().shown())
      drawProgress(app, free);
    return;
  }
  drawScaleBar(app, free, input);
  drawColorBars(app, free);
  drawBorder(app, free, input);
  drawGizmo(app, free);
  drawBadge(app, free);
  drawProgress(app, free);
  drawToast(app, free);
  drawProbe(app, input);
}

}  // namespace volute
