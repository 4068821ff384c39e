// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string>

#include "volute/scene/scene.hpp"

namespace volute {

/// The first time at which a scene shows something, and where.
struct FirstSight {
  double time = 0;     ///< [s], of the scene
  Box3 content;        ///< around what is to be seen then, finite and not empty [m]
  std::string reason;  ///< for the time; empty: it is the first
};

/// The visible content of a snapshot.
struct SceneContent {
  Box3 box;           ///< [m]; empty: nothing was found
  double amount = 0;  ///< of media, to be compared with other snapshots' of the scene
};

/// Samples the media on a grid of about 20 points a side: the box of the points where extinction or
/// emission reaches a share of its maximum; structures smaller than a cell may be missed. Includes
/// signs, and surfaces nearby, or all surfaces if there are no media. Bounds are too large for
/// this: those of a cache enclose all its frames, those of a simulation its meshes.
SceneContent contentOf(const SceneSnapshot& snapshot);

/// Whether a scene is a file alone, or a scene file with one medium and neither a camera nor other
/// visible objects, which looks as that file does.
bool showsOneFile(const Scene& scene);

/// The first of the scene's times if it shows anything; else the earliest with much content among
/// eight coarse snapshots, or among as many as take `enough` bytes, if one of these has any. For a
/// file alone, SceneMedium::firstTime() if the medium provides it. For a scene without content, the
/// first time and Scene::bounds().
[[nodiscard]] Result<FirstSight> firstSight(Scene& scene, Progress& progress,
                                            std::uint64_t enough = ~std::uint64_t{0});

}  // namespace volute
