// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_renderer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "volute/base/mask.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/stopwatch.hpp"
#include "volute/camera/pixel_ray.hpp"
#include "volute/render/scaled_medium.hpp"
#include "volute/scene/clip.hpp"
#include "volute/scene/surface_stack.hpp"

namespace volute {

nlohmann::ordered_json SceneRenderer::stats() {
  return nlohmann::ordered_json::object();
}

namespace {

/// 1 for each pixel whose ray meets the bounds of one of the media.
std::vector<std::uint8_t> pixelsThatMeet(const Camera& camera, std::span<const AnyMedium> media,
                                         std::span<const float> opaqueDepth) {
  std::vector<std::uint8_t> meets(static_cast<std::size_t>(camera.width()) * camera.height(), 0);
  if (media.empty())
    return meets;  // no rays for nothing
  parallelFor(static_cast<std::size_t>(camera.height()), [&](std::size_t y) {
    for (int x = 0; x < camera.width(); ++x) {
      const std::size_t pixel = y * static_cast<std::size_t>(camera.width()) + x;
      const Segment ray = pixelRay(camera, x, static_cast<int>(y), opaqueDepth);
      meets[pixel] = std::ranges::any_of(media, [&](const AnyMedium& medium) {
        return !medium.bounds()
                    .intersect(ray.origin, ray.direction)
                    .intersect({ray.begin, ray.end})
                    .empty();
      });
    }
  });
  return meets;
}

/// `opaqueDepth`, and 0 where a pixel is not asked for: what draws all pixels at once has nothing
/// to do there.
std::vector<float> endsOf(std::span<const float> opaqueDepth, std::span<const std::uint8_t> only) {
  if (only.empty())
    return {opaqueDepth.begin(), opaqueDepth.end()};
  std::vector<float> ends(only.size(), 0);
  forEachSet(only, 0, only.size(), [&](std::size_t i) {
    ends[i] = opaqueDepth.empty() ? std::numeric_limits<float>::infinity() : opaqueDepth[i];
  });
  return ends;
}

/// Light of a medium, and its transmittance, over what is behind.
/// @param only  as View::only
Image over(std::span<const float> rgbt, const Camera& camera, std::span<const std::uint8_t> only,
           std::span<const float> opaqueDepth, const RenderOptions& options) {
  constexpr std::size_t kGrain = 1 << 16;  // pixels
  Image image(camera.width(), camera.height(), 3);
  parallelRanges(rgbt.size() / 4, kGrain, [&](std::size_t begin, std::size_t end) {
    forEachSet(only, begin, end, [&](std::size_t i) {
      const bool opaque = !opaqueDepth.empty() && std::isfinite(opaqueDepth[i]);
      for (std::size_t c = 0; c < 3; ++c) {
        double behind = opaque ? 0 : options.background[c];
        if (options.behind)
          behind = options.behind->pixels[3 * i + c];
        image.pixels[3 * i + c] = static_cast<float>(rgbt[4 * i + c] + rgbt[4 * i + 3] * behind);
      }
    });
  });
  return image;
}

}  // namespace

/// All that is opaque from a camera, and what of signs is seen.
class SceneRenderer::Opaque {
 public:
  static Result<Opaque> draw(SceneRenderer& renderer, View view, const Rgb& background,
                             Progress& progress, PictureCounts& counts) {
    const SceneSnapshot& snapshot = view.snapshot;
    Opaque opaque(SurfaceStack(view.camera, background));
    if (view.surfaces && !snapshot.geometry.empty()) {
      const Stopwatch watch(counts.surfaceMilliseconds);
      VOLUTE_ASSIGN(auto seen, renderer.surfaces(view, progress));
      counts.surfacePixels += seen.surfacePixels;
      counts.shadowRays += seen.shadowRays;
      opaque.stack.add(SurfaceView{std::move(seen.depth), std::move(seen.color)});
    }
    for (std::size_t i = 0; i < snapshot.media.size(); ++i) {
      if (!view.surfaces || !snapshot.media[i]->hasWalls())
        continue;
      VOLUTE_ASSIGN(auto seen, renderer.walls(view, i));
      opaque.stack.add(std::move(seen));
    }
    if (!snapshot.signs.empty()) {
      view.opaqueDepth = opaque.stack.depth();
      VOLUTE_ASSIGN(opaque.signs, renderer.findSigns(view));
      if (!view.only.empty()) {
        std::erase_if(opaque.signs, [&](const SignPixel& sign) {
          return !view.only[static_cast<std::size_t>(sign.pixel)];
        });
      }
      opaque.stack.add(opaque.signs);
    }
    return opaque;
  }

  SurfaceStack stack;
  std::vector<SignPixel> signs;

 private:
  explicit Opaque(SurfaceStack surfaces) : stack(std::move(surfaces)) {}
};

Result<Image> SceneRenderer::render(const SceneSnapshot& snapshot, const Camera& camera,
                                    const RenderOptions& options, Progress& progress,
                                    PictureCounts* counts) {
  PictureCounts ignoredCounts;
  return picture({snapshot, camera}, options, progress, counts ? *counts : ignoredCounts);
}

Result<Image> SceneRenderer::renderSmooth(const SceneSnapshot& snapshot, const Camera& camera,
                                          const RenderOptions& options, int samples,
                                          const PictureStyle& shown, Progress& progress,
                                          PictureCounts* counts) {
  PictureCounts ignoredCounts;
  PictureCounts& counted = counts ? *counts : ignoredCounts;
  VOLUTE_ASSIGN(auto image, picture({snapshot, camera}, options, progress, counted));
  PictureStyle look = shown;
  look.glow = 0, look.dither = false;
  const auto edges = edgePixels(developed(image, look));
  if (samples < 2 || std::ranges::count(edges, 1) == 0)
    return image;
  const auto channels = static_cast<std::size_t>(image.channels);
  std::vector<std::size_t> places;  // of the channels of pixels with edges
  for (std::size_t p = 0; p < edges.size(); ++p) {
    for (std::size_t c = 0; edges[p] && c < channels; ++c) places.push_back(channels * p + c);
  }
  std::vector<float> sums;
  for (const std::size_t at : places) sums.push_back(image.pixels[at]);
  Progress quiet;
  for (int i = 1; i < samples; ++i) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before the edges were smoothed");
    // A lattice (R2 of Martin Roberts) around the centre, where the first ray went.
    const double right = 0.7548776662466927 * i, down = 0.5698402909980532 * i;
    const Camera moved = camera.shifted(right - std::round(right), down - std::round(down));
    PictureCounts more;
    RenderOptions own = options;
    own.only = edges;
    VOLUTE_ASSIGN(const auto one, picture({.snapshot = snapshot, .camera = moved, .only = edges},
                                          own, quiet, more));
    counted.shadowRays += more.shadowRays;
    counted.render.rays += more.render.rays, counted.render.segments += more.render.segments;
    counted.render.pieces += more.render.pieces;
    for (std::size_t k = 0; k < places.size(); ++k) sums[k] += one.pixels[places[k]];
  }
  for (std::size_t k = 0; k < places.size(); ++k)
    image.pixels[places[k]] = sums[k] / static_cast<float>(samples);
  return image;
}

Result<Image> SceneRenderer::renderBare(const SceneSnapshot& snapshot, const Camera& camera,
                                        const RenderOptions& options, Progress& progress) {
  PictureCounts ignoredCounts;
  return picture({.snapshot = snapshot, .camera = camera, .surfaces = false}, options, progress,
                 ignoredCounts);
}

Result<Image> SceneRenderer::picture(View view, const RenderOptions& options, Progress& progress,
                                     PictureCounts& counted) {
  const SceneSnapshot& snapshot = view.snapshot;
  VOLUTE_TRY(begin(view));
  VOLUTE_ASSIGN(const auto opaque,
                Opaque::draw(*this, view, options.background, progress, counted));
  view.opaqueDepth = opaque.stack.depth();
  if (options.aov == Aov::kDistance)
    return distances(view, options, progress, counted);
  if (options.aov != Aov::kNone) {
    RenderOptions depths = options;
    depths.aov = Aov::kOpticalDepth;
    VOLUTE_ASSIGN(auto depth, opticalDepth(view, depths, progress, counted.render));
    for (std::size_t i = 0; i < depth.pixels.size(); ++i) {
      float& value = depth.pixels[i];
      if (options.aov == Aov::kOpticalDepth)
        continue;
      value = static_cast<float>(std::exp(-snapshot.law.factor() * value));
      if (options.aov == Aov::kAlpha) {
        const bool surface = !view.opaqueDepth.empty() && std::isfinite(view.opaqueDepth[i]);
        value = surface ? 1 : 1 - value;
      }
    }
    return depth;
  }
  RenderOptions before = options;
  before.behind = opaque.stack.color();
  VOLUTE_ASSIGN(auto image, color(view, before, progress, counted.render));
  if (!opaque.signs.empty())
    VOLUTE_TRY(addSigns(view, opaque.signs, options, progress, image));
  return image;
}

Result<Image> SceneRenderer::distances(View view, const RenderOptions& options, Progress& progress,
                                       PictureCounts& counted) {
  constexpr int kHalvings = 24, kUnbounded = 20;  // the latter more for 2^20 m
  constexpr double kFarthest = 1 << kUnbounded;   // [m] of a medium without an end
  int halvings = kHalvings;
  const Camera& camera = view.camera;
  const std::size_t pixels = static_cast<std::size_t>(camera.width()) * camera.height();
  const double half = std::log(2.0) / view.snapshot.law.factor();
  std::vector<float> surface(view.opaqueDepth.begin(), view.opaqueDepth.end());
  surface.resize(pixels, std::numeric_limits<float>::infinity());
  std::vector<double> near(pixels, 0), far(pixels, 0), axis(pixels, 1);
  for (std::size_t p = 0; p < pixels; ++p) {
    const Segment ray = camera.ray(static_cast<double>(p % camera.width()) + 0.5,
                                   static_cast<double>(p / camera.width()) + 0.5);
    axis[p] = ray.direction.dot(camera.forward());
    const Interval inside = options.within.intersect(ray.origin, ray.direction)
                                .intersect({ray.begin, std::min<double>(ray.end, surface[p])});
    if (inside.empty())
      continue;
    near[p] = inside.begin, far[p] = inside.end;
    if (!std::isfinite(far[p])) {
      far[p] = near[p] + kFarthest;
      halvings = kHalvings + kUnbounded;
    }
  }
  RenderOptions depths = options;
  depths.aov = Aov::kOpticalDepth;
  std::vector<float> at(pixels);
  const auto depthUpTo = [&](const auto& place) {
    for (std::size_t p = 0; p < pixels; ++p) at[p] = static_cast<float>(place(p));
    view.opaqueDepth = at;
    return opticalDepth(view, depths, progress, counted.render);
  };
  VOLUTE_ASSIGN(const auto whole, depthUpTo([&](std::size_t p) { return far[p]; }));
  for (int i = 0; i < halvings; ++i) {
    VOLUTE_ASSIGN(const auto depth,
                  depthUpTo([&](std::size_t p) { return 0.5 * (near[p] + far[p]); }));
    for (std::size_t p = 0; p < pixels; ++p)
      (depth.pixels[p] < half ? near : far)[p] = 0.5 * (near[p] + far[p]);
  }
  Image image(camera.width(), camera.height(), 1);
  for (std::size_t p = 0; p < pixels; ++p) {
    const double distance = whole.pixels[p] >= half ? far[p] : surface[p];
    image.pixels[p] = static_cast<float>(distance * axis[p]);
  }
  return image;
}

Status CpuRenderer::begin(const View& view) {
  const auto& media = view.snapshot.media;
  pictures_.resize(media.size());
  made_.assign(media.size(), {});
  others_.clear();
  kept_.resize(media.size());
  for (std::size_t i = 0; i < media.size(); ++i) {
    pictures_[i] = nullptr;
    if (method_ != Renderer::kReference)
      pictures_[i] = kept_[i] = media[i]->picture(std::move(kept_[i]));
    if (pictures_[i])
      continue;
    VOLUTE_TRY(media[i]->addMediaFor(view.camera, made_[i]));
    others_.insert(others_.end(), made_[i].begin(), made_[i].end());
  }
  return {};
}

/// What draws itself is made into media only where rays need it: a mesh is copied for that.
Result<std::vector<AnyMedium>> CpuRenderer::mediaFor(const View& view) const {
  std::vector<AnyMedium> all;
  for (std::size_t i = 0; i < made_.size(); ++i) {
    if (pictures_[i])
      VOLUTE_TRY(view.snapshot.media[i]->addMediaFor(view.camera, all));
    else
      all.insert(all.end(), made_[i].begin(), made_[i].end());
  }
  return all;
}

/// What takes light on its way to surfaces: a clip changes what is shown alone.
Result<std::vector<AnyMedium>> CpuRenderer::wholeFor(const View& view) const {
  std::vector<AnyMedium> all;
  for (std::size_t i = 0; i < made_.size(); ++i) {
    const MediumSnapshot& medium = *view.snapshot.media[i];
    if (pictures_[i] || clipOf(medium))
      VOLUTE_TRY(unclipped(medium).addMediaFor(view.camera, all));
    else
      all.insert(all.end(), made_[i].begin(), made_[i].end());
  }
  return all;
}

Result<SurfacePicture> CpuRenderer::surfaces(const View& view, Progress& progress) {
  const SceneSnapshot& snapshot = view.snapshot;
  // Lamps' light is always attenuated physically, whatever the picture's law.
  DepthsAlong ofAll;  // of a medium in shares, beside which there is no other
  for (const auto& picture : pictures_) {
    if (picture && !ofAll)
      ofAll = picture->depthsOfAll();
  }
  std::vector<AnyMedium> media;
  if (!ofAll) {
    VOLUTE_ASSIGN(media, wholeFor(view));
  }
  for (AnyMedium& medium : media) medium = scaledBy(1 / snapshot.law.factor(), medium);
  const SurfaceScene scene{snapshot.geometry,       snapshot.lights.lamps,
                           snapshot.lights.ambient, media,
                           snapshot.shadows,        ofAll};
  return renderSurfaces(view.camera, scene, Rgb::Zero(), progress, view.only);
}

Result<SurfaceView> CpuRenderer::walls(const View& view, std::size_t medium) {
  return view.snapshot.media[medium]->lookAtWalls(view.camera, view.snapshot.geometry, view.only);
}

Result<std::vector<SignPixel>> CpuRenderer::findSigns(const View& view) {
  return signPixels(view.camera, view.snapshot.signs, view.opaqueDepth);
}

Result<Image> CpuRenderer::color(const View& view, const RenderOptions& options, Progress& progress,
                                 RenderStats& stats) {
  RenderOptions own = options;
  own.renderer = method_;
  const auto whole = [](const auto& picture) { return picture != nullptr; };
  if (std::ranges::count_if(pictures_, whole) != 1) {
    VOLUTE_ASSIGN(const auto media, mediaFor(view));
    return volute::render(view.camera, media, own, progress, &stats, view.opaqueDepth);
  }
  const auto begin = std::chrono::steady_clock::now();
  const std::size_t pixels = static_cast<std::size_t>(view.camera.width()) * view.camera.height();
  const auto ends = endsOf(view.opaqueDepth, view.only);
  rgbt_.resize(4 * pixels);
  (*std::ranges::find_if(pictures_, whole))->light(view.camera, ends, rgbt_);
  Image image = over(rgbt_, view.camera, view.only, ends, own);
  const auto mixed = pixelsThatMeet(view.camera, others_, ends);
  const auto others = static_cast<std::uint64_t>(std::ranges::count(mixed, 1));
  stats.rays = mixed.size() - others;
  stats.segments = stats.rays;
  if (others > 0) {
    own.only = mixed;
    RenderStats more;
    VOLUTE_ASSIGN(const auto media, mediaFor(view));
    VOLUTE_ASSIGN(const auto rest,
                  volute::render(view.camera, media, own, progress, &more, view.opaqueDepth));
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

Result<Image> CpuRenderer::opticalDepth(const View& view, const RenderOptions& options,
                                        Progress& progress, RenderStats& stats) {
  RenderOptions depths = options;
  depths.renderer = method_;
  depths.aov = Aov::kOpticalDepth;
  Image sum(view.camera.width(), view.camera.height(), 1);
  if (!others_.empty()) {
    VOLUTE_ASSIGN(sum,
                  volute::render(view.camera, others_, depths, progress, &stats, view.opaqueDepth));
    const double factor = view.snapshot.law.factor();
    for (float& depth : sum.pixels) depth = static_cast<float>(depth / factor);
  }
  const auto ends = endsOf(view.opaqueDepth, view.only);
  bool empty = others_.empty();
  for (const auto& picture : pictures_) {
    if (!picture)
      continue;
    stats.segments += sum.pixels.size();
    if (std::exchange(empty, false)) {
      picture->opticalDepth(view.camera, ends, sum.pixels);
      continue;
    }
    std::vector<float> depth(sum.pixels.size());
    picture->opticalDepth(view.camera, ends, depth);
    for (std::size_t i = 0; i < depth.size(); ++i) sum.pixels[i] += depth[i];
  }
  return sum;
}

Status CpuRenderer::addSigns(const View& view, std::span<const SignPixel> seen,
                             const RenderOptions& options, Progress& progress, Image& image) {
  RenderStats ofSigns;
  std::vector<std::uint8_t> only(image.pixels.size() / 3, 0);
  for (const SignPixel& sign : seen) only[static_cast<std::size_t>(sign.pixel)] = 1;
  View beforeSigns = view;
  RenderOptions own = options;
  beforeSigns.only = own.only = only;
  VOLUTE_ASSIGN(const auto depth, opticalDepth(beforeSigns, own, progress, ofSigns));
  volute::addSigns(seen, view.snapshot.signs, depth, view.snapshot.law, image);
  return {};
}

}  // namespace volute
