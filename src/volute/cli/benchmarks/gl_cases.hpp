// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/camera/camera.hpp"
#include "volute/cli/bench.hpp"
#include "volute/gl/gl_scene.hpp"
#include "volute/image/image.hpp"

namespace volute::cli {

/// Pictures for OpenGL and for the processor: the same ones, frame after frame.
struct GlCase {
  std::string name;
  int frames = 1;  ///< after which they begin again
  std::function<Camera(int)> camera;
  std::function<const GlScene&(int)> scene;
  std::function<Image(int)> byProcessor;
};

/// One picture that stays.
GlCase stillCase(std::string name, const Camera& camera, GlScene scene,
                 std::function<Image()> byProcessor);

/// Ahrenberg et al. 2005, Figure 8: fire and smoke over the tree's bits a voxel, walked in place
/// and from the bricks that are not empty (the paper's bounding boxes).
[[nodiscard]] Status addTrees(const BenchInput& input, Progress& progress,
                              std::vector<GlCase>& cases);

/// Giroud and Biri 2010, Tables 1 to 3. Of Table 3 what comes after: fog is always integrated in
/// scaling functions here.
[[nodiscard]] Status addFogTables(bool quick, std::vector<GlCase>& cases);

/// Staubli et al. 2005, Table 3: a hall with steady and animated smoke and camera, by each way to
/// draw smoke.
void addHall(bool quick, std::vector<GlCase>& cases);

}  // namespace volute::cli
