// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/tomography_scenes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "volute/image/srgb.hpp"
#include "volute/io/volume_source.hpp"
#include "volute/tomography/frame_views.hpp"
#include "volute/tomography/project.hpp"

namespace volute::bench {
namespace {

constexpr int kSide = 64;
constexpr int kOthers = 24;

/// Means of 2 x 2 x 2 voxels.
std::vector<float> halved(std::span<const float> fine, int side) {
  std::vector<float> coarse(3 * static_cast<std::size_t>(side) * side * side);
  for (int z = 0; z < 2 * side; ++z)
    for (int y = 0; y < 2 * side; ++y)
      for (int x = 0; x < 2 * side; ++x)
        for (int c = 0; c < 3; ++c) {
          const std::size_t to = (static_cast<std::size_t>(z / 2) * side + y / 2) * side + x / 2;
          const std::size_t from = (static_cast<std::size_t>(z) * 2 * side + y) * 2 * side + x;
          coarse[3 * to + c] += fine[3 * from + c] / 8;
        }
  return coarse;
}

/// Cameras on a ring around the volume, at the given heights in turn.
std::vector<Camera> ring(const Box3& bounds, int count, double turn,
                         std::span<const double> heights) {
  constexpr int kWidth = 180, kHeight = 144;
  constexpr double kFov = 42;
  std::vector<Camera> cameras;
  const double radius = 2.25 * bounds.size().x();
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * (i + turn) / count;
    const Vec3 eye = bounds.centre() +
                     radius * Vec3(std::cos(angle), std::sin(angle), heights[i % heights.size()]);
    cameras.push_back(Camera::pinhole({eye, bounds.centre()}, kFov, kWidth, kHeight));
  }
  return cameras;
}

/// Cameras with the intrinsics of the capture's first, as far away as its cameras are, somewhat
/// above and below their heights in turn.
Result<std::vector<Camera>> camerasAround(const Capture& capture) {
  const Vec3 centre = capture.volume.bounds.centre();
  const Camera& like = capture.cameras.front().camera;
  double radius = 0;
  std::vector<double> heights;
  for (const CaptureCamera& camera : capture.cameras) {
    const Vec3 from = camera.camera.eye() - centre;
    radius += from.head<2>().norm() / static_cast<double>(capture.cameras.size());
    heights.push_back(from.z());
  }
  std::vector<Camera> cameras;
  for (int i = 0; i < kOthers; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / kOthers;
    const double height = heights[i % heights.size()] + (i % 2 == 0 ? 0.1 : -0.1) * radius;
    const Vec3 eye = centre + Vec3(radius * std::cos(angle), radius * std::sin(angle), height);
    const Camera aimed = Camera::pinhole({eye, centre}, 45, like.width(), like.height());
    Calibration calibration{like.width(),
                            like.height(),
                            like.intrinsics(),
                            aimed.rotation(),
                            -aimed.rotation() * eye,
                            {},
                            0.5};
    VOLUTE_ASSIGN(Camera camera, Camera::calibrated(calibration));
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

/// The mean of 2 x 2 pictures of 4 rays a pixel each.
Result<Image> finePicture(std::span<const float> volume, const VolumeGeometry& geometry,
                          const Camera& camera) {
  Mat3 k = camera.intrinsics();
  for (int column = 0; column < 3; ++column) k(0, column) *= 2, k(1, column) *= 2;
  VOLUTE_ASSIGN(const Camera twice, Camera::calibrated({2 * camera.width(),
                                                        2 * camera.height(),
                                                        k,
                                                        camera.rotation(),
                                                        -(camera.rotation() * camera.eye()),
                                                        {},
                                                        0.5}));
  const Image large = projectVolume(volume, geometry, Basis::kTrilinear, twice, 4);
  Image image(camera.width(), camera.height());
  for (int y = 0; y < large.height; ++y)
    for (int x = 0; x < large.width; ++x)
      for (int c = 0; c < 3; ++c) image.at(x / 2, y / 2, c) += large.at(x, y, c) / 4;
  return image;
}

/// (z, y, x, 3) of one frame.
Result<std::vector<float>> readTruth(const Capture& capture, int frame, const std::string& path,
                                     const std::string& grid, std::uint64_t maxMemory) {
  VOLUTE_ASSIGN(const auto source, openSource(path, {.grid = grid,
                                                     .bounds = capture.volume.bounds,
                                                     .maxMemory = maxMemory,
                                                     .usualGrid = "emission"}));
  const VolumeInfo& info = source->info();
  const auto& n = capture.volume.resolution;
  if (info.x != n[0] || info.y != n[1] || info.z != n[2] ||
      (info.channels != 3 && info.channels != 1))
    return fail(ErrorCode::kInvalidData,
                "{}: {} x {} x {} voxels with {} channels within the capture's bounds; expected "
                "the {} x {} x {} of its volume, with 1 or 3",
                path, info.x, info.y, info.z, info.channels, n[0], n[1], n[2]);
  const auto found = std::ranges::find(info.frameNumbers, frame);
  std::ptrdiff_t position = found - info.frameNumbers.begin();
  if (found == info.frameNumbers.end()) {
    if (static_cast<std::size_t>(info.frames) != capture.frames.size())
      return fail(ErrorCode::kNotFound, "{}: it has no frame {}", path, frame);
    position = std::ranges::find(capture.frames, frame) - capture.frames.begin();
  }
  const std::size_t voxels = static_cast<std::size_t>(n[0]) * n[1] * n[2];
  std::vector<float> values(voxels * static_cast<std::size_t>(info.channels));
  VOLUTE_TRY(source->readFrame(static_cast<int>(position), values));
  if (info.channels == 3)
    return values;
  std::vector<float> grey(3 * voxels);
  for (std::size_t i = 0; i < grey.size(); ++i) grey[i] = values[i / 3];
  return grey;
}

}  // namespace

float FilmedScene::brightest() const {
  float most = 0;
  for (const TomographyView& view : views)
    most = std::max(most, *std::ranges::max_element(view.radiance.pixels));
  return most;
}

void FilmedScene::addNoise(double sigma) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  for (TomographyView& view : views)
    for (float& value : view.radiance.pixels) value += static_cast<float>(sigma) * normal(random);
}

void FilmedScene::storeAs8Bit(double saturatedShare) {
  const float lit = 0.002F * brightest();
  std::vector<float> peaks;  // the brightest channel of each lit pixel
  for (const TomographyView& view : views) {
    const auto& pixels = view.radiance.pixels;
    for (std::size_t i = 0; i < pixels.size(); i += 3) {
      const float peak = std::max({pixels[i], pixels[i + 1], pixels[i + 2]});
      if (peak > lit)
        peaks.push_back(peak);
    }
  }
  const auto rank = static_cast<std::ptrdiff_t>((1 - saturatedShare) * (peaks.size() - 1.0));
  std::ranges::nth_element(peaks, peaks.begin() + rank);
  const double white = peaks[rank];
  for (TomographyView& view : views) {
    auto& pixels = view.radiance.pixels;
    view.weight.assign(pixels.size() / 3, 1);
    view.atLeast.assign(pixels.size() / 3, 0);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const double stored = std::min(std::round(255 * srgbEncode(pixels[i] / white)), 255.0);
      if (stored >= 255) {
        view.weight[i / 3] = 0;
        view.atLeast[i / 3] |= static_cast<std::uint8_t>(1U << i % 3);
      }
      pixels[i] = static_cast<float>(white * srgbDecode(stored / 255));
    }
  }
}

SceneQuality qualityOf(const FilmedScene& scene, std::span<const float> volume, Basis basis) {
  double error = 0, light = 0, peak = 0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < scene.others.size(); ++v) {
    const Image image = projectVolume(volume, scene.geometry, basis, scene.others[v], 4);
    for (std::size_t i = 0; i < image.pixels.size(); ++i, ++count) {
      const double truth = scene.otherImages[v].pixels[i];
      error += std::pow(image.pixels[i] - truth, 2);
      light += truth * truth;
      peak = std::max(peak, truth);
    }
  }
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < volume.size(); ++i) {
    difference += std::pow(static_cast<double>(volume[i]) - scene.truth[i], 2);
    size += std::pow(scene.truth[i], 2);
  }
  return {10 * std::log10(peak * peak * static_cast<double>(count) / error),
          std::sqrt(error / light), std::sqrt(difference / size)};
}

Result<FilmedScene> filmMadeUp(SynthKind kind, Progress& progress) {
  VOLUTE_ASSIGN(const Sequence made, synthesize({kind, 2 * kSide, 1, 3, 3}, progress));
  const VolumeGeometry fine{made.info.bounds, {2 * kSide, 2 * kSide, 2 * kSide}};
  FilmedScene scene;
  scene.name = kind == SynthKind::kFire ? "fire" : "smoke";
  scene.geometry = {made.info.bounds, {kSide, kSide, kSide}};
  scene.truth = halved(made.values, kSide);
  const std::vector<double> heights{0.07, 0.16, 0.0, -0.09, 0.3};
  for (const Camera& camera : ring(fine.bounds, 8, 0.2, heights))
    scene.views.push_back({fmt::format("c{}", scene.views.size()), camera,
                           projectVolume(made.values, fine, Basis::kBox, camera, 4)});
  scene.others = ring(fine.bounds, kOthers, 0.5, std::vector<double>{-0.17, 0.09, 0.34, 0.57});
  for (const Camera& camera : scene.others)
    scene.otherImages.push_back(projectVolume(made.values, fine, Basis::kBox, camera, 4));
  return scene;
}

Result<FilmedScene> filmCapture(const Capture& capture, int frame, const std::string& truth,
                                const std::string& grid, std::uint64_t maxMemory,
                                Progress& progress) {
  FilmedScene scene;
  scene.name = fmt::format("frame {}", frame);
  scene.geometry = {capture.volume.bounds, capture.volume.resolution};
  VOLUTE_ASSIGN(scene.truth, readTruth(capture, frame, truth, grid, maxMemory));
  VOLUTE_ASSIGN(auto reader, ViewReader::open(capture, {}, maxMemory, progress));
  VOLUTE_ASSIGN(FrameViews views, reader.read(frame));
  scene.views = std::move(views.views);
  VOLUTE_ASSIGN(scene.others, camerasAround(capture));
  for (const Camera& camera : scene.others) {
    VOLUTE_ASSIGN(Image image, finePicture(scene.truth, scene.geometry, camera));
    scene.otherImages.push_back(std::move(image));
  }
  return scene;
}

}  // namespace volute::bench
