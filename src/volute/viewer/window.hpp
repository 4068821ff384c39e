// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/viewer/document.hpp"

namespace volute {

/// Opens a window, shows the file and returns when the window is closed. kUnsupported where there
/// is no display or no OpenGL 4.5. Screenshots go to the current folder.
[[nodiscard]] Status runViewerWindow(OpenDocument open, const std::string& path, double time,
                                     int width, int height, Progress& progress);

}  // namespace volute
