// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The part of a ViewerApp that listens to keys and the mouse.
#include <imgui.h>

#include <algorithm>
#include <utility>

#include "volute/viewer/commands.hpp"
#include "volute/viewer/imgui_spellings.hpp"

namespace volute {
namespace {

/// Keys that ImGui edits text with, and goes through panels.
constexpr std::pair<Key, imgui::KeyName> kTextKeys[] = {{Key::kLeft, ImGuiKey_LeftArrow},
                                                        {Key::kRight, ImGuiKey_RightArrow},
                                                        {Key::kUp, ImGuiKey_UpArrow},
                                                        {Key::kDown, ImGuiKey_DownArrow},
                                                        {Key::kSpace, ImGuiKey_Space},
                                                        {Key::kHome, ImGuiKey_Home},
                                                        {Key::kEnd, ImGuiKey_End},
                                                        {Key::kDelete, ImGuiKey_Delete},
                                                        {Key::kBackspace, ImGuiKey_Backspace},
                                                        {Key::kEnter, ImGuiKey_Enter},
                                                        {Key::kEscape, ImGuiKey_Escape},
                                                        {Key::kA, ImGuiKey_A},
                                                        {Key::kC, ImGuiKey_C},
                                                        {Key::kV, ImGuiKey_V},
                                                        {Key::kX, ImGuiKey_X}};

}  // namespace

/// Hands the input to Dear ImGui.
void ViewerApp::feed(const ViewerInput& input) {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(input.width), static_cast<float>(input.height)};
  io.DisplayFramebufferScale = {
      static_cast<float>(input.pixelsAcross()) / static_cast<float>(std::max(input.width, 1)),
      static_cast<float>(input.pixelsDown()) / static_cast<float>(std::max(input.height, 1))};
  io.DeltaTime = static_cast<float>(std::max(input.seconds, 1e-4));
  io.MousePos = {static_cast<float>(input.mouseX), static_cast<float>(input.mouseY)};
  for (int i = 0; i < 3; ++i) io.MouseDown[i] = input.buttons[i];
  io.MouseWheel = static_cast<float>(input.wheel);
  imgui::feedAtOnce(io);
  imgui::setModifiers(io, input.shift, input.control);
  for (const auto& [key, name] : kTextKeys) {
    const bool down = input.held.contains(key) || std::ranges::count(input.pressed, key) > 0;
    imgui::setKey(io, key, name, down);
  }
  if (input.typed.empty() || input.control)
    return;
  std::string typed = input.typed;
  if (imgui::editsNumber(*ImGui::GetCurrentContext()))
    std::ranges::replace(typed, ',', '.');
  io.AddInputCharactersUTF8(typed.c_str());
}

/// Of what a panel's border cuts off, nothing can be clicked.
void ViewerWindow::mark(const std::string& name) {
  const ImVec2 from = ImGui::GetItemRectMin(), to = ImGui::GetItemRectMax();
  const ImDrawList* list = ImGui::GetWindowDrawList();
  const ImVec2 low = list->GetClipRectMin(), high = list->GetClipRectMax();
  const ControlPlace seen{std::max(from.x, low.x), std::max(from.y, low.y), std::min(to.x, high.x),
                          std::min(to.y, high.y), from.x < low.x - 1 || to.x > high.x + 1};
  if (seen.left < seen.right && seen.top < seen.bottom)
    controls_[name] = seen;
  addStop(name, ImGui::GetItemID());
}

void ViewerWindow::mark(const std::string& name, std::span<const unsigned> ids) {
  mark(name);
  for (const unsigned id : ids) addStop(name, id);
}

/// Panels and questions have "###" in their names, lists and what stands on the picture have not.
void ViewerWindow::addStop(const std::string& name, unsigned id) {
  const ImGuiContext& context = *ImGui::GetCurrentContext();
  ImGuiWindow* window = ImGui::GetCurrentWindowRead();
  if (id == 0 || std::string_view(window->Name).find("###") == std::string_view::npos ||
      imgui::lastItemIsDisabled(context))
    return;
  const ImVec2 from = ImGui::GetItemRectMin(), to = ImGui::GetItemRectMax();
  stops_.push_back({name, id, window, from.x, from.y, to.x, to.y});
  if (context.NavId == id && context.NavWindow == window && imgui::showsFocus(context))
    focused_ = name;
}

void ViewerWindow::focus(const Stop& stop) {
  ImGuiContext& context = *ImGui::GetCurrentContext();
  auto* window = static_cast<ImGuiWindow*>(stop.window);
  const ImRect at(stop.left, stop.top, stop.right, stop.bottom);
  ImRect within = at;
  within.Translate({-window->Pos.x, -window->Pos.y});
  ImGui::ClearActiveID();
  ImGui::FocusWindow(window);
  ImGui::SetNavID(stop.id, ImGuiNavLayer_Main, 0, within);
  ImGui::ScrollToBringRectIntoView(window, at);
  imgui::showFocus(context);
}

bool ViewerWindow::applyFocus() {
  const ImGuiContext& context = *ImGui::GetCurrentContext();
  std::vector<const Stop*> stops;
  const ImGuiWindow* question = ImGui::GetTopMostPopupModal();
  for (const Stop& stop : stops_) {
    if (!question || stop.window == question)
      stops.push_back(&stop);
  }
  const int steps = std::exchange(steps_, 0);
  if (steps == 0 || stops.empty())
    return false;
  const auto found = std::ranges::find_if(stops, [&](const Stop* stop) {
    return stop->id == context.NavId && stop->window == context.NavWindow;
  });
  const bool none = found == stops.end() || !imgui::showsFocus(context);
  const auto count = static_cast<int>(stops.size());
  const int next =
      none ? (steps > 0 ? 0 : count - 1) : static_cast<int>(found - stops.begin()) + steps;
  focus(*stops[static_cast<std::size_t>((next % count + count) % count)]);
  return !none && next >= count && !question;
}

/// Arrows, Space and Enter are the panels' from Tab until Escape or a click; else they are the
/// timeline's.
void ViewerApp::useKeyboard(const ViewerInput& input) {
  ImGuiIO& io = ImGui::GetIO();
  if (std::ranges::count(input.buttons, true) > 0)
    settings_.keyboard = false;
  if (settings_.keyboard)
    io.ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
  else
    io.ConfigFlags &= ~ImGuiConfigFlags_NavEnableKeyboard;
}

/// Beyond the last control a panel that is closed opens, the next one in turn.
void ViewerApp::focusPanel() {
  if (!window_.applyFocus())
    return;
  PanelLayout& layout = settings_.layout;
  constexpr SidePanel kTurn[] = {SidePanel::kPicture, SidePanel::kPaint, SidePanel::kScene};
  for (std::size_t i = 0; i < std::size(kTurn); ++i) {
    turn_ = (turn_ + 1) % std::size(kTurn);
    const bool there = kTurn[turn_] != SidePanel::kPaint || tools_.painting.tool().has();
    if (there && !layout.isOpen(kTurn[turn_]))
      return layout.set(kTurn[turn_], true);
  }
}

void ViewerApp::keys(const ViewerInput& input) {
  if (std::ranges::count(input.pressed, Key::kTab) > 0 && !input.control) {
    window_.moveFocus(input.shift ? -1 : 1);
    settings_.keyboard = settings_.panels = true;
  }
  if (leaving_.asked() || document_.files().asks()) {
    if (std::ranges::count(input.pressed, Key::kEscape) == 0)
      return;
    if (document_.files().replacing())
      document_.files().keep();
    else if (leaving_.asked())
      leaving_.stay();
    else if (document_.files().moved())
      document_.files().setMoved({});
    else
      document_.files().closeBrowser();
    return;
  }
  if (std::ranges::count(input.pressed, Key::kEscape) > 0 &&
      ImGui::GetCurrentContext()->OpenPopupStack.Size > 0)
    return ImGui::ClosePopupToLevel(0, true);  // a list or a picker
  if (ImGui::GetIO().WantTextInput)
    return;
  constexpr Key kPanels[] = {Key::kSpace, Key::kLeft, Key::kRight, Key::kUp,
                             Key::kDown,  Key::kHome, Key::kEnd,   Key::kEnter};
  for (const Key key : input.pressed) {
    const bool panels = settings_.keyboard && !input.control;
    if (panels && std::ranges::find(kPanels, key) != std::end(kPanels))
      continue;
    if (panels && key == Key::kEscape && ImGui::GetCurrentContext()->ActiveId == 0 &&
        ImGui::GetCurrentContext()->OpenPopupStack.Size == 0)
      settings_.keyboard = false;
    else if (!panels || key != Key::kEscape)
      runKey(*this, key, input);
  }
}

/// The left button paints where the pointer meets the ground.
void ViewerApp::paintInView(const ViewerInput& input) {
  const bool ours = !ImGui::GetIO().WantCaptureMouse;
  tools_.painting.tool().setTime(playback_.timeline().time());
  if (tools_.painting.tool().onPlan() && input.buttons[0])
    return;  // planPart() has the hand
  PaintHand hand;
  hand.seconds = input.seconds;
  hand.up = pointer_.y - input.mouseY;
  pointer_.strokes = input.buttons[0] && (pointer_.strokes || (ours && !pointer_.drags));
  hand.pressed = pointer_.strokes;
  const Camera camera = view_.camera().camera(input.width, input.height);
  if (ours || pointer_.strokes)
    hand.at = tools_.painting.tool().onGround(camera.ray(input.mouseX, input.mouseY));
  if (tools_.painting.tool().hold(hand))
    tools_.painting.send();
}

/// The left button puts a sign or a lamp where the pointer is. True while it is held for that.
bool ViewerApp::placeInView(const ViewerInput& input) {
  const bool presses = input.buttons[0] && !pointer_.leftHeld;
  pointer_.leftHeld = input.buttons[0];
  pointer_.placed = pointer_.placed && pointer_.leftHeld;
  const bool measures = settings_.measuring && tools_.pointer.placing().empty();
  if ((tools_.pointer.placing().empty() && !measures) || !presses ||
      ImGui::GetIO().WantCaptureMouse)
    return pointer_.placed;
  if (measures)
    tools_.pointer.measureAt(input.mouseX, input.mouseY);
  else
    tools_.pointer.putAt(input.mouseX, input.mouseY);
  return pointer_.placed = true;
}

/// The camera follows the mouse where no panel does, and the keys when it walks. While the left
/// button paints, the right one turns.
void ViewerApp::control(const ViewerInput& input) {
  const double dx = input.mouseX - pointer_.x, dy = input.mouseY - pointer_.y;
  const bool places = placeInView(input);
  const bool paints = settings_.painting && tools_.painting.tool().has() && !places &&
                      tools_.pointer.placing().empty();
  if (paints)
    paintInView(input);
  pointer_.x = input.mouseX, pointer_.y = input.mouseY;
  const bool turns = paints ? input.buttons[1] : input.buttons[0] && !places;
  const bool moves = input.buttons[2] || (!paints && input.buttons[1]);
  const bool held = turns || moves;
  const bool ours = !ImGui::GetIO().WantCaptureMouse;
  if (held && pointer_.drags && (dx != 0 || dy != 0)) {
    if (turns && !input.shift)
      view_.camera().drag(dx, dy);
    else
      view_.camera().pan(dx, dy, input.height);
    moving_ = true;
  }
  pointer_.drags = held && (pointer_.drags || ours);
  if (input.wheel != 0 && ours) {
    view_.camera().zoom(input.wheel, tools_.pointer.placeUnder(input.mouseX, input.mouseY));
    moving_ = true;
  }
  if (input.twice && ours && !paints && !places &&
      view_.camera().mode() == ViewCamera::Mode::kOrbit)
    tools_.pointer.pivotAt(input.mouseX, input.mouseY);
  walk(input);
}

void ViewerApp::walk(const ViewerInput& input) {
  if (view_.camera().mode() != ViewCamera::Mode::kWalk || input.control ||
      ImGui::GetIO().WantTextInput)
    return;
  const auto axis = [&](Key forth, Key back) {
    return double(input.held.count(forth)) - double(input.held.count(back));
  };
  const double pace = input.seconds * (input.shift ? 1.0 : 0.25) * view_.camera().distance();
  const double ahead = axis(Key::kW, Key::kS), aside = axis(Key::kD, Key::kA),
               up = axis(Key::kE, Key::kQ);
  if (ahead == 0 && aside == 0 && up == 0)
    return;
  view_.camera().walk(pace * ahead, pace * aside, pace * up);
  moving_ = true;
}

}  // namespace volute
