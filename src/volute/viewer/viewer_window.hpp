// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <string>
#include <utility>

#include "volute/viewer/clipboard.hpp"

namespace volute {

/// Where a control was drawn in the last frame [points]. Scripts find the controls by their names.
struct ControlPlace {
  float left = 0, top = 0, right = 0, bottom = 0;
  bool cut = false;  ///< a part is beside the panel's border
};

/// What the viewer and the window around it have to do with each other: where controls are, text
/// between programs, and what a person wants of the window.
class ViewerWindow {
 public:
  const std::map<std::string, ControlPlace>& controls() const { return controls_; }

  /// The item that ImGui drew last is the control of this name.
  void mark(const std::string& name);

  void mark(const std::string& name, const ControlPlace& place) { controls_[name] = place; }

  void forgetControls() { controls_.clear(); }

  /// Of text, between programs.
  Clipboard& clipboard() { return clipboard_; }

  void requestFullScreen() { fullScreen_ = true; }

  /// True once after a person asked for the whole screen, or for the window again.
  bool takeFullScreenRequest() { return std::exchange(fullScreen_, false); }

  void requestScreenshot() { screenshot_ = true; }

  bool takeScreenshotRequest() { return std::exchange(screenshot_, false); }

 private:
  std::map<std::string, ControlPlace> controls_;
  Clipboard clipboard_;
  bool fullScreen_ = false, screenshot_ = false;
};

}  // namespace volute
