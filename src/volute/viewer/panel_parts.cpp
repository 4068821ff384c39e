// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <imgui.h>

#include <algorithm>
#include <array>

#include "volute/viewer/panels.hpp"

namespace volute {

void styleControls() {
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 6;
  style.FrameRounding = 3;
  style.GrabRounding = 3;
  style.WindowPadding = {10, 10};
  style.ItemSpacing = {8, 5};
  style.WindowBorderSize = 0;
  ImVec4* colors = style.Colors;
  const ImVec4 accent{0.13F, 0.44F, 0.48F, 1}, bright{0.21F, 0.60F, 0.58F, 1};
  colors[ImGuiCol_WindowBg] = {0.09F, 0.10F, 0.12F, 0.96F};
  colors[ImGuiCol_TitleBg] = colors[ImGuiCol_TitleBgActive] = {0.13F, 0.15F, 0.18F, 1};
  colors[ImGuiCol_TitleBgCollapsed] = {0.13F, 0.15F, 0.18F, 0.8F};
  colors[ImGuiCol_FrameBg] = {0.18F, 0.20F, 0.24F, 1};
  colors[ImGuiCol_FrameBgHovered] = {0.23F, 0.26F, 0.31F, 1};
  colors[ImGuiCol_FrameBgActive] = {0.26F, 0.30F, 0.36F, 1};
  colors[ImGuiCol_Header] = {0.17F, 0.20F, 0.24F, 1};
  colors[ImGuiCol_Button] = colors[ImGuiCol_HeaderHovered] = accent;
  colors[ImGuiCol_ButtonHovered] = colors[ImGuiCol_HeaderActive] = bright;
  colors[ImGuiCol_ButtonActive] = {0.25F, 0.68F, 0.65F, 1};
  colors[ImGuiCol_CheckMark] = {0.36F, 0.78F, 0.70F, 1};
  colors[ImGuiCol_SliderGrab] = {0.16F, 0.50F, 0.50F, 1};  // numbers are read on them
  colors[ImGuiCol_SliderGrabActive] = {0.55F, 0.45F, 0.05F, 1};
  colors[ImGuiCol_PlotLines] = colors[ImGuiCol_PlotHistogram] = {0.36F, 0.78F, 0.70F, 1};
}

void wrappedText(const std::string& text, bool faint) {
  ImGui::PushTextWrapPos(0);
  if (faint)
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
  ImGui::TextUnformatted(text.c_str());
  if (faint)
    ImGui::PopStyleColor();
  ImGui::PopTextWrapPos();
}

bool sliderDouble(const char* label, double& value, double least, double most, const char* format,
                  bool logarithmic) {
  const ImGuiSliderFlags flags = (logarithmic ? ImGuiSliderFlags_Logarithmic : 0) |
                                 ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoRoundToFormat;
  return ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &least, &most, format, flags);
}

bool markedButton(ViewerApp& app, const char* label, const std::string& mark, bool enabled) {
  ImGui::BeginDisabled(!enabled);
  const bool pressed = ImGui::Button(label);
  ImGui::EndDisabled();
  app.mark(mark);
  return pressed;
}

bool nameBox(const char* label, std::string& name) {
  std::array<char, 1024> text{};
  std::copy_n(name.begin(), std::min(name.size(), text.size() - 1), text.begin());
  if (!ImGui::InputText(label, text.data(), text.size(), ImGuiInputTextFlags_AutoSelectAll))
    return false;
  name = text.data();
  return true;
}

bool choiceBox(ViewerApp& app, const char* label, const std::string& mark,
               std::span<const std::string> choices, int& chosen) {
  const bool open = ImGui::BeginCombo(label, choices[static_cast<std::size_t>(chosen)].c_str());
  app.mark(mark);
  if (!open)
    return false;
  bool moved = false;
  for (int i = 0; i < static_cast<int>(choices.size()); ++i) {
    const std::string& choice = choices[static_cast<std::size_t>(i)];
    if (ImGui::Selectable(choice.c_str(), i == chosen)) {
      moved = i != chosen;
      chosen = i;
    }
    app.mark(mark + " = " + choice);
  }
  ImGui::EndCombo();
  return moved;
}

void hint(const std::string& text) {
  if (!text.empty() && ImGui::IsItemHovered() && !ImGui::IsItemActive())
    ImGui::SetTooltip("%s", text.c_str());
}

}  // namespace volute
