// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <set>
#include <string>

#include "volute/viewer/headless_viewer.hpp"

namespace volute {

/// Which controls the panels had while scripts ran, and which of them the scripts used. They are
/// counted by kind: "fog /media/N/mu", "remove /lights/N", "group", "look from".
struct ControlRecord {
  std::set<std::string> offered, used;

  /// Of a control of this name, as ViewerWindow::controls() has it, while this document is shown.
  /// What is in an open list counts as the list.
  static std::string kindOf(const std::string& control, const DocumentInfo* document) {
    for (const std::string many : {"group", "look from", "command"}) {
      if (control.starts_with(many + " "))
        return many;
    }
    std::string kind = control.substr(0, control.find(" = "));
    if (document && kind.starts_with("/")) {
      const auto& all = document->parameters;
      const auto of = std::ranges::find_if(
          all, [&](const Parameter& parameter) { return kind.starts_with(parameter.path); });
      if (of != all.end() && of->entry)
        kind = kind.substr(0, kind.rfind('/')) + "/entry";
      if (of != all.end())
        kind = fmt::format("{} {}", of->group.substr(0, of->group.find_first_of(": ")), kind);
    }
    const auto number = kind.find_first_of("0123456789", std::min(kind.find('/'), kind.size()));
    if (number == std::string::npos)
      return kind;
    const auto rest = kind.find_first_not_of("0123456789", number);
    return fmt::format("{}N{}", kind.substr(0, number),
                       rest == std::string::npos ? "" : kind.substr(rest));
  }
};

/// A hand that drives a viewer without a display: clicks, drags and keys through its input layer.
class ViewerScript {
 public:
  explicit ViewerScript(HeadlessViewer& viewer, int width, int height) : viewer_(viewer) {
    input_.width = width, input_.height = height;
  }

  /// Called after every frame, with the seconds that it took.
  std::function<void(double)> watch{};

  /// Is added to by all that the script does, if it is there.
  ControlRecord* record = nullptr;

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
    if (record) {
      for (const auto& [control, place] : viewer_.app().window().controls())
        record->offered.insert(ControlRecord::kindOf(control, viewer_.app().document().info()));
    }
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

  /// As from a dialog: instead of what is open.
  void open(const std::string& path) {
    viewer_.app().leaving().leaveFor(path);
    frame();
  }

  void close() {
    input_.closes = true;
    frame();
  }

  /// Turns the wheel where the mouse is.
  void wheel(double clicks) {
    input_.wheel = clicks;
    frame();
  }

  /// Keeps keys down for so many frames.
  void holdKeys(std::set<Key> keys, int count) {
    input_.held = std::move(keys);
    frames(count);
    input_.held.clear();
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
    clickHere(button);
  }

  /// Steadily, with the button held.
  void drag(double x0, double y0, double x1, double y1, int button = 0, int steps = 6) {
    move(x0, y0);
    dragTo(x1, y1, button, steps);
  }

  bool has(const std::string& control) const {
    return viewer_.app().window().controls().contains(control);
  }

  /// A point of a control, 0..1 from its left and its top. False if it is not there.
  bool pointOf(const std::string& control, double across, double down, double& x, double& y) const {
    const auto found = viewer_.app().window().controls().find(control);
    if (found == viewer_.app().window().controls().end())
      return false;
    const ControlPlace& at = found->second;
    x = at.left + across * (at.right - at.left);
    y = at.top + down * (at.bottom - at.top);
    return true;
  }

  /// Drags by so many pixels from a point of a control, 0..1 from its left and its top.
  bool dragFrom(const std::string& control, double across, double down, double right, double below,
                int steps = 6) {
    if (!moveTo(control, across, down))
      return false;
    use(control);
    dragTo(input_.mouseX + right, input_.mouseY + below, 0, steps);
    return true;
  }

  bool click(const std::string& control, double across = 0.5, double down = 0.5) {
    if (!moveTo(control, across, down))
      return false;
    use(control);
    clickHere();
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
  /// Onto a point of a control, where it is by then: a line that comes above it while the mouse
  /// moves pushes it down. Once a button is down nothing moves it.
  bool moveTo(const std::string& control, double across, double down) {
    constexpr int kTries = 8;
    double x = 0, y = 0;
    for (int i = 0; i < kTries; ++i) {
      if (!pointOf(control, across, down, x, y))
        return false;
      if (i > 0 && x == input_.mouseX && y == input_.mouseY)
        return true;
      move(x, y);
    }
    return has(control);
  }

  void clickHere(int button = 0) {
    hold(button, true);
    hold(button, false);
    frame();
  }

  void dragTo(double x1, double y1, int button, int steps) {
    const double x0 = input_.mouseX, y0 = input_.mouseY;
    hold(button, true);
    for (int i = 1; i <= steps; ++i) {
      input_.mouseX = x0 + (x1 - x0) * i / steps;
      input_.mouseY = y0 + (y1 - y0) * i / steps;
      frame();
    }
    hold(button, false);
    frame();
  }

  void use(const std::string& control) {
    if (record)
      record->used.insert(ControlRecord::kindOf(control, viewer_.app().document().info()));
  }

  HeadlessViewer& viewer_;
  ViewerInput input_;
};

}  // namespace volute
