// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The part of a ViewerApp that listens to keys and the mouse.
#include <imgui.h>

#include <algorithm>
#include <utility>

#include "volute/viewer/viewer_app.hpp"

namespace volute {

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
  io.KeyShift = input.shift;
  io.KeyCtrl = input.control;
  std::ranges::fill(io.KeysDown, false);
  for (const Key key : input.held) io.KeysDown[static_cast<int>(key)] = true;
  for (const Key key : input.pressed) io.KeysDown[static_cast<int>(key)] = true;
  if (!input.typed.empty() && !input.control)
    io.AddInputCharactersUTF8(input.typed.c_str());
}

/// Of what a panel's border cuts off, nothing can be clicked.
void ViewerApp::mark(const std::string& name) {
  const ImVec2 from = ImGui::GetItemRectMin(), to = ImGui::GetItemRectMax();
  const ImDrawList* list = ImGui::GetWindowDrawList();
  const ImVec2 low = list->GetClipRectMin(), high = list->GetClipRectMax();
  const ControlPlace seen{std::max(from.x, low.x), std::max(from.y, low.y), std::min(to.x, high.x),
                          std::min(to.y, high.y), from.x < low.x - 1 || to.x > high.x + 1};
  if (seen.left < seen.right && seen.top < seen.bottom)
    controls_[name] = seen;
}

void ViewerApp::press(Key key, const ViewerInput& input) {
  switch (key) {
    case Key::kSpace:
      timeline_.play(!timeline_.playing());
      break;
    case Key::kLeft:
      timeline_.step(-1);
      break;
    case Key::kRight:
      timeline_.step(1);
      break;
    case Key::kHome:
      timeline_.seek(timeline_.first());
      break;
    case Key::kEnd:
      timeline_.seek(timeline_.last());
      break;
    case Key::kPlus:
      settings_.look.stops += 0.5;
      break;
    case Key::kMinus:
      settings_.look.stops -= 0.5;
      break;
    case Key::kF1:
      settings_.help = !settings_.help;
      break;
    case Key::k1:
      lookFromAxis(-Vec3::UnitY());
      break;
    case Key::k3:
      lookFromAxis(Vec3::UnitX());
      break;
    case Key::k7:
      lookFromAxis(Vec3::UnitZ());
      break;
    case Key::kP:
      settings_.probe = !settings_.probe;
      break;
    case Key::kF11:
      fullScreenRequested_ = true;
      break;
    case Key::kF12:
      screenshotRequested_ = true;
      break;
    case Key::kH:
      settings_.panels = !settings_.panels;
      break;
    case Key::kF:
      wholeView(input.width, input.height);
      break;
    case Key::kEscape:
      settings_.help = settings_.painting = settings_.probe = false;
      placing_.clear();
      break;
    case Key::kM:
      camera_.setMode(camera_.mode() == ViewCamera::Mode::kOrbit ? ViewCamera::Mode::kWalk
                                                                 : ViewCamera::Mode::kOrbit);
      break;
    default:
      break;
  }
}

/// A stroke while fog is being painted, else what was changed of the scene, else a stroke.
void ViewerApp::undo() {
  const bool strokes = paint_.has() && paint_.painter().canUndo();
  const bool changes = document_ && document_->canUndo;
  if (strokes && (settings_.painting || !changes))
    undoPainting();
  else if (changes)
    undoChange();
}

void ViewerApp::redo() {
  const bool strokes = paint_.has() && paint_.painter().canRedo();
  const bool changes = document_ && document_->canRedo;
  if (strokes && (settings_.painting || !changes))
    redoPainting();
  else if (changes)
    redoChange();
}

void ViewerApp::keys(const ViewerInput& input) {
  if (leaving_ || files_.asks()) {
    if (std::ranges::count(input.pressed, Key::kEscape) == 0)
      return;
    if (files_.replacing())
      files_.keep();
    else if (leaving_)
      stay();
    else
      files_.closeBrowser();
    return;
  }
  if (ImGui::GetIO().WantTextInput)
    return;
  for (const Key key : input.pressed) {
    if (!input.control)
      press(key, input);
    else if (key == Key::kZ)
      input.shift ? redo() : undo();
    else if (key == Key::kY)
      redo();
    else if (key == Key::kS)
      saveScene();
    else if (key == Key::kO)
      askToOpen();
    else if (key == Key::kC)
      copyCamera();
  }
}

/// The left button paints where the pointer meets the ground.
void ViewerApp::paintInView(const ViewerInput& input) {
  const bool ours = !ImGui::GetIO().WantCaptureMouse;
  PaintHand hand;
  hand.seconds = input.seconds;
  hand.up = pointer_.y - input.mouseY;
  pointer_.strokes = input.buttons[0] && (pointer_.strokes || (ours && !pointer_.drags));
  hand.pressed = pointer_.strokes;
  const Camera camera = camera_.camera(input.width, input.height);
  if (ours || pointer_.strokes)
    hand.at = paint_.onGround(camera.ray(input.mouseX, input.mouseY));
  paint_.setTime(timeline_.time());
  if (paint_.hold(hand))
    sendMap();
}

/// The left button puts a sign or a lamp where the pointer is. True while it is held for that.
bool ViewerApp::placeInView(const ViewerInput& input) {
  const bool presses = input.buttons[0] && !pointer_.leftHeld;
  pointer_.leftHeld = input.buttons[0];
  pointer_.placed = pointer_.placed && pointer_.leftHeld;
  if (placing_.empty() || !presses || ImGui::GetIO().WantCaptureMouse)
    return pointer_.placed;
  const Camera camera = camera_.camera(input.width, input.height);
  const WallPlace at = placeAlong(camera.ray(input.mouseX, input.mouseY));
  edit({.kind = SceneEdit::Kind::kPlace,
        .path = std::exchange(placing_, ""),
        .position = at.position,
        .normal = at.normal});
  return pointer_.placed = true;
}

/// The camera follows the mouse where no panel does, and the keys when it walks. While the left
/// button paints, the right one turns.
void ViewerApp::control(const ViewerInput& input) {
  const double dx = input.mouseX - pointer_.x, dy = input.mouseY - pointer_.y;
  const bool places = placeInView(input);
  const bool paints = settings_.painting && paint_.has() && !places && placing_.empty();
  if (paints)
    paintInView(input);
  pointer_.x = input.mouseX, pointer_.y = input.mouseY;
  const bool turns = paints ? input.buttons[1] : input.buttons[0] && !places;
  const bool moves = input.buttons[2] || (!paints && input.buttons[1]);
  const bool held = turns || moves;
  const bool ours = !ImGui::GetIO().WantCaptureMouse;
  if (held && pointer_.drags && (dx != 0 || dy != 0)) {
    if (turns && !input.shift)
      camera_.drag(dx, dy);
    else
      camera_.pan(dx, dy, input.height);
    moving_ = true;
  }
  pointer_.drags = held && (pointer_.drags || ours);
  if (input.wheel != 0 && ours) {
    camera_.zoom(input.wheel, placeUnder(input.mouseX, input.mouseY));
    moving_ = true;
  }
  if (input.twice && ours && !paints && !places && camera_.mode() == ViewCamera::Mode::kOrbit)
    pivotAt(input.mouseX, input.mouseY);
  walk(input);
}

void ViewerApp::walk(const ViewerInput& input) {
  if (camera_.mode() != ViewCamera::Mode::kWalk || input.control || ImGui::GetIO().WantTextInput)
    return;
  const auto axis = [&](Key forth, Key back) {
    return double(input.held.count(forth)) - double(input.held.count(back));
  };
  const double pace = input.seconds * (input.shift ? 1.0 : 0.25) * camera_.distance();
  const double ahead = axis(Key::kW, Key::kS), aside = axis(Key::kD, Key::kA),
               up = axis(Key::kE, Key::kQ);
  if (ahead == 0 && aside == 0 && up == 0)
    return;
  camera_.walk(pace * ahead, pace * aside, pace * up);
  moving_ = true;
}

}  // namespace volute
