// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/viewer/viewer_app.hpp"

namespace volute {

/// Opens a window, shows the file and returns when the window is closed. kUnsupported where there
/// is no display or no OpenGL 4.5. Screenshots go to the current folder.
[[nodiscard]] Status runViewerWindow(OpenDocument open, const ViewerStart& start,
                                     Progress& progress);

}  // namespace volute
