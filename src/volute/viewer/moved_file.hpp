// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "volute/base/result.hpp"

namespace volute {

/// A file that a scene names and that is not there.
struct MovedFile {
  std::string scene;            ///< the scene's own file
  std::filesystem::path place;  ///< where it should be
};

/// The first one of a scene; nothing: all are there, or it is no scene that can be read.
std::optional<MovedFile> movedFileOf(const std::string& scene);

/// The JSON of the scene with the place where the file is now, and with others that are missing and
/// lie beside it there. All names are absolute.
[[nodiscard]] Result<std::string> withFileAt(const MovedFile& moved,
                                             const std::filesystem::path& found);

}  // namespace volute
