// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/panels.hpp"

#include <imgui.h>

#include <algorithm>

#include "volute/viewer/commands.hpp"

namespace volute {
namespace {

constexpr float kLabels = 70;  ///< [pixels] that are left for names

constexpr std::size_t kFewTimes = 8;  ///< of pictures: the least that a histogram shows

/// About the file, from its name down.
std::vector<PanelNotice> noticesOf(ViewerApp& app) {
  std::vector<PanelNotice> all;
  const DocumentInfo* document = app.document().info();
  if (document)
    all.push_back({PanelNotice::Kind::kText, document->title});
  const auto remark = [&](const std::string& text) {
    all.push_back({PanelNotice::Kind::kFaint, text});
  };
  if (!app.view().picture().remark().empty())
    remark(app.view().picture().remark());
  if (document)
    std::ranges::for_each(document->remarks, remark);
  if (const ViewScene* scene = app.view().picture().scene())
    std::ranges::for_each(scene->remarks, remark);
  return all;
}

/// What may be wrong with what was done or is seen.
std::vector<PanelNotice> alertsOf(ViewerApp& app) {
  using enum PanelNotice::Kind;
  std::vector<PanelNotice> all;
  const bool welcomes = !app.document().info() && !app.view().picture().shown() &&
                        !app.document().loading().busy && !app.document().files().asks();
  for (const std::string& error :
       {welcomes ? std::string() : app.document().error(), app.playback().filmFailure(),
        app.view().toneError(),
        app.comparison().active() ? app.comparison().error() : std::string()}) {
    if (!error.empty())
      all.push_back({kError, error});
  }
  const DocumentInfo* document = app.document().info();
  const ViewScene* scene = app.view().picture().scene();
  const auto isLight = [](const Parameter& parameter) {
    return parameter.path.starts_with("/lights/");
  };
  const bool dark = document && document->editable && scene &&
                    std::ranges::none_of(document->parameters, isLight);
  const bool black = dark && scene->names.empty() && !scene->geometry.empty() &&
                     std::ranges::none_of(scene->geometry.materials(), [](const Material& of) {
                       return (of.emission > 0).any();
                     });
  if (black && !app.view().blank()) {
    all.push_back({kText, tr("surfaces are black: the scene has no light; add Ambient, a Sun or a "
                             "Lamp in the panel Scene")});
  }
  if (!app.view().blank())
    return all;
  const bool unlit = dark && std::ranges::all_of(scene->names, [](const std::string& name) {
                       return name.starts_with("smoke") || name.starts_with("fog");
                     });
  all.push_back({kText, tr(unlit ? "nothing is to be seen: the scene has no light; add Ambient, a "
                                   "Sun or a Lamp in the panel Scene, or try another time"
                                 : "nothing is to be seen: try another time, F for all of it, or "
                                   "+, which is brighter")});
  return all;
}

/// Controls stay where they are while the pointer is on its way to one of them.
bool aimsAtPanel(ViewerApp& app, const ViewerInput& input) {
  const PanelLayout& layout = app.settings().layout;
  return layout.isOpen(SidePanel::kPicture) &&
         input.mouseX < kPanelMargin + layout.width(SidePanel::kPicture) &&
         input.mouseY < kPanelMargin + app.settings().panelHeight;
}

void keepNotices(ViewerApp& app, const ViewerInput& input) {
  auto notices = noticesOf(app);
  auto& shown = app.settings().notices;
  const bool sameFile = !notices.empty() && !shown.empty() && notices.front() == shown.front();
  const bool held = app.settings().layout.still() || (sameFile && aimsAtPanel(app, input));
  if (!held)
    shown = std::move(notices);
}

void drawNotice(const PanelNotice& notice) {
  const bool error = notice.kind == PanelNotice::Kind::kError;
  if (error)
    ImGui::PushStyleColor(ImGuiCol_Text, kFailure);
  wrappedText(notice.text, notice.kind == PanelNotice::Kind::kFaint);
  if (error)
    ImGui::PopStyleColor();
}

void combo(ViewerApp& app, const char* name, int& value,
           std::initializer_list<std::string> choices) {
  choiceBox(app, name, name, std::span(choices.begin(), choices.size()), value);
}

/// OpenGL is offered where it can be chosen; a scene from another machine may say it nevertheless.
void rendererPart(ViewerApp& app) {
  int& renderer = app.settings().look.renderer;
  constexpr int kGl = static_cast<int>(ViewRenderer::kGl);
  if (app.view().picture().offersGl() || renderer == kGl)
    return combo(app, "renderer", renderer, {"automatic", "OpenGL", "CPU"});
  int chosen = renderer > kGl ? renderer - 1 : renderer;
  combo(app, "renderer", chosen, {"automatic", "CPU"});
  renderer = chosen >= kGl ? chosen + 1 : chosen;
}

/// How much of the scene is seen: an angle, or a parallel camera's height.
void viewSlider(ViewerApp& app) {
  ViewCamera& camera = app.view().camera();
  double seen = camera.ortho() > 0 ? camera.ortho() : camera.fov();
  bool parallel = camera.ortho() > 0;
  if (ImGui::Checkbox(tr("parallel"), &parallel))
    camera.toggleParallel();
  app.window().mark("parallel");
  hint("parallel rays instead of perspective: 5");
  if (camera.ortho() > 0) {
    const double size = app.document().info() ? app.document().info()->bounds.size().norm() : 1;
    if (sliderDouble("view height", seen, 0.01 * size, 3 * size, "%.3g m", true))
      camera.setOrtho(seen);
    hint("height of what is seen");
  } else {
    if (sliderDouble("view angle", seen, 10, 120, "%.0f degrees"))
      camera.setFov(seen);
    hint("vertical field of view");
  }
  app.window().mark("view");
}

/// The next button stands beside the last one, or below where there is no room.
void besideOrBelow(const char* label) {
  ImGui::SameLine();
  const float wide = ImGui::CalcTextSize(tr(label)).x + 2 * ImGui::GetStyle().FramePadding.x;
  if (ImGui::GetCursorPosX() + wide > contentRight())
    ImGui::NewLine();
}

/// What the pointer and the camera are used for, as their keys do it.
void toolsPart(ViewerApp& app, const ViewerInput& input) {
  struct Tool {
    const char *label, *says;
    Key key;
    bool on, enabled;
  };

  const ViewerSettings& settings = app.settings();
  const Tool tools[] = {
      {"Values", "all fields under the pointer, with their units: P", Key::kP, settings.probe,
       true},
      {"Measure", "a distance by two clicks: R", Key::kR, settings.measuring, true},
      {"Camera key", "the camera path goes through this view at this time: K; Ctrl K removes it",
       Key::kK, false, app.document().info()->editable}};
  for (const Tool& tool : tools) {
    besideOrBelow(tool.label);
    if (tool.on)
      ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
    const bool pressed = markedButton(app, tool.label, tool.label, tool.enabled);
    if (tool.on)
      ImGui::PopStyleColor();
    hint(tool.says);
    if (pressed)
      runKey(app, tool.key, input);
  }
}

void openAndHelp(ViewerApp& app, bool picture) {
  if (ImGui::Button(tr("Open")))
    app.document().files().askToOpen();
  app.window().mark("Open");
  hint(picture ? "another file: Ctrl O" : "a file: Ctrl O");
  if (picture) {
    besideOrBelow("Add file");
    if (markedButton(app, "Add file", "Add file", app.document().info()->editable))
      app.document().files().askToOpen(DocumentFiles::Purpose::kAdd);
    hint("another one beside what is shown, as dropping it on the window does");
    besideOrBelow("Screenshot");
    if (ImGui::Button(tr("Screenshot")))
      app.window().requestScreenshot();
    app.window().mark("Screenshot");
    besideOrBelow("Report");
    if (ImGui::Button(tr("Report")))
      app.window().requestReport();
    app.window().mark("Report");
    hint("a page with picture, settings and files: Ctrl F12");
  }
  besideOrBelow("Help");
  if (ImGui::Button(tr("Help")))
    app.settings().help = !app.settings().help;
  app.window().mark("Help");
  hint("mouse and keys: F1; a search over all commands: F3");
}

void picturePart(ViewerApp& app, const ViewerInput& input) {
  ViewLook& look = app.settings().look;
  if (!app.document().info()) {  // nothing to look at in another way
    openAndHelp(app, false);
    return;
  }
  sliderDouble("exposure", look.stops, -8, 8, "%+.1f stops");
  app.window().mark("exposure");
  if (app.document().info() && app.document().info()->grey)
    combo(app, "colours", look.colors, {"grey", "viridis", "inferno"});
  combo(app, "tone", look.tone, {"automatic", "none", "filmic", "shoulder", "ACES", "OCIO"});
  combo(app, "quality", look.quality, {"automatic", "full", "half", "quarter"});
  rendererPart(app);
  viewSlider(app);
  if (app.view().picture().scene() && app.view().picture().scene()->bare) {
    ImGui::Checkbox(tr("surfaces"), &look.surfaces);
    app.window().mark("surfaces");
    hint("walls, ground and other opaque surfaces, except signs");
  }
  int mode = static_cast<int>(app.view().camera().mode());
  combo(app, "camera", mode, {"orbit", "walk"});
  app.view().camera().setMode(static_cast<ViewCamera::Mode>(mode));
  if (ImGui::Button(tr("Whole view")))
    app.view().whole(input.width, input.height);
  app.window().mark("Whole view");
  hint("the whole scene, from outside");
  ImGui::SameLine();
  openAndHelp(app, true);
  toolsPart(app, input);
  if (!app.document().info() || !app.document().info()->startView)
    return;
  besideOrBelow("First view");
  if (ImGui::Button(tr("First view")))
    app.view().reset(input.width, input.height);
  app.window().mark("First view");
  hint("return to the first view");
}

/// Another file beside what is open.
void comparePart(ViewerApp& app) {
  Comparison& comparison = app.comparison();
  if (!app.document().info())
    return;
  ImGui::Separator();
  if (!comparison.active()) {
    if (markedButton(app, "Compare with ...", "compare"))
      app.document().files().askToOpen(DocumentFiles::Purpose::kCompare);
    hint("another file, from the same place at the same time: by a border, or the difference");
    return;
  }
  wrappedText(fmt::format(fmt::runtime(tr("compared with {}")),
                          std::filesystem::path(comparison.path()).filename().string()));
  if (const std::string remark = comparison.remark(*app.document().info()); !remark.empty())
    wrappedText(remark, true);
  int mode = static_cast<int>(comparison.mode);
  combo(app, "show", mode, {"border", "difference"});
  comparison.mode = static_cast<Comparison::Mode>(mode);
  if (comparison.mode == Comparison::Mode::kWiper) {
    sliderDouble("border", comparison.border, 0, 1, "%.2f");
    app.window().mark("border");
  } else {
    sliderDouble("up to", comparison.span, 0.001, 1, "%.3f of white", true);
    app.window().mark("up to");
    hint("the difference that has the brightest colour");
  }
  if (markedButton(app, "End comparison", "end comparison"))
    comparison.end();
}

/// The cameras of a capture.
void stationPart(ViewerApp& app) {
  if (!app.document().info() || app.document().info()->stations.empty())
    return;
  ImGui::Separator();
  ImGui::TextUnformatted(tr("look from"));
  const float right = contentRight();
  for (const ViewStation& station : app.document().info()->stations) {
    const std::string shown =
        shortened(station.name, lettersIn(right - ImGui::GetStyle().WindowPadding.x) - 1);
    const float width = ImGui::CalcTextSize(shown.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x;
    if (&station != &app.document().info()->stations.front()) {
      ImGui::SameLine();
      if (ImGui::GetCursorPosX() + width > right)
        ImGui::NewLine();
    }
    if (ImGui::Button((shown + "###" + station.name).c_str()))
      app.view().camera().set(station.view);
    hint(shown == station.name ? "" : station.name);
    app.window().mark("look from " + station.name);
  }
}

void savePart(ViewerApp& app) {
  if (!app.document().info() || app.document().info()->sceneName.empty())
    return;
  ImGui::Separator();
  ImGui::SetNextItemWidth(-1);  // names are long
  nameBox("##scene", app.settings().sceneName);
  app.window().mark("scene");
  if (ImGui::Button(tr("Save scene")))
    app.saveScene();
  app.window().mark("Save scene");
}

/// As `--stats` of `volute render` lists it.
void whoDraws(ViewerApp& app) {
  const FrameTimes& times = app.view().picture().times();
  if (times.cpu) {
    wrappedText(fmt::format(fmt::runtime(tr("by the CPU: {}")), trName(times.why)), true);
    app.window().mark("who draws");
    return;
  }
  wrappedText(fmt::format(fmt::runtime(tr("by {}")), app.view().picture().makers().device), true);
  app.window().mark("who draws");
  const bool tells =
      app.view().picture().makers().hardware;  // a rasteriser's clock looks when it has computed
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
  const FrameTimes& times = app.view().picture().times();
  if (times.history.empty())
    return;
  ImGui::Separator();
  // As high with one picture as with many.
  std::vector<float> shown(kFewTimes - std::min(kFewTimes, times.history.size()), 0.0F);
  shown.insert(shown.end(), times.history.begin(), times.history.end());
  const float most = *std::ranges::max_element(shown);
  ImGui::PlotHistogram("##times", shown.data(), static_cast<int>(shown.size()), 0, nullptr, 0,
                       1.1F * most, {ImGui::GetContentRegionAvail().x, 36});
  app.window().mark("times");
  hint("times of the last pictures");
  wrappedText(fmt::format(fmt::runtime(tr("picture in {}, {} x {} pixels")),
                          shortTime(times.milliseconds), times.width, times.height));
  wrappedText(fmt::format(fmt::runtime(tr("slowest of the last: {}")), shortTime(most)));
  whoDraws(app);
}

/// On the picture, so that no control moves: beside the panel that is open, or below the titles.
void drawAlerts(ViewerApp& app, const ViewerInput& input) {
  constexpr float kNarrow = 180;  ///< too little for a sentence
  const PanelLayout& layout = app.settings().layout;
  const auto& alerts = app.settings().alerts;
  app.settings().alertsHeight = 0;
  if (alerts.empty())
    return;
  const float title = ImGui::GetFrameHeight() + kPanelGap;
  const bool paints = app.tools().painting.tool().has();
  const SidePanel open =
      layout.isOpen(SidePanel::kPicture) ? SidePanel::kPicture : SidePanel::kPaint;
  const bool beside = layout.isOpen(open) && (open == SidePanel::kPicture || paints);
  const float left = kPanelMargin + (beside ? layout.width(open) + kPanelGap : 0);
  const float right = static_cast<float>(input.width) - kPanelMargin;
  const float between = right - layout.shownWidth(SidePanel::kScene) - kPanelGap - left;
  const bool below = !beside || between < kNarrow;
  const float top = below ? (paints && !beside ? 2 * title : title) : 0;
  const float width = std::min(layout.width(SidePanel::kPicture), below ? right - left : between);
  ImGui::SetNextWindowPos({left, kPanelMargin + top});
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, 1e4F});
  ImGui::Begin("Notices", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoInputs |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  std::ranges::for_each(alerts, drawNotice);
  app.settings().alertsHeight = top + ImGui::GetWindowHeight() + kPanelGap;
  ImGui::End();
}

}  // namespace

bool beginSidePanel(ViewerApp& app, SidePanel panel, const char* title, float left, float top) {
  PanelLayout& layout = app.settings().layout;
  const float width = layout.shownWidth(panel);
  ImGui::SetNextWindowPos({left, top});
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, layout.most(panel)});
  ImGui::SetNextWindowCollapsed(!layout.isOpen(panel));
  const std::string shown = fmt::format("{}###{}", tr(title), title);
  const bool drawn = ImGui::Begin(shown.c_str(), nullptr,
                                  ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                                      ImGuiWindowFlags_NoFocusOnAppearing);
  const bool open = !ImGui::IsWindowCollapsed();
  if (open != layout.isOpen(panel))
    layout.set(panel, open);
  app.window().mark(title, {left, top, left + width, top + ImGui::GetFrameHeight()});
  return drawn;
}

void endSidePanel(ViewerApp& app, SidePanel panel) {
  const ImGuiStyle& style = ImGui::GetStyle();
  if (app.settings().layout.isOpen(panel))
    app.settings().layout.measure(
        panel, ImGui::GetCursorPosY() - style.ItemSpacing.y + style.WindowPadding.y);
  ImGui::End();
}

namespace {

void drawSides(ViewerApp& app, const ViewerInput& input) {
  drawEmptyWindow(app, input);
  const float time = timePanelHeight(app, input);
  PanelLayout& layout = app.settings().layout;
  layout.fit(static_cast<float>(input.width), static_cast<float>(input.height),
             time > 0 ? time + kPanelGap : 0, std::ranges::count(input.buttons, true) > 0);
  keepNotices(app, input);
  app.settings().alerts = alertsOf(app);
  if (beginSidePanel(app, SidePanel::kPicture, "Volute", kPanelMargin, kPanelMargin)) {
    ImGui::PushItemWidth(-kLabels);
    std::ranges::for_each(app.settings().notices, drawNotice);
    ImGui::Separator();
    picturePart(app, input);
    stationPart(app);
    comparePart(app);
    savePart(app);
    timesPart(app);
    ImGui::PopItemWidth();
  }
  app.settings().panelHeight = ImGui::GetWindowHeight();
  const float below = layout.lowerTop(ImGui::GetWindowPos().y + ImGui::GetWindowHeight());
  endSidePanel(app, SidePanel::kPicture);
  drawParameterPanel(app, input);
  drawPaintPanel(app, input, below);
  drawAlerts(app, input);
  drawTimePanel(app, input);
}

}  // namespace

void drawPanels(ViewerApp& app, const ViewerInput& input) {
  drawOverlay(app, input);
  drawStage(app, input);
  drawHelpPanel(app, input);
  drawSearchPanel(app, input);
  if (app.settings().panels)
    drawSides(app, input);
  // Last: Dear ImGui 1.86 ends the program when a window appears after a question in one frame.
  drawOpenPanel(app, input);
  drawLeavePanel(app, input);
  drawReplacePanel(app, input);
  drawMovedPanel(app, input);
}

}  // namespace volute
