// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// How files get into the viewer, and changes out of it: the empty window, the list of files, and
// the questions before something is lost.
#include <imgui.h>

#include <algorithm>

#include "volute/viewer/imgui_spellings.hpp"
#include "volute/viewer/panels.hpp"

namespace volute {
namespace {

constexpr ImGuiWindowFlags kCard = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                   ImGuiWindowFlags_NoSavedSettings |
                                   ImGuiWindowFlags_AlwaysAutoResize;

ImVec2 middleOf(const ViewerInput& input, float down) {
  return {0.5F * static_cast<float>(input.width), down * static_cast<float>(input.height)};
}

/// Centred, as wide as `wide` where the window is; opens where `asked`.
bool beginQuestion(const std::string& title, bool asked, const ViewerInput& input, float wide) {
  if (asked && !ImGui::IsPopupOpen(title.c_str()))
    ImGui::OpenPopup(title.c_str());
  ImGui::SetNextWindowPos(middleOf(input, 0.4F), 0, {0.5F, 0.5F});
  const float width = std::min(wide, static_cast<float>(input.width) - 2 * kPanelMargin);
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, 1e4F});
  return ImGui::BeginPopupModal(title.c_str(), nullptr,
                                ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoSavedSettings);
}

void endQuestion(bool asked) {
  if (!asked)
    ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

void errorText(const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, kFailure);
  wrappedText(text);
  ImGui::PopStyleColor();
}

std::string nameOf(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

/// @param path  not the list's own, which closes
void chooseFile(ViewerApp& app, const std::filesystem::path& path) {
  app.document().files().closeBrowser();
  app.takeFile(path.string());
}

/// Scenes that a viewer had when it ended without asking.
void lostPart(ViewerApp& app) {
  const auto all = app.recovery().lost();
  if (all.empty())
    return;
  ImGui::Spacing();
  wrappedText(tr("Scenes with changes that were not saved when the viewer ended:"));
  for (std::size_t i = 0; i < std::min<std::size_t>(all.size(), 4); ++i) {
    const std::string number = fmt::format("{}", i);
    if (markedButton(app, ("Restore###restore" + number).c_str(), "restore " + number))
      app.leaving().leaveFor(all[i].scene.string());
    ImGui::SameLine();
    if (markedButton(app, ("Discard###discard" + number).c_str(), "discard " + number))
      Recovery::remove(all[i]);
    ImGui::SameLine();
    ImGui::TextUnformatted(nameOf(all[i].name).c_str());
    hint(all[i].name);
  }
}

}  // namespace

/// What to do where nothing is open.
void drawEmptyWindow(ViewerApp& app, const ViewerInput& input) {
  const bool asks = ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup);
  if (app.document().info() || app.document().loading().busy || app.view().picture().shown() ||
      asks)
    return;
  constexpr float kWide = 420;
  const float width = std::min(kWide, static_cast<float>(input.width) - 2 * kPanelMargin);
  ImGui::SetNextWindowPos(middleOf(input, 0.45F), 0, {0.5F, 0.5F});
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, 1e4F});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {24, 22});
  ImGui::Begin("Welcome", nullptr, kCard);
  ImGui::TextUnformatted(tr("Fire, smoke and fog"));
  ImGui::Spacing();
  if (!app.document().error().empty()) {
    errorText(app.document().error());
    ImGui::Spacing();
  }
  wrappedText(tr("Drop a file here, or open one: a .volute, .vdb or .npy volume, a scene .json, a "
                 "map of fog "
                 "(.png), smoke on a mesh (.pvd, .vtu), a case of FDS (.smv), a capture."),
              true);
  ImGui::Spacing();
  if (ImGui::Button(tr("Open a file   Ctrl O"), {-1, 34}))
    app.document().files().askToOpen();
  app.window().mark("Open a file");
  lostPart(app);
  const auto recent = app.document().files().recent().names();  // it changes when one is opened
  if (!recent.empty()) {
    ImGui::Spacing();
    ImGui::TextDisabled("%s", tr("Recent"));
  }
  for (std::size_t i = 0; i < std::min<std::size_t>(recent.size(), 6); ++i) {
    const std::string label = fmt::format("{}###recent{}", nameOf(recent[i]), i);
    if (ImGui::Selectable(label.c_str()))
      app.leaving().leaveFor(recent[i]);
    app.window().mark(fmt::format("recent {}", i));
    hint(recent[i]);
  }
  ImGui::End();
  ImGui::PopStyleVar();
}

/// The viewer's own list of files, where the desktop has no dialog.
void drawOpenPanel(ViewerApp& app, const ViewerInput& input) {
  constexpr const char* kTitles[] = {"Open a file", "Add a file", "Compare with a file",
                                     "Find the file"};
  const auto purpose = static_cast<std::size_t>(app.document().files().purpose());
  const std::string kTitle = tr(kTitles[purpose]) + std::string("###open a file");
  DocumentFiles::Browser* browser = app.document().files().browser();
  if (!beginQuestion(kTitle, browser, input, 560))
    return;
  if (browser) {
    wrappedText(browser->folder.string(), true);
    const float high = std::clamp(0.5F * static_cast<float>(input.height), 80.0F, 420.0F);
    ImGui::BeginChild("##entries", {-1, high}, true);
    std::optional<std::filesystem::path> folder;
    std::optional<std::string> chosen;
    if (ImGui::Selectable("..", false, imgui::kKeepsPopup))
      folder = browser->folder.parent_path();
    app.window().mark("folder above");
    for (const FolderEntry& entry : browser->entries) {
      const bool plain = !entry.folder && !entry.known;
      if (plain)
        ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
      const std::string label = entry.folder ? entry.name + "/" : entry.name;
      const bool pressed =
          ImGui::Selectable(label.c_str(), browser->name == entry.name,
                            imgui::kKeepsPopup | ImGuiSelectableFlags_AllowDoubleClick);
      app.window().mark("entry = " + entry.name);
      if (plain)
        ImGui::PopStyleColor();
      if (!pressed)
        continue;
      if (entry.folder)
        folder = browser->folder / entry.name;
      else if (ImGui::IsMouseDoubleClicked(0))
        chosen = entry.name;
      else
        browser->name = entry.name;
    }
    if (browser->entries.empty())
      ImGui::TextDisabled("%s", tr("the folder is empty or cannot be read"));
    ImGui::EndChild();
    ImGui::SetNextItemWidth(-1);
    if (ImGui::IsWindowAppearing())
      ImGui::SetKeyboardFocusHere();
    nameBox("##name", browser->name);
    const bool named = ImGui::IsItemDeactivated() && imgui::isPressed(ImGuiKey_Enter);
    app.window().mark("file name");
    const bool opens = markedButton(app, "Open", "open file", !browser->name.empty()) ||
                       (named && !browser->name.empty());
    ImGui::SameLine();
    const bool whole = markedButton(app, "Open this folder", "open folder");
    hint("numbered .vdb frames, or the files of a camera calibration");
    ImGui::SameLine();
    const bool stays = markedButton(app, "Cancel", "open cancel");
    if (stays)
      app.document().files().closeBrowser();
    else if (whole)
      chooseFile(app, std::filesystem::path(browser->folder));
    else if (opens || chosen)
      chooseFile(app, browser->folder / chosen.value_or(browser->name));
    else if (folder)
      app.document().files().browse(*folder);
  }
  endQuestion(app.document().files().browser());
}

/// A question that has to be answered before anything else.
void drawLeavePanel(ViewerApp& app, const ViewerInput& input) {
  const std::string kTitle = tr("Not saved yet") + std::string("###not saved");
  if (!beginQuestion(kTitle, app.leaving().asked(), input, 420))
    return;
  if (const LeaveQuestion::Asked* leaving = app.leaving().asked()) {
    const bool map = leaving->what == LeaveQuestion::What::kMap;
    const std::string before =
        leaving->path.empty() ? tr("Before the viewer ends")
                              : fmt::format(fmt::runtime(tr("Before {} is opened")), leaving->path);
    wrappedText(
        fmt::format(fmt::runtime(tr(map ? "The painted fog is not saved. {}, save the map as"
                                        : "The scene has unsaved changes. {}, save it as")),
                    before));
    ImGui::SetNextItemWidth(-1);
    nameBox("##target", map ? app.settings().mapName : app.settings().sceneName);
    app.window().mark(map ? "leave map" : "leave scene");
    const bool enter = !app.settings().keyboard || ImGui::IsItemDeactivated();
    if (!app.document().error().empty())
      errorText(app.document().error());
    const bool waits = leaving->saving;
    const bool entered =
        enter && !waits && !ImGui::IsWindowAppearing() && imgui::isPressed(ImGuiKey_Enter, false);
    const bool saves =
        markedButton(app, waits ? "Saving" : "Save", "leave save", !waits) || entered;
    ImGui::SameLine();
    const bool discards = markedButton(app, "Discard", "leave discard", !waits);
    ImGui::SameLine();
    const bool stays = markedButton(app, "Cancel", "leave cancel");
    if (saves)
      app.leaving().save();
    else if (discards)
      app.leaving().discard();
    else if (stays)
      app.leaving().stay();
  }
  endQuestion(app.leaving().asked());
}

/// A scene's file that is not there is asked for, once there are panels: those that appear with a
/// question would lie above it.
void drawMovedPanel(ViewerApp& app, const ViewerInput& input) {
  if (ImGui::GetFrameCount() < 3)
    return;
  const std::string kTitle = tr("A file is missing") + std::string("###moved");
  if (!beginQuestion(kTitle, app.document().files().moved(), input, 460))
    return;
  if (const MovedFile* moved = app.document().files().moved()) {
    wrappedText(fmt::format(fmt::runtime(tr("{} names {}, which is not there.")),
                            nameOf(moved->scene), moved->place.string()));
    const bool finds = markedButton(app, "Find it ...", "find moved");
    hint("where it is now; others that are missing are looked for beside it");
    ImGui::SameLine();
    const bool stays = markedButton(app, "Cancel", "moved cancel");
    if (finds)
      app.document().files().findMoved();
    else if (stays)
      app.document().files().setMoved({});
  }
  endQuestion(app.document().files().moved());
}

/// Before a file that somebody else wrote is written over.
void drawReplacePanel(ViewerApp& app, const ViewerInput& input) {
  const std::string kTitle = tr("The file exists") + std::string("###file exists");
  if (!beginQuestion(kTitle, app.document().files().replacing(), input, 380))
    return;
  if (const auto* replacing = app.document().files().replacing()) {
    wrappedText(fmt::format(fmt::runtime(tr("{} is there already.")), replacing->target));
    if (!replacing->loses.empty())
      wrappedText(tr(replacing->loses));
    const bool replaces = markedButton(app, "Replace it", "replace");
    ImGui::SameLine();
    const bool keeps = markedButton(app, "Cancel", "keep");
    if (replaces)
      app.document().files().replace();
    else if (keeps)
      app.document().files().keep();
  }
  endQuestion(app.document().files().replacing());
}

}  // namespace volute
