// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

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
  k7,
  kF1,
  kF11,
  kF12,
  kEscape,
  kA,
  kC,
  kD,
  kE,
  kF,
  kH,
  kM,
  kO,
  kP,
  kQ,
  kS,
  kV,
  kW,
  kX,
  kY,
  kZ,
  kBackspace,
  kDelete,
  kEnter,
};

/// What a person did between two frames. The window fills it from its events, tests by hand.
struct ViewerInput {
  int width = 960, height = 640;    ///< of the picture [pixels]
  double seconds = 1.0 / 60;        ///< since the last frame
  double mouseX = -1, mouseY = -1;  ///< [pixels] from the top left
  bool buttons[3]{};                ///< left, right, middle are held
  double wheel = 0;                 ///< clicks, away from the person is positive
  std::vector<Key> pressed{};       ///< went down since the last frame
  std::set<Key> held{};
  bool shift = false, control = false;
  std::string typed{};    ///< text, UTF-8
  std::string dropped{};  ///< a file that was dropped on the window; empty: none
  bool closes = false;    ///< the window is asked to close
  bool twice = false;  ///< the left button was pressed twice in a row, quickly, the last time now
};

}  // namespace volute
