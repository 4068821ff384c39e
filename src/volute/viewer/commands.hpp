// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <span>
#include <string>

#include "volute/viewer/viewer_app.hpp"

namespace volute {

/// Something that a person has the viewer do, by a key or by its name. Keys, help and the search
/// are loops over the table of them.
struct ViewerCommand {
  const char* name;  ///< "play, pause"
  const char* keys;  ///< as help writes them: "Space"; empty: it has none
  void (*run)(ViewerApp& app, const ViewerInput& input);
  std::optional<Key> key{};
  bool control = false;
  bool shift = false;  ///< with control
};

std::span<const ViewerCommand> viewerCommands();

/// Does what the key stands for, if it does.
void runKey(ViewerApp& app, Key key, const ViewerInput& input);

/// Whether all of the words are in the command's name, its keys or what else it is called, in any
/// case.
bool isFound(const ViewerCommand& command, const std::string& words);

}  // namespace volute
