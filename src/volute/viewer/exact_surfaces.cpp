// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/exact_surfaces.hpp"

#include <algorithm>
#include <chrono>

#include "volute/scene/surface_stack.hpp"

namespace volute {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr int kRows = 8;          ///< of the flattest tiles: a work group's
constexpr double kTile = 0.01;    ///< [s] that one may take
constexpr double kMinTile = 512;  ///< pixels of a tile
constexpr double kBlind = 8192;   ///< at most, after one where there was nothing to be lit
constexpr double kMaxTile = 1 << 22;

double secondsSince(SteadyClock::time_point begun) {
  return std::chrono::duration<double>(SteadyClock::now() - begun).count();
}

}  // namespace

Result<Camera> tileOf(const Camera& camera, int left, int top, int width, int height) {
  if (camera.isOrthographic()) {
    const double right = left + 0.5 * width - 0.5 * camera.width();
    const double down = top + 0.5 * height - 0.5 * camera.height();
    const Vec3 eye = camera.eye() + right * camera.pixelWidth() * camera.right() +
                     down * camera.pixelSize() * camera.down();
    return Camera::orthographic({eye, eye + camera.forward(), -camera.down()},
                                height * camera.pixelSize(), width, height);
  }
  Calibration part;
  part.width = width, part.height = height;
  part.K = camera.intrinsics();
  part.K(0, 2) -= left, part.K(1, 2) -= top;
  part.R = camera.rotation();
  part.t = -part.R * camera.eye();
  part.distortion = camera.distortion();
  return Camera::calibrated(part);
}

Status ExactSurfaces::begin(std::shared_ptr<const SceneSnapshot> snapshot, const Camera& camera) {
  const std::size_t pixels = static_cast<std::size_t>(camera.width()) * camera.height();
  // Lamps shine through what media are by nature.
  VOLUTE_ASSIGN(auto media, glSceneOf(*snapshot, {.natural = true}));
  work_.emplace(Work{std::move(snapshot), std::move(media), {}, camera, {}});
  work_->texels.resize(4 * pixels);
  for (std::size_t i = 0; i < work_->snapshot->media.size(); ++i) {
    if (!work_->snapshot->media[i]->hasWalls())
      continue;
    VOLUTE_ASSIGN(auto walls, glWallsOf(*work_->snapshot, i));
    work_->walls.push_back(std::move(walls));
  }
  return {};
}

Status ExactSurfaces::drawTile(GlRenderer& renderer) {
  Work& work = *work_;
  const int width = work.camera.width();
  if (work.left == 0)
    work.rows = std::min(std::max(static_cast<int>(pixels_ / width) / kRows * kRows, kRows),
                         work.camera.height() - work.top);
  const int groups = static_cast<int>(pixels_ / work.rows) / kRows;
  const int columns = std::min(std::max(groups, 1) * kRows, width - work.left);
  VOLUTE_ASSIGN(const Camera tile, tileOf(work.camera, work.left, work.top, columns, work.rows));
  const auto begun = SteadyClock::now();
  Progress quiet;
  SurfaceStack all(tile, Rgb::Zero());
  std::uint64_t lit = 0;
  const auto add = [&](SurfacePicture seen) {
    lit += seen.surfacePixels;
    all.add(SurfaceView{std::move(seen.depth), std::move(seen.color)});
  };
  const SceneSnapshot& snapshot = *work.snapshot;
  if (!snapshot.geometry.empty()) {
    const SurfaceScene surfaces{snapshot.geometry, snapshot.lights.lamps, snapshot.lights.ambient};
    VOLUTE_ASSIGN(auto seen, renderer.surfaces(tile, surfaces, work.media, Rgb::Zero(), quiet));
    add(std::move(seen));
  }
  for (const GlWalls& walls : work.walls) {
    VOLUTE_ASSIGN(auto seen, renderer.walls(tile, walls, quiet));
    add(std::move(seen));
  }
  const double seconds = secondsSince(begun);
  for (int y = 0; y < work.rows; ++y) {
    float* to = &work.texels[4 * (static_cast<std::size_t>(work.top + y) * width + work.left)];
    const std::size_t first = static_cast<std::size_t>(y) * columns;
    for (std::size_t i = first; i < first + columns; ++i, to += 4) {
      std::copy_n(&all.color()->pixels[3 * i], 3, to);
      to[3] = all.depth()[i];
    }
  }
  work.left += columns;
  if (work.left >= width)
    work.left = 0, work.top += work.rows;
  if (seconds > kTile)
    pixels_ = std::max(kMinTile, pixels_ * kTile / seconds);
  else if (seconds < 0.5 * kTile && 4 * lit >= static_cast<std::uint64_t>(columns) * work.rows)
    pixels_ = std::min(kMaxTile, 2 * pixels_);
  else if (seconds < 0.5 * kTile && pixels_ < kBlind)
    pixels_ = 2 * pixels_;
  return {};
}

Status ExactSurfaces::step(GlRenderer& renderer, double seconds) {
  const auto begun = SteadyClock::now();
  do {
    VOLUTE_TRY(drawTile(renderer));
  } while (!complete() && secondsSince(begun) < seconds);
  return {};
}

}  // namespace volute
