// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Help inside the window: what the mouse and the keys do, and a search over all commands.
#include <imgui.h>

#include <algorithm>

#include "volute/viewer/commands.hpp"
#include "volute/viewer/panels.hpp"

namespace volute {
namespace {

using Line = std::pair<const char*, const char*>;

std::vector<Line> helpLines() {
  std::vector<Line> lines{{"left mouse", "turn; paint while painting fog"},
                          {"right mouse", "pan; turn while painting"},
                          {"middle, Shift left", "move across"},
                          {"wheel", "zoom towards the pointer; forward while walking"},
                          {"double click", "turn around what is there"},
                          {"Ctrl click", "type a slider's number"},
                          {"a panel's title", "open or close it by its arrow"},
                          {"drop a file", "add it to what is open; with nothing open, open it"},
                          {"W A S D, Q E", "walk; down and up; with Shift faster"}};
  for (const ViewerCommand& command : viewerCommands()) {
    if (command.keys[0] != 0)
      lines.emplace_back(command.keys, command.name);
  }
  return lines;
}

constexpr ImGuiWindowFlags kInTheMiddle =
    ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse |
    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoMove;

}  // namespace

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
  ImGui::Begin("Help", &app.settings().help, kInTheMiddle);
  // In two columns where one is too high, in three where two are.
  const std::vector<Line> lines = helpLines();
  const float margins = 2 * (kPanelMargin + ImGui::GetStyle().WindowPadding.x);
  const float high = static_cast<float>(lines.size()) * ImGui::GetTextLineHeightWithSpacing();
  const float room = window.y - ImGui::GetFrameHeight() - margins;
  const std::size_t columns = high <= room ? 1 : high <= 1.6F * room || window.x < 900 ? 2 : 3;
  const float wide = (window.x - margins) / static_cast<float>(columns);
  const float keysWide = columns == 1 ? 165 : columns == 2 ? 135 : 110;
  const std::size_t column = (lines.size() + columns - 1) / columns;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i % column == 0) {
      if (i > 0) {
        ImGui::EndGroup();
        ImGui::SameLine(ImGui::GetStyle().WindowPadding.x + static_cast<float>(i / column) * wide);
      }
      ImGui::BeginGroup();
    }
    const float left = ImGui::GetCursorPosX();
    ImGui::TextDisabled("%s", lines[i].first);
    ImGui::SameLine(left + keysWide);
    ImGui::PushTextWrapPos(columns == 1 ? -1 : left + wide - ImGui::GetStyle().ItemSpacing.x);
    ImGui::TextUnformatted(lines[i].second);
    ImGui::PopTextWrapPos();
  }
  ImGui::EndGroup();
  const ImVec2 corner = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  const ControlPlace all{corner.x, corner.y, corner.x + size.x, corner.y + size.y};
  app.window().mark("help", all);
  if (ImGui::GetScrollMaxY() > 0)
    app.window().mark("help is cut", all);
  ImGui::End();
  ImGui::PopStyleVar(2);
}

void drawSearchPanel(ViewerApp& app, const ViewerInput& input) {
  ViewerSettings& settings = app.settings();
  if (!settings.search) {
    settings.sought.clear();
    return;
  }
  const float width = std::min(440.0F, static_cast<float>(input.width) - 2 * kPanelMargin);
  ImGui::SetNextWindowPos({0.5F * static_cast<float>(input.width), 60}, 0, {0.5F, 0});
  ImGui::SetNextWindowSizeConstraints(
      {width, 0}, {width, std::max(120.0F, 0.7F * static_cast<float>(input.height))});
  ImGui::SetNextWindowBgAlpha(1);
  ImGui::Begin("Search", &settings.search, kInTheMiddle);
  if (ImGui::IsWindowAppearing())
    ImGui::SetKeyboardFocusHere();
  ImGui::SetNextItemWidth(-1);
  nameBox("##sought", settings.sought);
  app.window().mark("search");
  const ViewerCommand* chosen = nullptr;
  const ViewerCommand* first = nullptr;
  for (const ViewerCommand& command : viewerCommands()) {
    if (!isFound(command, settings.sought))
      continue;
    if (!first)
      first = &command;
    if (ImGui::Selectable(command.name))
      chosen = &command;
    app.window().mark(std::string("command ") + command.name);
    const float keys = ImGui::CalcTextSize(command.keys).x;
    ImGui::SameLine(ImGui::GetContentRegionMax().x - keys);
    ImGui::TextDisabled("%s", command.keys);
  }
  if (!first)
    wrappedText("no command has these words", true);
  if (std::ranges::count(input.pressed, Key::kEnter) > 0)
    chosen = first;
  ImGui::End();
  if (std::ranges::count(input.pressed, Key::kEscape) > 0)
    settings.search = false;
  if (!chosen)
    return;
  settings.search = false;
  chosen->run(app, input);
}

}  // namespace volute
