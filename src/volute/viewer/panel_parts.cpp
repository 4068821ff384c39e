// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "volute/image/text.hpp"
#include "volute/viewer/imgui_spellings.hpp"
#include "volute/viewer/panels.hpp"

namespace volute {

void useFont(double scale) {
  constexpr float kPoints = 14;
  // Latin with all its accents, Greek, Cyrillic, dashes and quotes, arrows, mathematics.
  static const ImWchar kLetters[] = {0x20,   0x24F,  0x2B0,  0x3FF,  0x400,  0x52F,  0x1E00,
                                     0x1EFF, 0x2010, 0x205E, 0x2070, 0x209F, 0x20A0, 0x20BF,
                                     0x2190, 0x21FF, 0x2200, 0x22FF, 0};
  ImFontAtlas* fonts = ImGui::GetIO().Fonts;
#if VOLUTE_HAS_FREETYPE
  imgui::useFreeType(*fonts);
#endif
  fonts->Clear();
  const float size = std::round(kPoints * static_cast<float>(scale));
  const auto file = fontFile(Typeface::kSans);
  const bool found = file && fonts->AddFontFromFileTTF(file->c_str(), size, nullptr, kLetters);
  if (!found)
    fonts->AddFontDefault();
  imgui::setFontScale(found ? kPoints / size : 1);
}

void styleControls() {
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.Colors[ImGuiCol_ModalWindowDimBg] = {0, 0, 0, 0.5F};
  style.WindowRounding = 6;
  style.FrameRounding = 3;
  style.GrabRounding = 3;
  style.WindowPadding = {10, 10};
  style.ItemSpacing = {8, 5};
  style.WindowBorderSize = 0;
  ImVec4* colors = style.Colors;
  const ImVec4 accent{0.13F, 0.44F, 0.48F, 1}, bright{0.21F, 0.60F, 0.58F, 1};
  colors[ImGuiCol_WindowBg] = {0.09F, 0.10F, 0.12F, 0.96F};
  colors[ImGuiCol_PopupBg] = {0.09F, 0.10F, 0.12F, 1};
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

std::string inLines(const std::string& text, float wide) {
  std::string lines;
  std::size_t line = 0;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const bool fits =
        begin == 0 || ImGui::CalcTextSize((lines.substr(line) + " " + word).c_str()).x <= wide;
    if (begin > 0)
      lines += fits ? ' ' : '\n';
    if (!fits)
      line = lines.size();
    lines += word;
    begin = end + 1;
  }
  return lines;
}

float contentRight() {
  return ImGui::GetCursorPosX() + ImGui::GetContentRegionAvail().x;
}

void wrappedText(const std::string& text, bool faint) {
  ImGui::PushTextWrapPos(0);
  if (faint)
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
  ImGui::TextUnformatted(inLines(text, ImGui::GetContentRegionAvail().x).c_str());
  if (faint)
    ImGui::PopStyleColor();
  ImGui::PopTextWrapPos();
}

bool sliderDouble(const char* label, double& value, double least, double most, const char* format,
                  bool logarithmic) {
  const ImGuiSliderFlags flags = (logarithmic ? ImGuiSliderFlags_Logarithmic : 0) |
                                 ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoRoundToFormat;
  return ImGui::SliderScalar(tr(std::string(label)).c_str(), ImGuiDataType_Double, &value, &least,
                             &most, trName(format).c_str(), flags);
}

bool markedButton(ViewerApp& app, const char* label, const std::string& mark, bool enabled) {
  ImGui::BeginDisabled(!enabled);
  const bool pressed = ImGui::Button(tr(std::string(label)).c_str());
  ImGui::EndDisabled();
  app.window().mark(mark);
  return pressed;
}

namespace {

/// Over a box that was drawn last, and whose text is longer than it: the text's end.
void showEnd(const std::string& text) {
  const ImVec2 from = ImGui::GetItemRectMin(), to = ImGui::GetItemRectMax();
  const ImGuiStyle& style = ImGui::GetStyle();
  const std::string end = shortened(text, lettersIn(to.x - from.x - 2 * style.FramePadding.x));
  if (end == text)
    return;
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled(from, to, ImGui::GetColorU32(ImGuiCol_FrameBg), style.FrameRounding);
  list->AddText({from.x + style.FramePadding.x, from.y + style.FramePadding.y},
                ImGui::GetColorU32(ImGuiCol_Text), end.c_str());
}

}  // namespace

std::string shortened(const std::string& path, std::size_t letters) {
  constexpr std::size_t kDots = 3;
  const auto begins = [](char byte) { return (byte & 0xC0) != 0x80; };  // a letter of UTF-8
  if (static_cast<std::size_t>(std::ranges::count_if(path, begins)) <= letters)
    return path;
  std::size_t at = path.size();
  for (std::size_t kept = 0; kept + kDots < letters && at > 0;) kept += begins(path[--at]);
  const std::size_t folder = path.find('/', at);
  const bool whole = folder != std::string::npos && folder + 1 < path.size();
  return "..." + path.substr(whole ? folder : at);
}

std::size_t lettersIn(float width) {
  constexpr const char* kUsual = "fire smoke 0123_.v";  // letters are not as wide as each other
  const float each = ImGui::CalcTextSize(kUsual).x / static_cast<float>(std::strlen(kUsual));
  return static_cast<std::size_t>(std::max(width, 0.0F) / each);
}

bool nameBox(const char* label, std::string& name) {
  std::array<char, 1024> text{};
  std::copy_n(name.begin(), std::min(name.size(), text.size() - 1), text.begin());
  const bool edited =
      ImGui::InputText(label, text.data(), text.size(), ImGuiInputTextFlags_AutoSelectAll);
  if (!ImGui::IsItemActive())
    showEnd(name);
  hint(name);
  if (!edited)
    return false;
  name = text.data();
  return true;
}

bool choiceBox(ViewerApp& app, const char* label, const std::string& mark,
               std::span<const std::string> choices, int& chosen) {
  const std::string& shown = choices[static_cast<std::size_t>(chosen)];
  const bool open = ImGui::BeginCombo(tr(std::string(label)).c_str(), trName(shown).c_str());
  app.window().mark(mark);
  if (!open)
    return false;
  bool moved = false;
  for (int i = 0; i < static_cast<int>(choices.size()); ++i) {
    const std::string& choice = choices[static_cast<std::size_t>(i)];
    if (ImGui::Selectable(trName(choice).c_str(), i == chosen)) {
      moved = i != chosen;
      chosen = i;
    }
    app.window().mark(mark + " = " + choice);
  }
  ImGui::EndCombo();
  return moved;
}

void hint(const char* text) {
  hint(std::string(*text ? tr(text) : ""));
}

void hint(const std::string& text) {
  const std::string said = text.empty() ? "" : trName(text);
  if (text.empty() || !ImGui::IsItemHovered() || ImGui::IsItemActive())
    return;
  constexpr float kLetters = 36;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(kLetters * ImGui::GetFontSize());
  ImGui::TextUnformatted(said.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

}  // namespace volute
