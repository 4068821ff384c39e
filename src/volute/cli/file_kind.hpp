// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "volute/cli/arguments.hpp"

namespace volute::cli {

/// What options may be for: the name of a kind of medium's table, or one of these.
inline constexpr std::string_view kSceneKind = "scene", kVoluteKind = "volute",
                                  kPictureKind = "picture";

/// A file on a command line.
struct FileKind {
  std::string_view kind;
  std::string file;
  std::string_view advice = {};  ///< where else an option may be said
};

/// Of a file that is shown: a scene, or a medium by its name.
FileKind shownKind(const std::string& file);

/// Of one that is read: a scene, a .volute, a picture, or a medium by its name.
FileKind readKind(const std::string& file);

/// Refuses options that would change nothing: those that are for none of these files, by what
/// Option::kinds says.
[[nodiscard]] Status refuseIdle(const Arguments& arguments, const std::vector<FileKind>& files);

}  // namespace volute::cli
