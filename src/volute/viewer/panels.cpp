// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <imgui.h>

#include <algorithm>
#include <filesystem>

#include "volute/viewer/viewer_app.hpp"

namespace volute {
namespace {

constexpr float kMargin = 10;
constexpr float kWidth = 300;

void text(const std::string& line) {
  ImGui::TextUnformatted(line.c_str());
}

void documentPart(const ViewerApp& app) {
  if (const DocumentInfo* document = app.document()) {
    ImGui::PushTextWrapPos(0);
    text(document->title);
    for (const std::string& remark : document->remarks) ImGui::TextDisabled("%s", remark.c_str());
    ImGui::PopTextWrapPos();
  }
  if (app.loading().busy) {
    const double share = app.loading().share;
    ImGui::ProgressBar(share < 0 ? 0.0F : static_cast<float>(share), {-1, 0},
                       share < 0 ? app.loading().stage.c_str() : nullptr);
  }
  if (!app.error().empty()) {
    ImGui::PushTextWrapPos(0);
    ImGui::TextColored({1, 0.5F, 0.4F, 1}, "%s", app.error().c_str());
    ImGui::PopTextWrapPos();
  }
  if (!app.message().empty())
    text(app.message());
}

void picturePart(ViewerApp& app, const ViewerInput& input) {
  ViewerSettings& settings = app.settings();
  auto stops = static_cast<float>(settings.stops);
  if (ImGui::SliderFloat("exposure", &stops, -8, 8, "%+.1f stops"))
    settings.stops = stops;
  if (app.document() && app.document()->grey)
    ImGui::Combo("colours", &settings.map, "grey\0viridis\0inferno\0");
  int quality = static_cast<int>(settings.quality);
  if (ImGui::Combo("quality", &quality, "automatic\0full\0half\0quarter\0"))
    settings.quality = static_cast<Quality>(quality);
  auto fov = static_cast<float>(app.camera().fov());
  if (ImGui::SliderFloat("view", &fov, 10, 120, "%.0f degrees"))
    app.camera().setFov(fov);
  int mode = static_cast<int>(app.camera().mode());
  if (ImGui::Combo("camera", &mode, "orbit\0walk\0"))
    app.camera().setMode(static_cast<ViewCamera::Mode>(mode));
  if (ImGui::Button("Whole view"))
    app.resetView(input.width, input.height);
}

void timesPart(const ViewerApp& app) {
  const FrameTimes& times = app.times();
  if (times.history.empty())
    return;
  const std::string now =
      fmt::format("{:.1f} ms, {} x {}", times.milliseconds, times.width, times.height);
  const float most = *std::ranges::max_element(times.history);
  ImGui::PlotLines("##times", times.history.data(), static_cast<int>(times.history.size()), 0,
                   now.c_str(), 0, 1.1F * most, {-1, 48});
  ImGui::TextDisabled("%s", app.device().renderer.c_str());
}

void timelinePanel(ViewerApp& app, const ViewerInput& input) {
  Timeline& timeline = app.timeline();
  if (!timeline.moves())
    return;
  const float height = 66;
  ImGui::SetNextWindowPos({kMargin, static_cast<float>(input.height) - height - kMargin});
  ImGui::SetNextWindowSize({static_cast<float>(input.width) - 2 * kMargin, height});
  ImGui::Begin("Time", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove);
  if (ImGui::Button(timeline.playing() ? "Pause" : "Play", {60, 0}))
    timeline.play(!timeline.playing());
  ImGui::SameLine();
  if (ImGui::Button("<"))
    timeline.step(-1);
  ImGui::SameLine();
  if (ImGui::Button(">"))
    timeline.step(1);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(150);
  auto speed = static_cast<float>(timeline.speed());
  if (ImGui::SliderFloat("##speed", &speed, 0.1F, 4, "%.2f x speed", ImGuiSliderFlags_Logarithmic))
    timeline.setSpeed(speed);
  ImGui::SameLine();
  text(fmt::format("frame {} of {}", timeline.frame() + 1, timeline.frames()));
  auto time = static_cast<float>(timeline.time());
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##time", &time, static_cast<float>(timeline.first()),
                         static_cast<float>(timeline.last()), "%.2f s"))
    timeline.seek(time);
  ImGui::End();
}

void helpPanel(ViewerApp& app, const ViewerInput& input) {
  if (!app.settings().help)
    return;
  ImGui::SetNextWindowPos(
      {0.5F * static_cast<float>(input.width), 0.45F * static_cast<float>(input.height)}, 0,
      {0.5F, 0.5F});
  ImGui::Begin("Help", &app.settings().help,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse);
  constexpr const char* kLines[][2] = {{"left mouse", "turn"},
                                       {"right mouse, Shift", "move across"},
                                       {"wheel", "nearer, farther"},
                                       {"M", "orbit or walk"},
                                       {"W A S D, Q E", "walk, down and up"},
                                       {"F", "see all"},
                                       {"Space", "play"},
                                       {"Left, Right", "one frame"},
                                       {"Home, End", "first, last frame"},
                                       {"+  -", "exposure"},
                                       {"F12", "screenshot"},
                                       {"H", "hide the panels"},
                                       {"F1", "this"},
                                       {"drop a file", "open it"}};
  for (const auto& [keys, meaning] : kLines) {
    ImGui::TextDisabled("%s", keys);
    ImGui::SameLine(170);
    ImGui::TextUnformatted(meaning);
  }
  ImGui::End();
}

}  // namespace

void drawPanels(ViewerApp& app, const ViewerInput& input) {
  helpPanel(app, input);
  if (!app.settings().panels)
    return;
  ImGui::SetNextWindowPos({kMargin, kMargin}, ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSize({kWidth, 0});
  ImGui::Begin("Volute", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
  documentPart(app);
  ImGui::Separator();
  picturePart(app, input);
  ImGui::Separator();
  timesPart(app);
  ImGui::TextDisabled("F1: help");
  ImGui::End();
  timelinePanel(app, input);
}

}  // namespace volute
