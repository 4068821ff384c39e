// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>

#include "volute/media/sight.hpp"
#include "volute/scene/scene.hpp"

namespace volute {

/// A scene as sight lines ask for it: the sum of all its media, and its surfaces, which are in the
/// way. A medium that is alone is asked in its own way, which may know more of it than rays do.
[[nodiscard]] Result<std::unique_ptr<SightField>> sightOf(Scene scene, const SceneOptions& options,
                                                          Progress& progress);

}  // namespace volute
