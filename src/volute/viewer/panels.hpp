// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string>

#include "volute/viewer/language.hpp"
#include "volute/viewer/viewer_app.hpp"

namespace volute {

/// The colour of what failed, as Dear ImGui packs it.
constexpr unsigned kFailure = 0xFF6680FF;

/// Dear ImGui's colours and distances [points].
void styleControls();

/// DejaVu Sans where it is installed, with the letters of most languages; else Dear ImGui's own.
void useFont(double scale);

/// The panels of one frame and the lines over the picture, between ImGui's NewFrame and Render.
void drawPanels(ViewerApp& app, const ViewerInput& input);

// What drawPanels() is made of.
void drawParameterPanel(ViewerApp& app, const ViewerInput& input);
/// @param below  [pixels] where the panel above it ends
void drawPaintPanel(ViewerApp& app, const ViewerInput& input, float below);
void drawTimePanel(ViewerApp& app, const ViewerInput& input);
void drawHelpPanel(ViewerApp& app, const ViewerInput& input);
void drawSearchPanel(ViewerApp& app, const ViewerInput& input);
void drawLeavePanel(ViewerApp& app, const ViewerInput& input);
/// The curve of a transfer function, of whose points this is the first.
void drawTransferChart(ViewerApp& app, const Parameter& first);
void drawOverlay(ViewerApp& app, const ViewerInput& input);
void drawStage(ViewerApp& app, const ViewerInput& input);
void drawEmptyWindow(ViewerApp& app, const ViewerInput& input);
void drawOpenPanel(ViewerApp& app, const ViewerInput& input);
void drawReplacePanel(ViewerApp& app, const ViewerInput& input);
void drawMovedPanel(ViewerApp& app, const ViewerInput& input);

/// Of the panel of time [pixels]: none for what does not move.
float timePanelHeight(ViewerApp& app, const ViewerInput& input);

/// Begins one of the panels at the window's sides, with its top left corner at (left, top)
/// [pixels], as high as it needs and the layout allows; endSidePanel() has to follow. False where
/// it is closed. Its title is marked with its name.
bool beginSidePanel(ViewerApp& app, SidePanel panel, const char* title, float left, float top);
void endSidePanel(ViewerApp& app, SidePanel panel);

/// As much of a file's name as fits into so many letters: the end of it says most.
std::string shortened(const std::string& path, std::size_t letters);

/// How many letters fit beside each other [pixels].
std::size_t lettersIn(float width);

/// Where the panel's contents end, from its left edge.
float contentRight();

/// A text in lines of this width [pixels] that end at spaces: by itself ImGui breaks "0.0015"
/// behind its point.
std::string inLines(const std::string& text, float wide);

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
void hint(const char* text);
void hint(const std::string& name);  ///< one that may be somebody else's

}  // namespace volute
