// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "volute/viewer/clipboard.hpp"
#include "volute/viewer/work_notes.hpp"

namespace volute {

/// Where a control was drawn in the last frame [points]. Scripts find the controls by their names.
struct ControlPlace {
  float left = 0, top = 0, right = 0, bottom = 0;
  bool cut = false;  ///< a part is beside the panel's border
};

/// What parts of the last frame took [ms].
struct FrameCosts {
  double loaded = 0;   ///< to take over what the loader has
  double panels = 0;   ///< input and panels
  double picture = 0;  ///< OpenGL's picture, or asking the CPU for one
  double shown = 0;    ///< picture and panels into the window
};

/// What the viewer and the window around it have to do with each other: where controls are, text
/// between programs, and what a person wants of the window.
class ViewerWindow {
 public:
  const std::map<std::string, ControlPlace>& controls() const { return controls_; }

  /// The item that ImGui drew last is the control of this name.
  void mark(const std::string& name);

  void mark(const std::string& name, const ControlPlace& place) { controls_[name] = place; }

  void forgetControls() { controls_.clear(), stops_.clear(), focused_.clear(); }

  /// The control of several items that ImGui drew last: where Tab stops besides.
  /// @param ids  ImGui's of the items
  void mark(const std::string& name, std::span<const unsigned> ids);

  /// Tab goes so many controls on, or back; takes effect once the panels are drawn.
  void moveFocus(int steps) { steps_ += steps; }

  /// Does so. True: it would go beyond the last control, and waits for another panel.
  bool applyFocus();

  /// The control that the keyboard is at; empty: none.
  const std::string& focused() const { return focused_; }

  /// The clipboard, for text.
  Clipboard& clipboard() { return clipboard_; }

  /// What is being done, and what was done last.
  WorkNotes& notes() { return notes_; }

  FrameCosts& costs() { return costs_; }

  void requestFullScreen() { fullScreen_ = true; }

  /// True once after a person asked for the whole screen, or for the window again.
  bool takeFullScreenRequest() { return std::exchange(fullScreen_, false); }

  void requestScreenshot() { screenshot_ = true; }

  bool takeScreenshotRequest() { return std::exchange(screenshot_, false); }

  void requestReport() { report_ = true; }

  bool takeReportRequest() { return std::exchange(report_, false); }

 private:
  std::map<std::string, ControlPlace> controls_;
  std::string focused_;

  /// Where Tab stops, in the order of drawing.
  struct Stop {
    std::string name;
    unsigned id = 0;
    void* window = nullptr;  ///< ImGui's
    float left = 0, top = 0, right = 0, bottom = 0;
  };

  void addStop(const std::string& name, unsigned id);
  void focus(const Stop& stop);

  std::vector<Stop> stops_;
  int steps_ = 0;
  Clipboard clipboard_;
  WorkNotes notes_;
  FrameCosts costs_;
  bool fullScreen_ = false, screenshot_ = false, report_ = false;
};

}  // namespace volute
