// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>

#include "volute/image/view_transform.hpp"

namespace volute {

/// Whether openColorView() knows what `name` means: "aces", "ocio", "ocio:VIEW",
/// "ocio:DISPLAY/VIEW".
bool namesColorView(const std::string& name);

/// By OpenColorIO: "aces" without any configuration, else by the one that $OCIO names. Errors list
/// the displays and views that there are. It lives as long as the program.
[[nodiscard]] Result<const ViewTransform*> openColorView(const std::string& name);

}  // namespace volute
