// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/media/field.hpp"

namespace volute {

/// A list of objects in a scene file, and the kinds that may stand in it.
struct SceneList {
  std::string name;  ///< "media"
  std::vector<const FieldTable*> tables;
};

/// "media", "lights", "geometry", "signs", "billboards", ..: those of all kinds of media there are.
std::vector<SceneList> sceneLists();

/// A JSON Schema of scene files.
nlohmann::ordered_json sceneSchema();

/// All members as a page of Markdown.
std::string sceneMembersPage();

}  // namespace volute
