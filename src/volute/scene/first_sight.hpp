// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string>

#include "volute/scene/scene.hpp"

namespace volute {

/// When and where a scene has something to see.
struct FirstSight {
  double time = 0;     ///< [s], of the scene
  Box3 content;        ///< around what is to be seen then, finite and not empty [m]
  std::string reason;  ///< for the time; empty: it is the first
};

/// How much there is to see of a snapshot, and where.
struct SceneContent {
  Box3 box;           ///< [m]; empty: nothing was found
  double amount = 0;  ///< of media, to be compared with other snapshots' of the scene
};

/// Looks at the media on a grid of some 20 points a side: where their extinction and emission reach
/// a share of the largest; what is smaller than a cell of it may be missed. Signs belong to it, and
/// surfaces that are near, or all of them where there are no media. Bounds say less: those of a
/// cache are around all its frames, those of a simulation around its meshes.
SceneContent contentOf(const SceneSnapshot& snapshot);

/// Whether a scene is a file alone, or a scene file that shows the frames of one and says neither a
/// camera nor anything else to be seen: it is to look as the file does.
bool showsOneFile(const Scene& scene);

/// The first of the scene's times if there is something to see, else the earliest of some that
/// shows much: of eight coarse snapshots, or of those that together take so many bytes as are
/// `enough`, if there is something in them. A file alone whose medium knows better says it
/// (SceneMedium::firstTime()). Of a scene that has nothing it is the first time and
/// Scene::bounds().
[[nodiscard]] Result<FirstSight> firstSight(Scene& scene, Progress& progress,
                                            std::uint64_t enough = ~std::uint64_t{0});

}  // namespace volute
