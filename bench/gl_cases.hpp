// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/benchmark.hpp"
#include "bench/gl_paper_fog.hpp"
#include "volute/base/result.hpp"
#include "volute/camera/camera.hpp"
#include "volute/gl/gl_scene.hpp"
#include "volute/image/image.hpp"
#include "volute/render/sign.hpp"

namespace volute::bench {

/// How much a run draws.
struct GlExtent {
  bool quick = false;     ///< fewer and smaller pictures
  bool hardware = false;  ///< a graphics card, to which no picture of the papers is too large
};

/// Pictures for OpenGL and for the CPU: the same ones, frame after frame.
struct GlCase {
  std::string name;
  int width = 800, height = 600;  ///< the papers' size, or what is asked of a graphics card
  std::function<Camera(int frame, int width, int height)> camera;
  std::function<const GlScene&(int frame)> scene;
  std::function<Image(const Camera& camera, int frame)> byCpu;
  bool asLargeAsLast =
      false;  ///< without a graphics card: of the case before's size, to be compared
  std::shared_ptr<GlPaperFog> paperFog{};  ///< where set, it is drawn in the place of the scene
  std::vector<Sign> signs{};               ///< opaque, and seen through the media; emit light
};

/// What of a sign that emits light is seen: exp(-kEmittingPower * depth), of the optical depth to a
/// reader of signs that reflect it (Staubli et al. 2005, equation 14).
inline constexpr float kEmittingPower = 3.0F / 8;

/// What belongs together and is made together, so that the memory of one is free for the next.
struct GlGroup {
  double share = 0;  ///< of the time that a run may take where there is no graphics card
  std::function<Status(std::vector<GlCase>& cases, Progress& progress)> make;
};

/// One picture that stays.
GlCase stillCase(std::string name, int width, int height,
                 std::function<Camera(int width, int height)> camera, GlScene scene,
                 std::function<Image(const Camera&)> byCpu);

/// Ahrenberg et al. 2005, Figure 8: fire and smoke over the tree's bits a voxel, the tree walked in
/// place without bounding boxes, with them, and with empty bricks stepped over too, and the bricks
/// that are not empty drawn from a texture; and 64^3 voxels at 1920 x 1080. The CPU draws
/// from the tree by extracting the snapshot's bricks in each frame.
[[nodiscard]] Status addTrees(const BenchInput& input, Progress& progress,
                              std::vector<GlCase>& cases);

/// Giroud and Biri 2010, Tables 1 to 3; and fog at 1920 x 1080. Table 3 compares walks in the four
/// bases that a decomposition has with walks of each band in scaling functions; both are there by
/// the paper's walks, and what fog is drawn by here: one walk of merged levels. Needs a current
/// context.
[[nodiscard]] Status addFogTables(bool quick, std::vector<GlCase>& cases);

/// Staubli et al. 2005, Table 3: a hall with steady and animated smoke and camera, by each way to
/// draw smoke, without and with an exit sign that emits light. Without a graphics card signs are
/// shown with nothing animated and with both.
void addHall(const GlExtent& extent, std::vector<GlCase>& cases);

/// The table's larger mesh, its Mall, at 1920 x 1080 from outside and inside: `input.volume` where
/// that is a mesh, else a made one of as many tets. Without a graphics card with smoke and camera
/// animated alone.
[[nodiscard]] Status addMall(const BenchInput& input, const GlExtent& extent,
                             std::vector<GlCase>& cases);

}  // namespace volute::bench
