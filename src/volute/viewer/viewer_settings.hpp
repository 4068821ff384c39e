// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "volute/viewer/document.hpp"
#include "volute/viewer/panel_layout.hpp"
#include "volute/viewer/view_picture.hpp"

namespace volute {

/// What is said about a file, and about what was done.
struct PanelNotice {
  enum class Kind { kText, kFaint, kError };

  Kind kind = Kind::kText;
  std::string text{};

  bool operator==(const PanelNotice&) const = default;
};

/// What the panels show and change, and what is written into the boxes.
struct ViewerSettings {
  ViewLook look{};
  bool panels = true;
  bool help = false;
  bool search = false;   ///< over all commands
  std::string sought{};  ///< words of it
  PanelLayout layout{};
  std::vector<PanelNotice> notices{};  ///< above the panel's controls, as they are shown
  std::vector<PanelNotice> alerts{};   ///< on the picture,
  float alertsHeight = 0;              ///< and how high they are with the gap below; 0: none
  float panelHeight = 0;               ///< of the panel on the left, as it was drawn [pixels]
  bool timeOpen = false;               ///< a small window's panel of time shows speed and film too
  bool painting = false;               ///< the left button paints fog
  bool probe = false;                  ///< what is under the pointer is said
  bool measuring = false;              ///< clicks are the ends of a ruler
  bool keyboard = false;               ///< arrows, Space and Enter are the panels'
  float timeHeight = 0;                ///< of the panel of time, as it was drawn [pixels]
  std::string sceneName{};             ///< where the scene would be saved
  std::string mapName{};               ///< and the map of fog
  std::string filmName = "film.mp4";
  bool filmTurns = false;  ///< the camera goes once around
  bool follows = true;     ///< the camera's path, where the scene has one: playing, and in films
  int filmSize = 1;        ///< 640 x 360, 1280 x 720, 1920 x 1080, the window's
};

/// What is settled before any file is open.
struct ViewerOptions {
  std::optional<ViewRenderer> renderer{};  ///< whatever scenes say
  /// Else what only the CPU could draw is an error: tests see so that OpenGL draws all.
  bool cpu = true;
  bool rasteriser = false;         ///< OpenGL can be chosen where there is no graphics card
  bool desktop = false;            ///< the desktop's dialogs are used, where it has some
  double scale = 1;                ///< of letters and controls, times the display's
  std::filesystem::path recent{};  ///< names of files that were opened; empty: nothing is kept
};

/// How a viewer begins.
struct ViewerStart {
  std::string path{};              ///< empty: no file is open
  std::optional<double> time{};    ///< [s]; nothing: where the file's own look says
  int width = 1280, height = 800;  ///< [pixels]
  ViewerOptions options{};
  std::string other{};  ///< a file that it is compared with; empty: none
};

}  // namespace volute
