// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Help inside the window: what the mouse and the keys do, and a search over all commands.
#include <imgui.h>

#include <algorithm>

#include "volute/viewer/commands.hpp"
#include "volute/viewer/panels.hpp"

namespace volute {
namespace {

using Line = std::pair<std::string, std::string>;

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
  for (auto& [keys, does] : lines) keys = trName(keys), does = tr(does);
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
  ImGui::Begin(tr("Help"), &app.settings().help, kInTheMiddle);
  // In as few columns as are low enough.
  const std::vector<Line> lines = helpLines();
  constexpr float kGap = 2;
  const ImVec2 padding = ImGui::GetStyle().WindowPadding;
  const float across = window.x - 2 * (kPanelMargin + padding.x);
  const float room = window.y - 2 * (kPanelMargin + padding.y) - ImGui::GetFrameHeight();
  std::size_t columns = 0, rows = 0;
  float wide = 0, keysWide = 0, high = 0;
  const auto heightOf = [&](const Line& line) {
    const float wrap = wide - keysWide - 10;
    const float keys = ImGui::CalcTextSize(line.first.c_str(), nullptr, false, keysWide - 6).y;
    return std::max(keys, ImGui::CalcTextSize(line.second.c_str(), nullptr, false, wrap).y) + kGap;
  };
  do {
    ++columns;
    wide = std::min(across / static_cast<float>(columns), 480.0F);
    keysWide = std::min(165.0F, 0.33F * wide);
    rows = (lines.size() + columns - 1) / columns;
    high = 0;
    for (std::size_t begin = 0; begin < lines.size(); begin += rows) {
      float sum = 0;
      for (std::size_t i = begin; i < std::min(begin + rows, lines.size()); ++i)
        sum += heightOf(lines[i]);
      high = std::max(high, sum);
    }
  } while (high > room && columns < 4);
  const ImVec2 begin = ImGui::GetCursorPos();
  float y = begin.y;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const float x = begin.x + static_cast<float>(i / rows) * wide;
    if (i % rows == 0)
      y = begin.y;
    ImGui::SetCursorPos({x, y});
    ImGui::PushTextWrapPos(x + keysWide - 6);
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    ImGui::TextUnformatted(lines[i].first.c_str());
    ImGui::PopStyleColor();
    ImGui::PopTextWrapPos();
    ImGui::SetCursorPos({x + keysWide, y});
    ImGui::PushTextWrapPos(x + wide - 10);
    ImGui::TextUnformatted(lines[i].second.c_str());
    ImGui::PopTextWrapPos();
    y += heightOf(lines[i]);
  }
  ImGui::SetCursorPos(begin);
  ImGui::Dummy({static_cast<float>(columns) * wide, high});
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
  ImGui::Begin(tr("Search"), &settings.search, kInTheMiddle);
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
    if (ImGui::Selectable(tr(command.name)))
      chosen = &command;
    app.window().mark(std::string("command ") + command.name);
    const float keys = ImGui::CalcTextSize(trName(command.keys).c_str()).x;
    ImGui::SameLine(contentRight() - keys);
    ImGui::TextDisabled("%s", trName(command.keys).c_str());
  }
  if (!first)
    wrappedText(tr("no command has these words"), true);
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
