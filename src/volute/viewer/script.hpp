// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "volute/viewer/headless_viewer.hpp"

namespace volute {

/// A hand that drives a viewer without a display: clicks, drags and keys through its input layer.
class ViewerScript {
 public:
  explicit ViewerScript(HeadlessViewer& viewer, int width, int height) : viewer_(viewer) {
    input_.width = width, input_.height = height;
  }

  /// Called after every frame, with the seconds that it took.
  std::function<void(double)> watch{};

  /// False if the viewer ended.
  bool frame() {
    const auto begun = std::chrono::steady_clock::now();
    const bool goes = viewer_.frame(input_).has_value();
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begun;
    if (watch)
      watch(spent.count());
    input_.pressed.clear();
    input_.typed.clear();
    input_.dropped.clear();
    input_.closes = false;
    input_.wheel = 0;
    return goes;
  }

  void frames(int count) {
    for (int i = 0; i < count; ++i) frame();
  }

  bool settle() {
    Progress quiet;
    return viewer_.settle(input_, quiet).has_value();
  }

  void press(Key key, bool control = false) {
    input_.control = control;
    input_.pressed = {key};
    frame();
    input_.control = false;
  }

  void type(const std::string& text) {
    for (const char letter : text) {
      input_.typed = letter;
      frame();
    }
  }

  void drop(const std::string& path) {
    input_.dropped = path;
    frame();
  }

  void close() {
    input_.closes = true;
    frame();
  }

  void move(double x, double y) {
    input_.mouseX = x, input_.mouseY = y;
    frames(2);
  }

  void hold(int button, bool on) {
    input_.buttons[button] = on;
    frame();
  }

  void clickAt(double x, double y, int button = 0) {
    move(x, y);
    hold(button, true);
    hold(button, false);
    frame();
  }

  /// Steadily, with the button held.
  void drag(double x0, double y0, double x1, double y1, int button = 0, int steps = 6) {
    move(x0, y0);
    hold(button, true);
    for (int i = 1; i <= steps; ++i) {
      input_.mouseX = x0 + (x1 - x0) * i / steps;
      input_.mouseY = y0 + (y1 - y0) * i / steps;
      frame();
    }
    hold(button, false);
    frame();
  }

  bool has(const std::string& control) const { return viewer_.app().controls().contains(control); }

  /// A point of a control, 0..1 from its left and its top. False if it is not there.
  bool pointOf(const std::string& control, double across, double down, double& x, double& y) const {
    const auto found = viewer_.app().controls().find(control);
    if (found == viewer_.app().controls().end())
      return false;
    const ControlPlace& at = found->second;
    x = at.left + across * (at.right - at.left);
    y = at.top + down * (at.bottom - at.top);
    return true;
  }

  /// Where it is by then: a line that comes above it while the mouse moves pushes it down.
  bool click(const std::string& control, double across = 0.5, double down = 0.5) {
    double x = 0, y = 0;
    if (!pointOf(control, across, down, x, y))
      return false;
    constexpr int kTries = 5;
    for (int i = 0; i < kTries; ++i) {
      move(x, y);
      if (!pointOf(control, across, down, x, y))
        return false;
      if (x == input_.mouseX && y == input_.mouseY)
        break;
    }
    clickAt(x, y);
    return true;
  }

  /// Opens a list and takes a choice.
  bool choose(const std::string& control, const std::string& choice) {
    if (!click(control, 0.2))
      return false;
    frames(2);
    return click(control + " = " + choice);
  }

  /// Replaces what is written in a box.
  bool write(const std::string& control, const std::string& text) {
    if (!click(control, 0.3))
      return false;
    type(text);
    press(Key::kEnter);
    return true;
  }

  ViewerInput& input() { return input_; }

 private:
  HeadlessViewer& viewer_;
  ViewerInput input_;
};

}  // namespace volute
