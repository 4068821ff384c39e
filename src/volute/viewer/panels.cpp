// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/panels.hpp"

#include <imgui.h>

#include <algorithm>

namespace volute {
namespace {

constexpr float kLabels = 70;  ///< [pixels] that are left for names

constexpr std::size_t kFewTimes = 8;  ///< of pictures: the least that a histogram shows

/// What there is to say, from the file's name down.
std::vector<PanelNotice> noticesOf(const ViewerApp& app) {
  using enum PanelNotice::Kind;
  std::vector<PanelNotice> all;
  const DocumentInfo* document = app.document();
  if (document)
    all.push_back({kText, document->title, false});
  if (!app.error().empty())
    all.push_back({kError, app.error()});
  const auto remark = [&](const std::string& text) { all.push_back({kFaint, text, false}); };
  if (!app.picture().remark().empty())
    remark(app.picture().remark());
  if (document)
    std::ranges::for_each(document->remarks, remark);
  if (const ViewScene* scene = app.picture().scene())
    std::ranges::for_each(scene->remarks, remark);
  return all;
}

/// Whether one is as high as the other: but for how far progress has come.
bool asHigh(const std::vector<PanelNotice>& a, const std::vector<PanelNotice>& b) {
  return std::ranges::equal(a, b, [](const PanelNotice& one, const PanelNotice& other) {
    return one == other || (one.kind == PanelNotice::Kind::kProgress && one.kind == other.kind);
  });
}

void drawNotice(const PanelNotice& notice) {
  using enum PanelNotice::Kind;
  switch (notice.kind) {
    case kText:
    case kFaint:
      wrappedText(notice.text, notice.kind == kFaint);
      break;
    case kError:
      ImGui::PushStyleColor(ImGuiCol_Text, {1, 0.5F, 0.4F, 1});
      wrappedText(notice.text);
      ImGui::PopStyleColor();
      break;
    case kProgress:
      ImGui::ProgressBar(static_cast<float>(notice.share), {-1, 0}, notice.text.c_str());
      break;
  }
}

void combo(ViewerApp& app, const char* name, int& value,
           std::initializer_list<std::string> choices) {
  choiceBox(app, name, name, std::span(choices.begin(), choices.size()), value);
}

/// How much of the scene is seen: an angle, or a parallel camera's height.
void viewSlider(ViewerApp& app) {
  ViewCamera& camera = app.camera();
  double seen = camera.parallel() ? camera.ortho() : camera.fov();
  if (camera.parallel()) {
    const double size = app.document() ? app.document()->bounds.size().norm() : 1;
    if (sliderDouble("view", seen, 0.01 * size, 3 * size, "%.3g m high", true))
      camera.setOrtho(seen);
    hint("the scene's camera is parallel");
  } else {
    if (sliderDouble("view", seen, 10, 120, "%.0f degrees"))
      camera.setFov(seen);
    hint("vertical field of view");
  }
  app.mark("view");
}

void openAndHelp(ViewerApp& app, bool picture) {
  if (ImGui::Button("Open"))
    app.askToOpen();
  app.mark("Open");
  hint(picture ? "another file: Ctrl O" : "a file: Ctrl O");
  ImGui::SameLine();
  if (picture) {
    if (ImGui::Button("Screenshot"))
      app.requestScreenshot();
    app.mark("Screenshot");
    ImGui::SameLine();
    const float wide = ImGui::CalcTextSize("Help").x + 2 * ImGui::GetStyle().FramePadding.x;
    if (ImGui::GetCursorPosX() + wide > ImGui::GetContentRegionMax().x)
      ImGui::NewLine();
  }
  if (ImGui::Button("Help"))
    app.settings().help = !app.settings().help;
  app.mark("Help");
}

void picturePart(ViewerApp& app, const ViewerInput& input) {
  ViewLook& look = app.settings().look;
  if (!app.document()) {  // nothing to look at in another way
    openAndHelp(app, false);
    return;
  }
  sliderDouble("exposure", look.stops, -8, 8, "%+.1f stops");
  app.mark("exposure");
  if (app.document() && app.document()->grey)
    combo(app, "colours", look.colors, {"grey", "viridis", "inferno"});
  combo(app, "quality", look.quality, {"automatic", "full", "half", "quarter"});
  combo(app, "renderer", look.renderer, {"automatic", "OpenGL", "CPU"});
  viewSlider(app);
  if (app.picture().scene() && app.picture().scene()->bare) {
    ImGui::Checkbox("surfaces", &look.surfaces);
    app.mark("surfaces");
    hint("walls, ground and other opaque surfaces, except signs");
  }
  int mode = static_cast<int>(app.camera().mode());
  combo(app, "camera", mode, {"orbit", "walk"});
  app.camera().setMode(static_cast<ViewCamera::Mode>(mode));
  if (ImGui::Button("Whole view"))
    app.wholeView(input.width, input.height);
  app.mark("Whole view");
  hint("the whole scene, from outside");
  ImGui::SameLine();
  openAndHelp(app, true);
  if (!app.document() || !app.document()->startView)
    return;
  if (ImGui::Button("First view"))
    app.resetView(input.width, input.height);
  app.mark("First view");
  hint("return to the first view");
}

/// The cameras of a capture.
void stationPart(ViewerApp& app) {
  if (!app.document() || app.document()->stations.empty())
    return;
  ImGui::Separator();
  ImGui::TextUnformatted("look from");
  const float right = ImGui::GetContentRegionMax().x;
  for (const ViewStation& station : app.document()->stations) {
    const std::string shown =
        shortened(station.name, lettersIn(right - ImGui::GetStyle().WindowPadding.x) - 1);
    const float width = ImGui::CalcTextSize(shown.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x;
    if (&station != &app.document()->stations.front()) {
      ImGui::SameLine();
      if (ImGui::GetCursorPosX() + width > right)
        ImGui::NewLine();
    }
    if (ImGui::Button((shown + "###" + station.name).c_str()))
      app.lookFrom(station.view);
    hint(shown == station.name ? "" : station.name);
    app.mark("look from " + station.name);
  }
}

void savePart(ViewerApp& app) {
  if (!app.document() || app.document()->sceneName.empty())
    return;
  ImGui::Separator();
  ImGui::SetNextItemWidth(-1);  // names are long
  nameBox("##scene", app.settings().sceneName);
  app.mark("scene");
  if (ImGui::Button("Save scene"))
    app.saveScene();
  app.mark("Save scene");
}

/// As `--stats` of `volute render` lists it.
void whoDraws(ViewerApp& app) {
  const FrameTimes& times = app.times();
  if (times.cpu) {
    wrappedText("by the CPU: " + times.why, true);
    app.mark("who draws");
    return;
  }
  wrappedText("by " + app.device().renderer, true);
  app.mark("who draws");
  const bool tells = app.device().hardware;  // a rasteriser's clock looks when it has computed
  for (const GlPassTime& pass : times.passes) {
    const std::string time = tells ? fmt::format(": {:.1f} ms", pass.milliseconds) : "";
    wrappedText(fmt::format("{} {}{}", pass.name, pass.media, time), true);
  }
}

/// Of milliseconds: a line of times is never too long for the panel.
std::string shortTime(double milliseconds) {
  return milliseconds < 1000 ? fmt::format("{:.1f} ms", milliseconds)
                             : fmt::format("{:.1f} s", milliseconds / 1000);
}

void timesPart(ViewerApp& app) {
  const FrameTimes& times = app.times();
  if (times.history.empty())
    return;
  ImGui::Separator();
  // As high with one picture as with many.
  std::vector<float> shown(kFewTimes - std::min(kFewTimes, times.history.size()), 0.0F);
  shown.insert(shown.end(), times.history.begin(), times.history.end());
  const float most = *std::ranges::max_element(shown);
  ImGui::PlotHistogram("##times", shown.data(), static_cast<int>(shown.size()), 0, nullptr, 0,
                       1.1F * most, {ImGui::GetContentRegionAvail().x, 36});
  app.mark("times");
  hint("times of the last pictures");
  wrappedText(
      fmt::format("{}, {} x {} pixels", shortTime(times.milliseconds), times.width, times.height));
  wrappedText(shortTime(most) + " at most");
  whoDraws(app);
}

/// What nobody should miss while the panel that says it is closed: below the titles on the left, or
/// beside the panel that is open there.
void drawNotices(ViewerApp& app) {
  const PanelLayout& layout = app.settings().layout;
  const auto& notices = app.settings().notices;
  if (layout.isOpen(SidePanel::kPicture) || std::ranges::none_of(notices, &PanelNotice::missed))
    return;
  const float title = ImGui::GetFrameHeight() + kPanelGap;
  const bool beside = app.paint().has() && layout.isOpen(SidePanel::kPaint);
  const float left = beside ? layout.width(SidePanel::kPaint) + kPanelGap : 0;
  const float top = beside ? 0 : app.paint().has() ? 2 * title : title;
  const float width = layout.width(SidePanel::kPicture);
  ImGui::SetNextWindowPos({kPanelMargin + left, kPanelMargin + top});
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, 1e4F});
  ImGui::Begin("Notices", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoInputs);
  for (const PanelNotice& notice : notices) {
    if (notice.missed)
      drawNotice(notice);
  }
  ImGui::End();
}

}  // namespace

bool beginSidePanel(ViewerApp& app, SidePanel panel, const char* title, float left, float top) {
  PanelLayout& layout = app.settings().layout;
  const float width = layout.width(panel);
  ImGui::SetNextWindowPos({left, top});
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, layout.most(panel)});
  ImGui::SetNextWindowCollapsed(!layout.isOpen(panel));
  const bool drawn =
      ImGui::Begin(title, nullptr, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove);
  const bool open = !ImGui::IsWindowCollapsed();
  if (open != layout.isOpen(panel))
    layout.set(panel, open);
  app.markPlace(title, {left, top, left + width, top + ImGui::GetFrameHeight()});
  return drawn;
}

void endSidePanel(ViewerApp& app, SidePanel panel) {
  const ImGuiStyle& style = ImGui::GetStyle();
  if (app.settings().layout.isOpen(panel))
    app.settings().layout.measure(
        panel, ImGui::GetCursorPosY() - style.ItemSpacing.y + style.WindowPadding.y);
  ImGui::End();
}

void drawHelpPanel(ViewerApp& app, const ViewerInput& input) {
  if (!app.settings().help)
    return;
  const ImVec2 window{static_cast<float>(input.width), static_cast<float>(input.height)};
  ImGui::SetNextWindowPos({0.5F * window.x, 0.5F * window.y}, 0, {0.5F, 0.5F});
  ImGui::SetNextWindowSizeConstraints({0, 0},
                                      {window.x - 2 * kPanelMargin, window.y - 2 * kPanelMargin});
  ImGui::SetNextWindowBgAlpha(1);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1);
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {8, 2});
  ImGui::Begin("Help", &app.settings().help,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoMove);
  constexpr const char* kLines[][2] = {{"left mouse", "turn; paint while painting fog"},
                                       {"right mouse", "pan; turn while painting"},
                                       {"middle, Shift left", "move across"},
                                       {"wheel", "zoom towards the pointer; forward while walking"},
                                       {"double click", "turn around what is there"},
                                       {"M", "orbit (turn around things) or walk (turn the head)"},
                                       {"W A S D, Q E", "walk; down and up; with Shift faster"},
                                       {"F", "the whole view, from outside"},
                                       {"Space", "play, pause"},
                                       {"Left, Right", "one frame back, one on"},
                                       {"Home, End", "first, last frame"},
                                       {"+  -", "brighter, darker by half a stop"},
                                       {"Ctrl Z", "undo a change, or a stroke while painting"},
                                       {"Ctrl Y, Ctrl Shift Z", "redo"},
                                       {"Ctrl S", "save the scene"},
                                       {"Ctrl click", "type a slider's number"},
                                       {"a panel's title", "open or close it by its arrow"},
                                       {"H", "hide the panels, show them again"},
                                       {"F12", "screenshot without panels: volute_0001.png ..."},
                                       {"Ctrl C", "copy the camera, as JSON"},
                                       {"F11", "full screen"},
                                       {"1  3  7", "from the front, the right, above"},
                                       {"P", "show what is under the pointer"},
                                       {"Ctrl O", "open a file"},
                                       {"Escape", "stop painting or placing, close this"},
                                       {"F1", "open and close this"},
                                       {"drop a file", "open it"}};
  // In two columns where one is too high.
  const std::size_t lines = std::size(kLines);
  const float margins = 2 * (kPanelMargin + ImGui::GetStyle().WindowPadding.x);
  const float high = static_cast<float>(lines) * ImGui::GetTextLineHeightWithSpacing();
  const bool whole = high + ImGui::GetFrameHeight() + margins <= window.y;
  const float keysWide = whole ? 165 : 135, wide = whole ? 0 : 0.5F * (window.x - margins);
  const std::size_t column = whole ? lines : (lines + 1) / 2;
  for (std::size_t i = 0; i < lines; ++i) {
    if (i % column == 0) {
      if (i > 0) {
        ImGui::EndGroup();
        ImGui::SameLine(ImGui::GetStyle().WindowPadding.x + wide);
      }
      ImGui::BeginGroup();
    }
    const float left = ImGui::GetCursorPosX();
    ImGui::TextDisabled("%s", kLines[i][0]);
    ImGui::SameLine(left + keysWide);
    ImGui::PushTextWrapPos(whole ? -1 : left + wide - ImGui::GetStyle().ItemSpacing.x);
    ImGui::TextUnformatted(kLines[i][1]);
    ImGui::PopTextWrapPos();
  }
  ImGui::EndGroup();
  const ImVec2 corner = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  app.markPlace("help", {corner.x, corner.y, corner.x + size.x, corner.y + size.y});
  if (ImGui::GetScrollMaxY() > 0)
    app.markPlace("help is cut", {corner.x, corner.y, corner.x + size.x, corner.y + size.y});
  ImGui::End();
  ImGui::PopStyleVar(2);
}

void drawPanels(ViewerApp& app, const ViewerInput& input) {
  drawOverlay(app, input);
  drawStage(app, input);
  drawHelpPanel(app, input);
  drawOpenPanel(app, input);
  drawLeavePanel(app, input);
  drawReplacePanel(app, input);
  if (!app.settings().panels)
    return;
  drawEmptyWindow(app, input);
  const float time = timePanelHeight(app, input);
  PanelLayout& layout = app.settings().layout;
  layout.fit(static_cast<float>(input.width), static_cast<float>(input.height),
             time > 0 ? time + kPanelGap : 0, std::ranges::count(input.buttons, true) > 0);
  auto notices = noticesOf(app);
  if (!layout.still() || asHigh(notices, app.settings().notices))
    app.settings().notices = std::move(notices);
  if (beginSidePanel(app, SidePanel::kPicture, "Volute", kPanelMargin, kPanelMargin)) {
    ImGui::PushItemWidth(-kLabels);
    std::ranges::for_each(app.settings().notices, drawNotice);
    ImGui::Separator();
    picturePart(app, input);
    stationPart(app);
    savePart(app);
    timesPart(app);
    ImGui::PopItemWidth();
  }
  const float below = layout.lowerTop(ImGui::GetWindowPos().y + ImGui::GetWindowHeight());
  endSidePanel(app, SidePanel::kPicture);
  drawParameterPanel(app, input);
  drawPaintPanel(app, input, below);
  drawNotices(app);
  drawTimePanel(app, input);
}

}  // namespace volute
