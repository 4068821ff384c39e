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

/// A file of any kind for sight lines. Of a medium alone, what only pictures need is not read.
[[nodiscard]] Result<std::unique_ptr<SightField>> openSight(const std::string& path,
                                                            const SceneOptions& options,
                                                            Progress& progress);

/// The same where lines begin or end at `heights` [m]: a source of one layer (a 2D slice) that
/// neither options.members nor a scene name gives way to a taller one if one of them is outside of
/// it; a sentence about that is added to `remarks`.
[[nodiscard]] Result<std::unique_ptr<SightField>> openSight(const std::string& path,
                                                            const SceneOptions& options,
                                                            std::span<const double> heights,
                                                            std::vector<Remark>& remarks,
                                                            Progress& progress);

}  // namespace volute
