// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <imgui.h>

#include <cmath>

#include "volute/viewer/panels.hpp"

namespace volute {
namespace {

/// Whether the film's controls stand beside the time's; else they appear when they are asked for.
bool isWide(const ViewerInput& input) {
  return input.width >= 800;
}

bool isWhole(ViewerApp& app, const ViewerInput& input) {
  return isWide(input) || app.settings().timeOpen || app.film();
}

void filmPart(ViewerApp& app, const ViewerInput& input) {
  if (const FilmExport* film = app.film()) {
    if (ImGui::Button("Cancel film")) {
      app.cancelFilm();
      app.mark("Cancel film");
      return;
    }
    app.mark("Cancel film");
    ImGui::SameLine();
    std::string text = fmt::format("{}: {:.0f} %", film->order().target, 100 * film->share());
    if (const auto left = film->secondsLeft())
      text += fmt::format(", {:.0f} s left", std::ceil(*left));
    ImGui::ProgressBar(static_cast<float>(film->share()), {-1, 0}, text.c_str());
    return;
  }
  if (ImGui::Button("Make film"))
    app.beginFilm(input);
  app.mark("Make film");
  ImGui::SameLine();
  ImGui::SetNextItemWidth(150);
  nameBox("##film", app.settings().filmName);
  app.mark("film");
  hint("a .mp4 or .webm of the whole time range, from the current view, at this speed");
  ImGui::SameLine();
  ImGui::SetNextItemWidth(110);
  static const std::string kSizes[] = {"640 x 360", "1280 x 720", "1920 x 1080", "window"};
  choiceBox(app, "##size", "film size", kSizes, app.settings().filmSize);
}

void stepPart(ViewerApp& app) {
  Timeline& timeline = app.timeline();
  if (ImGui::Button(timeline.playing() ? "Pause###play" : "Play###play", {60, 0}))
    timeline.play(!timeline.playing());
  app.mark("Play");
  ImGui::SameLine();
  if (ImGui::Button("<"))
    timeline.step(-1);
  app.mark("<");
  hint("one frame back");
  ImGui::SameLine();
  if (ImGui::Button(">"))
    timeline.step(1);
  app.mark(">");
  hint("one frame on");
}

void speedPart(ViewerApp& app) {
  Timeline& timeline = app.timeline();
  ImGui::SetNextItemWidth(130);
  double speed = timeline.speed();
  if (sliderDouble("##speed", speed, 0.1, 10, "%.2f x speed", true))
    timeline.setSpeed(speed);
  app.mark("speed");
  ImGui::SameLine();
  ImGui::AlignTextToFramePadding();
  ImGui::Text("frame %d of %d", timeline.frame() + 1, timeline.frames());
}

void timeSlider(ViewerApp& app, float width) {
  Timeline& timeline = app.timeline();
  double time = timeline.time();
  ImGui::SetNextItemWidth(width);
  if (sliderDouble("##time", time, timeline.first(), timeline.last(), "%.2f s"))
    timeline.seek(time);
  app.mark("time");
}

}  // namespace

float timePanelHeight(ViewerApp& app, const ViewerInput& input) {
  if (!app.timeline().moves())
    return 0;
  const int rows = isWide(input) ? 2 : isWhole(app, input) ? 3 : 1;
  const ImGuiStyle& style = ImGui::GetStyle();
  return static_cast<float>(rows) * (ImGui::GetFrameHeight() + style.ItemSpacing.y) -
         style.ItemSpacing.y + 2 * style.WindowPadding.y;
}

void drawTimePanel(ViewerApp& app, const ViewerInput& input) {
  Timeline& timeline = app.timeline();
  if (!timeline.moves())
    return;
  const float height = timePanelHeight(app, input);
  ImGui::SetNextWindowPos({kPanelMargin, static_cast<float>(input.height) - height - kPanelMargin});
  ImGui::SetNextWindowSize({static_cast<float>(input.width) - 2 * kPanelMargin, height});
  app.settings().timeHeight = height;
  ImGui::Begin("Time", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoScrollbar);
  const bool wide = isWide(input), whole = isWhole(app, input);
  stepPart(app);
  if (!wide) {
    ImGui::SameLine();
    const float more = ImGui::CalcTextSize("More").x + 2 * ImGui::GetStyle().FramePadding.x;
    timeSlider(app, -more - ImGui::GetStyle().ItemSpacing.x);
    ImGui::SameLine();
    if (ImGui::Button(whole ? "Less###more" : "More###more"))
      app.settings().timeOpen = !whole;
    app.mark("More");
    hint("speed, and films");
  }
  if (whole) {
    if (wide)
      ImGui::SameLine();
    speedPart(app);
    if (wide)
      ImGui::SameLine(0, 30);
    filmPart(app, input);
  }
  if (wide)
    timeSlider(app, -1);
  ImGui::End();
}

}  // namespace volute
