// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>

#include "volute/media/sight.hpp"
#include "volute/scene/scene.hpp"

namespace volute {

/// A scene for sight lines: the sum of all its media, and its surfaces, which block them. A medium
/// that is alone answers through its own interface, which may know more than rays do.
[[nodiscard]] Result<std::unique_ptr<SightField>> sightOf(Scene scene, const SceneOptions& options,
                                                          Progress& progress);

}  // namespace volute
