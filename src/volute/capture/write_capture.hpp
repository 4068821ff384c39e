// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>

#include "volute/capture/capture.hpp"

namespace volute {

/// Writes a capture as capture.json ("volute-capture-1"), with pixel centres at 0.5 and paths
/// relative to the file's folder. kInvalidArgument for orthographic cameras, kIo.
[[nodiscard]] Status writeCapture(const std::filesystem::path& file, const Capture& capture);

}  // namespace volute
