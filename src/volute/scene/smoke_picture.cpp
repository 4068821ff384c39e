// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/smoke_picture.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "volute/base/parallel.hpp"
#include "volute/tetmesh/tet_medium.hpp"

namespace volute {
namespace {

std::vector<float> scaled(const std::vector<float>& values, double factor) {
  std::vector<float> out(values);
  for (float& value : out) value = static_cast<float>(factor * value);
  return out;
}

std::vector<AnyMedium> allMedia(const SmokeScene& scene) {
  std::vector<AnyMedium> media(scene.others.begin(), scene.others.end());
  for (const SmokeState& smoke : scene.smokes)
    media.emplace_back(
        TetMedium(smoke.locator, scaled(smoke.extinction, scene.law.factor()), smoke.source));
  return media;
}

/// 1 for each pixel whose ray meets another medium's bounds.
std::vector<std::uint8_t> pixelsWithOthers(const Camera& camera, const SmokeScene& scene) {
  std::vector<std::uint8_t> mixed(static_cast<std::size_t>(camera.width()) * camera.height(), 0);
  if (scene.others.empty())
    return mixed;  // no rays for nothing
  parallelFor(static_cast<std::size_t>(camera.height()), [&](std::size_t y) {
    for (int x = 0; x < camera.width(); ++x) {
      const std::size_t pixel = y * static_cast<std::size_t>(camera.width()) + x;
      const Segment ray = pixelRay(camera, x, static_cast<int>(y), scene.opaqueDepth);
      mixed[pixel] = std::ranges::any_of(scene.others, [&](const AnyMedium& medium) {
        return !medium.bounds()
                    .intersect(ray.origin, ray.direction)
                    .intersect({ray.begin, ray.end})
                    .empty();
      });
    }
  });
  return mixed;
}

/// Light of smoke, and its transmittance, over what is behind.
void compose(std::span<const float> rgbt, const SmokeScene& scene, const RenderOptions& options,
             Image& image) {
  for (std::size_t i = 0; i < rgbt.size() / 4; ++i) {
    const bool opaque = !scene.opaqueDepth.empty() && std::isfinite(scene.opaqueDepth[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      double behind = opaque ? 0 : options.background[static_cast<Eigen::Index>(c)];
      if (options.behind)
        behind = options.behind->pixels[3 * i + c];
      image.pixels[3 * i + c] = static_cast<float>(rgbt[4 * i + c] + rgbt[4 * i + 3] * behind);
    }
  }
}

}  // namespace

SmokePictures::Fast& SmokePictures::fastFor(const std::shared_ptr<const TetLocator>& locator) {
  if (!fast_ || fast_->locator != locator)
    fast_ = std::make_unique<Fast>(locator);
  return *fast_;
}

Image SmokePictures::smokeAlone(const Camera& camera, const SmokeScene& scene,
                                const RenderOptions& options) {
  const SmokeState& smoke = scene.smokes.front();
  Fast& fast = fastFor(smoke.locator);
  const auto extinction = scaled(smoke.extinction, scene.law.factor());
  Image image(camera.width(), camera.height(), 3);
  const std::size_t pixels = image.pixels.size() / 3;
  std::vector<float> rgbt(4 * pixels, 0);
  if (smoke.source.empty()) {
    std::vector<float> depth(pixels);
    fast.splat.setExtinction(extinction);
    fast.splat.opticalDepth(camera, scene.opaqueDepth, depth);
    for (std::size_t i = 0; i < pixels; ++i) rgbt[4 * i + 3] = std::exp(-depth[i]);
  } else {
    fast.splat.setExtinction(extinction);
    fast.splat.setSource(smoke.source);
    fast.splat.litColor(camera, scene.opaqueDepth, rgbt);
  }
  compose(rgbt, scene, options, image);
  return image;
}

Result<Image> SmokePictures::color(const Camera& camera, const SmokeScene& scene,
                                   const RenderOptions& options, Progress& progress,
                                   RenderStats& stats) {
  if (scene.smokes.size() != 1 || options.renderer == Renderer::kReference)
    return render(camera, allMedia(scene), options, progress, &stats, scene.opaqueDepth);
  const auto begin = std::chrono::steady_clock::now();
  Image image = smokeAlone(camera, scene, options);
  const auto mixed = pixelsWithOthers(camera, scene);
  const auto others = static_cast<std::uint64_t>(std::ranges::count(mixed, 1));
  stats.rays = mixed.size() - others;
  stats.segments = stats.rays;
  if (others > 0) {
    RenderOptions some = options;
    some.only = mixed;
    RenderStats more;
    VOLUTE_ASSIGN(const auto rest,
                  render(camera, allMedia(scene), some, progress, &more, scene.opaqueDepth));
    for (std::size_t i = 0; i < mixed.size(); ++i) {
      if (mixed[i])
        std::copy_n(&rest.pixels[3 * i], 3, &image.pixels[3 * i]);
    }
    stats.rays += more.rays, stats.segments += more.segments, stats.pieces += more.pieces;
  }
  stats.milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  return image;
}

Result<Image> SmokePictures::opticalDepth(const Camera& camera, const SmokeScene& scene,
                                          const RenderOptions& options, Progress& progress,
                                          RenderStats& stats) {
  RenderOptions depths = options;
  depths.aov = Aov::kOpticalDepth;
  VOLUTE_ASSIGN(auto sum,
                render(camera, scene.others, depths, progress, &stats, scene.opaqueDepth));
  for (float& depth : sum.pixels) depth = static_cast<float>(depth / scene.law.factor());
  std::vector<float> depth(sum.pixels.size());
  for (const SmokeState& smoke : scene.smokes) {
    if (options.renderer == Renderer::kReference) {
      std::vector<double> exact(depth.size());
      referenceDepth(TetMedium(smoke.locator, smoke.extinction), camera, scene.opaqueDepth, exact);
      std::ranges::copy(exact, depth.begin());
    } else {
      Fast& fast = fastFor(smoke.locator);
      fast.marcher.setExtinction(smoke.extinction);
      fast.marcher.opticalDepth(camera, scene.opaqueDepth, depth);
    }
    for (std::size_t i = 0; i < depth.size(); ++i) sum.pixels[i] += depth[i];
    stats.segments += depth.size();
  }
  return sum;
}

}  // namespace volute
