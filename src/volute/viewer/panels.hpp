// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string>

#include "volute/viewer/viewer_app.hpp"

namespace volute {

/// Dear ImGui's colours and distances.
void styleControls();

/// The panels of one frame and the lines over the picture, between ImGui's NewFrame and Render.
void drawPanels(ViewerApp& app, const ViewerInput& input);

// What drawPanels() is made of.
void drawParameterPanel(ViewerApp& app, const ViewerInput& input);
/// @param below  [pixels] where the panel above it ends, in a window too narrow for all beside it
void drawPaintPanel(ViewerApp& app, const ViewerInput& input, float below);
void drawTimePanel(ViewerApp& app, const ViewerInput& input);
void drawHelpPanel(ViewerApp& app, const ViewerInput& input);
void drawLeavePanel(ViewerApp& app, const ViewerInput& input);
void drawOverlay(ViewerApp& app, const ViewerInput& input);

/// Between panels and the window's border [pixels].
inline constexpr float kPanelMargin = 10;

/// Of the panel of time [pixels]: two rows, three in a narrow window, none for what does not move.
float timePanelHeight(const ViewerApp& app, const ViewerInput& input);

/// That the others may have, above it [pixels].
inline float panelHeight(const ViewerApp& app, const ViewerInput& input) {
  const float time = timePanelHeight(app, input);
  return static_cast<float>(input.height) - 2 * kPanelMargin - (time > 0 ? time + 4 : 0);
}

/// A line of text that breaks where the panel ends.
void wrappedText(const std::string& text, bool faint = false);

/// A slider of a double. True when it was moved.
bool sliderDouble(const char* label, double& value, double least, double most, const char* format,
                  bool logarithmic = false);

/// A button that is marked with its name, or with `mark`. True when it was pressed.
bool markedButton(ViewerApp& app, const char* label, const std::string& mark, bool enabled = true);

/// A name that can be edited. True when it was changed.
bool nameBox(const char* label, std::string& name);

/// A list of which one is chosen; each is marked as "MARK = CHOICE" while the list is open. True
/// when another one was.
bool choiceBox(ViewerApp& app, const char* label, const std::string& mark,
               std::span<const std::string> choices, int& chosen);

/// A remark that appears over the control that was drawn last.
void hint(const std::string& text);

}  // namespace volute
