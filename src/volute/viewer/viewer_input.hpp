// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cmath>
#include <set>
#include <string>
#include <vector>

namespace volute {

/// Keys that mean something to the viewer.
enum class Key {
  kSpace,
  kLeft,
  kRight,
  kHome,
  kEnd,
  kUp,
  kDown,
  kPlus,
  kMinus,
  k1,
  k3,
  k5,
  k7,
  kF1,
  kF3,
  kF11,
  kF12,
  kEscape,
  kA,
  kB,
  kC,
  kD,
  kE,
  kF,
  kH,
  kI,
  kK,
  kL,
  kM,
  kO,
  kP,
  kQ,
  kR,
  kS,
  kV,
  kW,
  kX,
  kY,
  kZ,
  kBackspace,
  kDelete,
  kEnter,
  kTab,
};

/// What a person did between two frames. The window fills it from its events, tests by hand. Panels
/// and the mouse are in points, so that they are as large on every display; pictures have pixels.
struct ViewerInput {
  int width = 960, height = 640;    ///< of the window [points]
  double scale = 1;                 ///< pixels of a point, in both directions, about
  int columns = 0, rows = 0;        ///< of the window [pixels]; 0: by the scale
  double seconds = 1.0 / 60;        ///< since the last frame
  double mouseX = -1, mouseY = -1;  ///< [points] from the top left
  bool buttons[3]{};                ///< left, right, middle are held
  double wheel = 0;                 ///< clicks, away from the person is positive
  std::vector<Key> pressed{};       ///< went down since the last frame
  std::set<Key> held{};
  bool shift = false, control = false;
  std::string typed{};    ///< text, UTF-8
  std::string dropped{};  ///< a file that was dropped on the window; empty: none
  bool closes = false;    ///< the window is asked to close
  bool twice = false;  ///< the left button was pressed twice in a row, quickly, the last time now

  int pixelsAcross() const {
    return columns > 0 ? columns : static_cast<int>(std::lround(width * scale));
  }

  int pixelsDown() const { return rows > 0 ? rows : static_cast<int>(std::lround(height * scale)); }
};

}  // namespace volute
