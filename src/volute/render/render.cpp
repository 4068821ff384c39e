// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/render/render.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>
#include <vector>

#include "volute/base/parallel.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

constexpr int kTile = 32;
constexpr int kBlock =
    4;  // rays go in blocks of 4 x 4 pixels, so that the lanes of a vector take the same way

struct Pixel {
  int x = 0;
  int y = 0;
};

/// Pixels: left <= x < right.
struct Window {
  int left = 0, top = 0, right = 0, bottom = 0;

  bool meets(int x, int y, int side) const {
    return x < right && x + side > left && y < bottom && y + side > top;
  }
};

/// All pixels whose rays meet one of the media, and maybe others: around the corners of their
/// bounds, where all of these are before the camera and straight edges stay straight.
Window windowOf(const Camera& camera, std::span<const AnyMedium> media) {
  constexpr double kMargin = 1;  // [pixels] more than any rounding
  const Window whole{0, 0, camera.width(), camera.height()};
  if (!camera.distortion().none())
    return whole;
  Vec2 low(camera.width(), camera.height()), high(0, 0);
  for (const AnyMedium& medium : media) {
    const Box3 bounds = medium.bounds();
    for (int corner = 0; corner < 8; ++corner) {
      const auto place = camera.project(bounds.corner(corner));
      if (!place || !std::isfinite(place->x()) || !std::isfinite(place->y()))
        return whole;
      low = low.cwiseMin(*place), high = high.cwiseMax(*place);
    }
  }
  const auto pixel = [](double at, int most) {
    return static_cast<int>(std::clamp<double>(at, 0, most));
  };
  return {pixel(std::floor(low.x() - kMargin), whole.right),
          pixel(std::floor(low.y() - kMargin), whole.bottom),
          pixel(std::ceil(high.x() + kMargin), whole.right),
          pixel(std::ceil(high.y() + kMargin), whole.bottom)};
}

struct Scene {
  const Camera& camera;
  std::span<const AnyMedium> media;
  const RenderOptions& options;
  std::span<const float> opaqueDepth;

  std::size_t index(const Pixel& pixel) const {
    return static_cast<std::size_t>(pixel.y) * camera.width() + pixel.x;
  }

  bool opaque(const Pixel& pixel) const {
    return !opaqueDepth.empty() && std::isfinite(opaqueDepth[index(pixel)]);
  }

  Segment ray(const Pixel& pixel) const {
    Segment segment = camera.ray(pixel.x + 0.5, pixel.y + 0.5);
    if (opaque(pixel))
      segment.end = opaqueDepth[index(pixel)];
    return segment;
  }
};

std::vector<Pixel> pixelsOfTile(const Scene& scene, int left, int top) {
  const Camera& camera = scene.camera;
  const auto wanted = [&](const Pixel& pixel) {
    return scene.options.only.empty() || scene.options.only[scene.index(pixel)];
  };
  std::vector<Pixel> pixels;
  pixels.reserve(kTile * kTile);
  const int right = std::min(left + kTile, camera.width());
  const int bottom = std::min(top + kTile, camera.height());
  for (int blockY = top; blockY < bottom; blockY += kBlock) {
    for (int blockX = left; blockX < right; blockX += kBlock) {
      for (int y = blockY; y < std::min(blockY + kBlock, bottom); ++y) {
        for (int x = blockX; x < std::min(blockX + kBlock, right); ++x) {
          if (wanted({x, y}))
            pixels.push_back({x, y});
        }
      }
    }
  }
  return pixels;
}

/// Through all pieces of all media, in double.
void byPieces(std::span<const AnyMedium> media, std::span<const Segment> segments,
              std::span<Radiance> light, RenderStats& stats) {
  std::vector<std::vector<std::vector<Piece>>> ofMedium(media.size());
  for (auto& pieces : ofMedium) pieces.resize(std::min(kSegmentsAtOnce, segments.size()));
  std::vector<std::vector<Piece>> onRay(media.size());
  for (std::size_t first = 0; first < segments.size(); first += kSegmentsAtOnce) {
    const std::size_t rays = std::min(kSegmentsAtOnce, segments.size() - first);
    for (std::size_t m = 0; m < media.size(); ++m)
      media[m].pieces(segments.subspan(first, rays), std::span(ofMedium[m]).first(rays));
    for (std::size_t i = 0; i < rays; ++i) {
      for (std::size_t m = 0; m < media.size(); ++m) {
        onRay[m].swap(ofMedium[m][i]);
        stats.pieces += onRay[m].size();
      }
      light[first + i] = compositeMedia(onRay);
      for (std::size_t m = 0; m < media.size(); ++m) onRay[m].swap(ofMedium[m][i]);
    }
  }
}

/// The part of a ray inside of one medium's bounds, or of several media's.
struct Part {
  Interval inside;
  std::vector<std::size_t> media;
};

/// A ray in the order in which it meets media, cut where one begins or ends in another; whole where
/// one of them does not allow cuts.
std::vector<Part> partsInOrder(std::span<const AnyMedium> media, const Segment& segment) {
  std::vector<Part> whole;
  for (std::size_t m = 0; m < media.size(); ++m) {
    const Interval inside = media[m]
                                .bounds()
                                .intersect(segment.origin, segment.direction)
                                .intersect({segment.begin, segment.end});
    if (!inside.empty())
      whole.push_back({inside, {m}});
  }
  std::ranges::sort(whole, {}, [](const Part& part) { return part.inside.begin; });
  const auto overlap = [](const Part& a, const Part& b) { return b.inside.begin < a.inside.end; };
  if (std::ranges::adjacent_find(whole, overlap) == whole.end())
    return whole;
  Part all{{segment.begin, segment.end}, {}};
  std::vector<double> ends;
  bool cuts = true;
  for (const Part& one : whole) {
    all.media.push_back(one.media.front());
    ends.insert(ends.end(), {one.inside.begin, one.inside.end});
    cuts = cuts && !media[one.media.front()].dependsOnEnd();
  }
  if (!cuts)
    return {all};
  std::ranges::sort(ends);
  std::vector<Part> parts;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    Part part{{ends[i - 1], ends[i]}, {}};
    for (const Part& one : whole) {
      if (one.inside.begin <= part.inside.begin && one.inside.end >= part.inside.end)
        part.media.push_back(one.media.front());
    }
    if (!part.inside.empty() && !part.media.empty())
      parts.push_back(std::move(part));
  }
  return parts;
}

/// Each medium's fast path, and pieces only where media overlap.
void byFastPaths(std::span<const AnyMedium> media, std::span<const Segment> segments,
                 std::span<Radiance> light, RenderStats& stats) {
  if (media.size() == 1)
    return media[0].radiance(segments, light);
  std::vector<std::vector<Part>> parts(segments.size());
  std::vector<std::vector<Segment>> segmentsOf(media.size() + 1);  // the last ones of several media
  const auto whoseIs = [&](const Part& part) {
    return part.media.size() == 1 ? part.media.front() : media.size();
  };
  for (std::size_t i = 0; i < segments.size(); ++i) {
    parts[i] = partsInOrder(media, segments[i]);
    const bool cut =
        std::ranges::any_of(parts[i], [](const Part& p) { return p.media.size() > 1; });
    for (const Part& part : parts[i]) {
      Segment own = segments[i];
      if (cut)
        own.begin = part.inside.begin, own.end = part.inside.end;
      segmentsOf[whoseIs(part)].push_back(own);
    }
  }
  std::vector<std::vector<Radiance>> lightOf(segmentsOf.size());
  for (std::size_t m = 0; m < segmentsOf.size(); ++m) {
    lightOf[m].resize(segmentsOf[m].size());
    if (segmentsOf[m].empty())
      continue;
    if (m < media.size())
      media[m].radiance(segmentsOf[m], lightOf[m]);
    else
      byPieces(media, segmentsOf[m], lightOf[m], stats);
  }
  std::vector<std::size_t> next(segmentsOf.size(), 0);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    light[i] = Radiance{};
    for (const Part& part : parts[i]) {
      const std::size_t whose = whoseIs(part);
      const Radiance& one = lightOf[whose][next[whose]++];
      light[i].emitted += light[i].transmittance * one.emitted;
      light[i].transmittance *= one.transmittance;
    }
  }
}

void renderColors(const Scene& scene, std::span<const Pixel> pixels,
                  std::span<const Segment> segments, Image& image, RenderStats& stats) {
  std::vector<Radiance> light(segments.size());
  const bool reference = scene.options.renderer == Renderer::kReference;
  if (!scene.media.empty())
    (reference ? byPieces : byFastPaths)(scene.media, segments, light, stats);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    Rgb color = light[i].emitted;
    if (const Image* behind = scene.options.behind) {
      for (int c = 0; c < 3; ++c)
        color[c] += light[i].transmittance * behind->at(pixels[i].x, pixels[i].y, c);
    } else if (!scene.opaque(pixels[i])) {
      color += light[i].transmittance * scene.options.background;
    }
    for (int c = 0; c < 3; ++c)
      image.at(pixels[i].x, pixels[i].y, c) = static_cast<float>(color[c]);
  }
}

void renderDepths(const Scene& scene, std::span<const Pixel> pixels,
                  std::span<const Segment> segments, Image& image) {
  std::vector<double> sum(segments.size(), 0);
  std::vector<double> depths(segments.size());
  for (const AnyMedium& medium : scene.media) {
    medium.opticalDepth(segments, depths);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += depths[i];
  }
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const double value = scene.options.aov == Aov::kTransmittance ? std::exp(-sum[i]) : sum[i];
    image.at(pixels[i].x, pixels[i].y) = static_cast<float>(value);
  }
}

void renderTile(const Scene& scene, int left, int top, Image& image, RenderStats& stats) {
  const std::vector<Pixel> pixels = pixelsOfTile(scene, left, top);
  std::vector<Segment> segments;
  segments.reserve(pixels.size());
  // Without media nobody asks where a ray goes.
  for (const Pixel& pixel : pixels)
    segments.push_back(scene.media.empty() ? Segment{} : scene.ray(pixel));
  stats.rays = pixels.size();
  stats.segments = pixels.size() * scene.media.size();
  if (scene.options.aov == Aov::kNone) {
    renderColors(scene, pixels, segments, image, stats);
  } else {
    renderDepths(scene, pixels, segments, image);
  }
}

}  // namespace

Result<Image> render(const Camera& camera, std::span<const AnyMedium> media,
                     const RenderOptions& options, Progress& progress, RenderStats* stats,
                     std::span<const float> opaqueDepth) {
  const auto start = std::chrono::steady_clock::now();
  Image image(camera.width(), camera.height(), options.aov == Aov::kNone ? 3 : 1);
  const std::size_t pixels = static_cast<std::size_t>(image.width) * image.height;
  if (!opaqueDepth.empty() && opaqueDepth.size() != pixels) {
    return fail(ErrorCode::kInvalidArgument,
                "the opaque depth has {} values for an image of {} x {} pixels", opaqueDepth.size(),
                image.width, image.height);
  }
  if (const Image* behind = options.behind;
      behind &&
      (behind->width != image.width || behind->height != image.height || behind->channels != 3)) {
    return fail(ErrorCode::kInvalidArgument,
                "the picture behind has {} x {} x {} values for an image of {} x {} pixels",
                behind->width, behind->height, behind->channels, image.width, image.height);
  }
  if (!options.only.empty() && options.only.size() != pixels) {
    return fail(ErrorCode::kInvalidArgument,
                "a choice among {} pixels for an image of {} x {} pixels", options.only.size(),
                image.width, image.height);
  }
  const Scene scene{camera, media, options, opaqueDepth}, beside{camera, {}, options, opaqueDepth};
  const Window window = windowOf(camera, media);
  const int columns = (image.width + kTile - 1) / kTile;
  const int rows = (image.height + kTile - 1) / kTile;
  const auto caller = std::this_thread::get_id();  // the only one that may talk to `progress`
  std::atomic<bool> stopped = false;
  std::atomic<int> done = 0;
  std::atomic<std::uint64_t> rays = 0, segments = 0, pieces = 0;
  parallelFor(static_cast<std::size_t>(columns) * rows, [&](std::size_t tile) {
    const bool talks = std::this_thread::get_id() == caller;
    if (talks && progress.cancelled())
      stopped = true;
    if (stopped)
      return;
    RenderStats own;
    const int left = static_cast<int>(tile % columns) * kTile,
              top = static_cast<int>(tile / columns) * kTile;
    renderTile(window.meets(left, top, kTile) ? scene : beside, left, top, image, own);
    rays += own.rays, segments += own.segments, pieces += own.pieces;
    ++done;
    if (talks)
      progress.report("rendering", done, columns * rows);
  });
  if (stopped || progress.cancelled()) {
    return fail(ErrorCode::kCancelled, "stopped: {} of {} tiles were rendered", done.load(),
                columns * rows);
  }
  if (stats) {
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - start;
    *stats = {rays, segments, pieces, elapsed.count()};
  }
  return image;
}

}  // namespace volute
