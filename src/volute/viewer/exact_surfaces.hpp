// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "volute/gl/gl_renderer.hpp"
#include "volute/gl/gl_snapshot.hpp"

namespace volute {

/// A part of a camera's picture, as a camera of its own: the same rays.
/// @param left  of its first column, as `top` of its first row [pixels]
[[nodiscard]] Result<Camera> tileOf(const Camera& camera, int left, int top, int width, int height);

/// Surfaces and walls of smoke pixel by pixel, as `volute render --renderer gl` draws them: some
/// tiles at a time, so that a window's frames go on meanwhile.
class ExactSurfaces {
 public:
  /// Another picture, from its first tile on. kUnsupported for media that OpenGL does not draw.
  [[nodiscard]] Status begin(std::shared_ptr<const SceneSnapshot> snapshot, const Camera& camera);

  void drop() { work_.reset(); }

  bool begun() const { return work_.has_value(); }

  bool complete() const { return work_ && work_->top >= work_->camera.height(); }

  /// Goes on for so long [s], by one tile at least. Tiles are as large as a hundredth of a second
  /// lets them be, but for the first ones, which may have to upload and to link.
  [[nodiscard]] Status step(GlRenderer& renderer, double seconds);

  const Camera& camera() const { return work_->camera; }

  /// Four a pixel: linear radiance, and how far along its ray [m], infinite where nothing is.
  std::span<const float> texels() const { return work_->texels; }

 private:
  struct Work {
    std::shared_ptr<const SceneSnapshot> snapshot;
    GlScene media;               ///< by nature
    std::vector<GlWalls> walls;  ///< of what `snapshot` holds
    Camera camera;
    std::vector<float> texels;
    int left = 0, top = 0;  ///< of the next tile
    int rows = 0;           ///< of it, and of those beside it
  };

  Status drawTile(GlRenderer& renderer);

  std::optional<Work> work_;
  double pixels_ = 4096;  ///< of a tile, as the last ones went
};

}  // namespace volute
