// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/render/sign.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "volute/base/parallel.hpp"
#include "volute/image/srgb.hpp"
#include "volute/image/text.hpp"

namespace volute {
namespace {

constexpr int kSamples = 4;  // across a pixel, for the picture

/// Signs stick to walls: this far behind one they are still before it [m].
constexpr double kOnWall = 1e-3;

/// A point of a sign, 0..1 from its left and from its top.
struct Place {
  double u = 0, v = 0, distance = 0;
};

/// A sign with its directions, and the pixels that it may be seen in.
struct ShownSign {
  const Sign& sign;
  Vec3 right, down;
  int x0 = 0, y0 = 0, x1, y1;

  ShownSign(const Sign& of, const Camera& camera)
      : sign(of), right(of.right()), down(of.down()), x1(camera.width()), y1(camera.height()) {
    if (!camera.distortion().none())
      return;  // its borders may be bent
    Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (int corner = 0; corner < 4; ++corner) {
      const auto at = camera.project(of.position + ((corner & 1) - 0.5) * of.width * right +
                                     (static_cast<int>(corner >> 1) - 0.5) * of.height * down);
      if (!at)
        return;
      low = low.cwiseMin(*at), high = high.cwiseMax(*at);
    }
    constexpr double kBeside = 1;  // pixels
    const auto within = [](double place, int count) {
      return static_cast<int>(std::clamp<double>(place, 0, count));
    };
    x0 = within(std::floor(low.x() - kBeside), x1), y0 = within(std::floor(low.y() - kBeside), y1);
    x1 = within(std::ceil(high.x() + kBeside), x1), y1 = within(std::ceil(high.y() + kBeside), y1);
  }

  bool mayShow(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
};

std::optional<Place> meet(const ShownSign& shown, const Segment& ray) {
  const Sign& sign = shown.sign;
  const double facing = ray.direction.dot(sign.normal);
  if (!(facing < 0))
    return std::nullopt;
  const double s = (sign.position - ray.origin).dot(sign.normal) / facing;
  if (!(s > ray.begin && s < ray.end))
    return std::nullopt;
  const Vec3 from = ray.at(s) - sign.position;
  const Place place{0.5 + from.dot(shown.right) / sign.width,
                    0.5 + from.dot(shown.down) / sign.height, s};
  const bool inside = place.u >= 0 && place.u <= 1 && place.v >= 0 && place.v <= 1;
  return inside ? std::optional(place) : std::nullopt;
}

/// Between the picture's pixels, whose values stand at their centres; its border goes on.
Rgb pictureAt(const Image& picture, double u, double v) {
  const double x = std::clamp(u * picture.width - 0.5, 0.0, picture.width - 1.0);
  const double y = std::clamp(v * picture.height - 0.5, 0.0, picture.height - 1.0);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, picture.width - 1), y1 = std::min(y0 + 1, picture.height - 1);
  Rgb color;
  for (int c = 0; c < 3; ++c) {
    const double top = std::lerp(picture.at(x0, y0, c), picture.at(x1, y0, c), x - x0);
    const double bottom = std::lerp(picture.at(x0, y1, c), picture.at(x1, y1, c), x - x0);
    color[c] = std::lerp(top, bottom, y - y0);
  }
  return color;
}

Rgb averageOver(const Camera& camera, const ShownSign& shown, int x, int y, const Place& centre) {
  Rgb sum = Rgb::Zero();
  int hits = 0;
  for (int i = 0; i < kSamples * kSamples; ++i) {
    const Segment ray = camera.ray(x + (i % kSamples + 0.5) / kSamples,
                                   y + (static_cast<int>(i / kSamples) + 0.5) / kSamples);
    if (const auto place = meet(shown, ray)) {
      sum += pictureAt(shown.sign.picture, place->u, place->v);
      ++hits;
    }
  }
  return hits > 0 ? Rgb(sum / hits) : pictureAt(shown.sign.picture, centre.u, centre.v);
}

}  // namespace

Vec3 Sign::right() const {
  const Vec3 n = normal.normalized();
  const Vec3 up = std::abs(n.z()) > 1 - 1e-9 ? Vec3::UnitY() : Vec3::UnitZ();
  return up.cross(n).normalized();
}

Vec3 Sign::down() const {
  return right().cross(normal.normalized());
}

std::vector<SignPixel> signPixels(const Camera& camera, std::span<const Sign> signs,
                                  std::span<const float> opaqueDepth) {
  if (signs.empty())
    return {};
  std::vector<ShownSign> shown;
  for (const Sign& sign : signs) shown.emplace_back(sign, camera);
  std::vector<std::vector<SignPixel>> rows(static_cast<std::size_t>(camera.height()));
  parallelFor(rows.size(), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    int from = camera.width(), to = 0;
    for (const ShownSign& sign : shown) {
      if (y >= sign.y0 && y < sign.y1)
        from = std::min(from, sign.x0), to = std::max(to, sign.x1);
    }
    for (int x = from; x < to; ++x) {
      const auto pixel = static_cast<std::size_t>(y) * camera.width() + x;
      Segment ray = camera.ray(x + 0.5, y + 0.5);
      const double wall =
          opaqueDepth.empty() ? std::numeric_limits<double>::infinity() : opaqueDepth[pixel];
      ray.end = std::min(ray.end, wall * (1 + 1e-5) + kOnWall);
      std::optional<SignPixel> found;
      Place first;
      for (std::size_t s = 0; s < signs.size(); ++s) {
        const auto place = shown[s].mayShow(x, y) ? meet(shown[s], ray) : std::optional<Place>();
        if (!place)
          continue;
        first = *place;
        ray.end = place->distance;
        found = SignPixel{static_cast<std::int32_t>(pixel),
                          static_cast<std::int32_t>(s),
                          static_cast<float>(std::min(place->distance, wall)),
                          {}};
      }
      if (!found)
        continue;
      const Rgb color =
          averageOver(camera, shown[static_cast<std::size_t>(found->sign)], x, y, first);
      for (int c = 0; c < 3; ++c) found->radiance[c] = static_cast<float>(color[c]);
      rows[row].push_back(*found);
    }
  });
  std::vector<SignPixel> all;
  for (const auto& row : rows) all.insert(all.end(), row.begin(), row.end());
  return all;
}

Image exitPicture() {
  constexpr int kWidth = 512, kHeight = 256;
  constexpr double kCapital = 0.729;  // height of DejaVu's capitals and
  constexpr double kBaseline = 0.93;  // where they stand below a line's top, of the em
  const TextStyle style{.size = 180};
  const Rgb green(srgbDecode(0.0), srgbDecode(0.52), srgbDecode(0.31));
  Image picture(kWidth, kHeight, 3);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i)
    picture.pixels[i] = static_cast<float>(green[i % 3]);
  const TextSize size = textSize("EXIT", style);
  const double left = 0.5 * (kWidth - size.width);
  if (size.height < style.size) {  // letters of dots
    drawText(picture, "EXIT", left, 0.5 * (kHeight - size.height), style, Rgb::Ones());
    return picture;
  }
  // Bold: the letters moved around by half of what their strokes gain.
  constexpr double kGain = 4.5;  // [pixels]
  const double top = 0.5 * (kHeight + kCapital * style.size) - kBaseline * style.size;
  for (int i = 0; i < 16; ++i) {
    const double angle = 2 * std::numbers::pi * i / 16;
    drawText(picture, "EXIT", left + kGain * std::cos(angle), top + kGain * std::sin(angle), style,
             Rgb::Ones());
  }
  return picture;
}

}  // namespace volute
