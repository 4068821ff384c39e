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
  int width = 800, height = 600;  ///< the papers' size, or what is asked of a graphics card
  std::function<Camera(int frame, int width, int height)> camera;
  std::function<const GlScene&(int frame)> scene;
  std::function<Image(const Camera& camera, int frame)> byProcessor;
  Rgb background = Rgb::Zero();
};

/// What belongs together and is made together, so that the memory of one is free for the next.
struct GlGroup {
  double share = 0;  ///< of the time that a run may take where there is no graphics card
  std::function<Status(std::vector<GlCase>& cases, Progress& progress)> make;
};

/// One picture that stays.
GlCase stillCase(std::string name, int width, int height,
                 std::function<Camera(int width, int height)> camera, GlScene scene,
                 std::function<Image(const Camera&)> byProcessor);

/// Ahrenberg et al. 2005, Figure 8: fire and smoke over the tree's bits a voxel, walked in place
/// and from the bricks that are not empty (the paper's bounding boxes); and 64^3 voxels at
/// 1920 x 1080.
[[nodiscard]] Status addTrees(const BenchInput& input, Progress& progress,
                              std::vector<GlCase>& cases);

/// Giroud and Biri 2010, Tables 1 to 3; and fog at 1920 x 1080. Of Table 3 what comes after: fog is
/// always integrated in scaling functions here.
[[nodiscard]] Status addFogTables(bool quick, std::vector<GlCase>& cases);

/// Staubli et al. 2005, Table 3: a hall with steady and animated smoke and camera, by each way to
/// draw smoke.
void addHall(bool quick, std::vector<GlCase>& cases);

/// The paper's larger mesh, its Mall, at 1920 x 1080 with smoke and camera animated, from outside
/// and inside: `input.volume` where that is a mesh, else a made one of as many tets.
[[nodiscard]] Status addMall(const BenchInput& input, std::vector<GlCase>& cases);

}  // namespace volute::cli
