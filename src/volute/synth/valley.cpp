// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/synth/valley.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "volute/base/parallel.hpp"
#include "volute/synth/noise.hpp"

namespace volute {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double smoothstep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// 0..1, of a place on a lattice.
double random(std::uint32_t seed, int i, int j) {
  const auto place = static_cast<std::uint32_t>(i) * 0x9E3779B9u;
  return mix(seed ^ mix(place ^ mix(static_cast<std::uint32_t>(j)))) / 4294967296.0;
}

/// Smooth, 0..1, with features of 1.
double noise(std::uint32_t seed, double x, double y) {
  const double i = std::floor(x), j = std::floor(y);
  const double u = smoothstep(0, 1, x - i), v = smoothstep(0, 1, y - j);
  const int a = static_cast<int>(i), b = static_cast<int>(j);
  const double low = std::lerp(random(seed, a, b), random(seed, a + 1, b), u);
  const double high = std::lerp(random(seed, a, b + 1), random(seed, a + 1, b + 1), u);
  return std::lerp(low, high, v);
}

/// Four octaves, 0..1.
double rough(std::uint32_t seed, double x, double y) {
  double sum = 0, weight = 0.5;
  for (std::uint32_t octave = 0; octave < 4; ++octave) {
    sum += weight * noise(seed + octave, x, y);
    x *= 2, y *= 2, weight /= 2;
  }
  return sum / 0.9375;
}

Rgb rgb(double r, double g, double b) {
  return Rgb(r, g, b);
}

}  // namespace

Valley::Valley(std::uint32_t seed)
    : seed_(mix(seed + 77)),
      heights_(static_cast<std::size_t>(kSamples) * kSamples),
      covers_(heights_.size()),
      lit_(heights_.size(), 1) {
  parallelFor(kSamples, [&](std::size_t j) {
    for (int i = 0; i < kSamples; ++i) {
      const double x = i * kStep, y = static_cast<double>(j) * kStep;
      const double beside = std::abs(x - river(y));
      const std::size_t at = index(i, static_cast<int>(j));
      heights_[at] = static_cast<float>(ground(x, y));
      const bool wood = rough(seed_ + 40, x / 60, y / 60) > 0.42;
      covers_[at] = beside < 5            ? Cover::kWater
                    : heights_[at] > 75   ? Cover::kRock
                    : beside > 45 && wood ? Cover::kForest
                                          : Cover::kMeadow;
    }
  });
  plantTrees();
  buildVillage();
  findBlocks();
  castShadows();
}

double Valley::river(double y) const {
  return 256 + 55 * std::sin(y / 80) + 12 * std::sin(y / 31 + 1);
}

double Valley::ground(double x, double y) const {
  const double beside = std::abs(x - river(y));
  const double banks = smoothstep(4, 7, beside) * 1.5 - 1;
  const double hills =
      85 * smoothstep(20, 230, beside) * (0.75 + 0.5 * rough(seed_, x / 130, y / 130));
  const double bumps = 14 * (rough(seed_ + 9, x / 45, y / 45) - 0.5) * smoothstep(15, 90, beside);
  // Hills close both ends.
  const double ends = 70 * smoothstep(0.72 * kSide, kSide, y) + 45 * smoothstep(50, 0, y);
  return banks + hills + bumps + ends;
}

double Valley::height(double x, double y) const {
  const double u = std::clamp(x / kStep, 0.0, kSamples - 1.001);
  const double v = std::clamp(y / kStep, 0.0, kSamples - 1.001);
  const int i = static_cast<int>(u), j = static_cast<int>(v);
  const float* low = &heights_[index(i, j)];
  const float* high = &heights_[index(i, j + 1)];
  return std::lerp(std::lerp(double(low[0]), double(low[1]), u - i),
                   std::lerp(double(high[0]), double(high[1]), u - i), v - j);
}

void Valley::plantTrees() {
  constexpr double kApart = 5;
  const int count = static_cast<int>(kSide / kApart);
  for (int b = 1; b < count - 1; ++b) {
    for (int a = 1; a < count - 1; ++a) {
      const double x = (a + 0.9 * random(seed_ + 1, a, b)) * kApart;
      const double y = (b + 0.9 * random(seed_ + 2, a, b)) * kApart;
      const std::size_t here = index(static_cast<int>(x / kStep), static_cast<int>(y / kStep));
      const double chance = covers_[here] == Cover::kForest   ? 0.85
                            : covers_[here] == Cover::kMeadow ? 0.05
                                                              : 0;
      if (random(seed_ + 3, a, b) > chance)
        continue;
      const double tall = 6 + 8 * random(seed_ + 4, a, b), radius = 0.2 * tall + 0.5;
      const double base = ground(x, y);
      const int reach = static_cast<int>(radius / kStep) + 1;
      const int i0 = static_cast<int>(x / kStep), j0 = static_cast<int>(y / kStep);
      for (int j = std::max(0, j0 - reach); j <= std::min(kSamples - 1, j0 + reach); ++j) {
        for (int i = std::max(0, i0 - reach); i <= std::min(kSamples - 1, i0 + reach); ++i) {
          const double away = std::hypot(i * kStep - x, j * kStep - y);
          const double top = base + 1 + tall * (1 - away / radius);
          if (away < radius && top > heights_[index(i, j)]) {
            heights_[index(i, j)] = static_cast<float>(top);
            covers_[index(i, j)] = Cover::kCrown;
          }
        }
      }
    }
  }
}

void Valley::buildHouse(const Vec3& at, double length, double width, double wall, double turn) {
  const double c = std::cos(turn), s = std::sin(turn), reach = length + width;
  const double roof = 0.45 * width;
  for (int j = static_cast<int>((at.y() - reach) / kStep); j * kStep < at.y() + reach; ++j) {
    for (int i = static_cast<int>((at.x() - reach) / kStep); i * kStep < at.x() + reach; ++i) {
      if (i < 0 || j < 0 || i >= kSamples || j >= kSamples)
        continue;
      const double dx = i * kStep - at.x(), dy = j * kStep - at.y();
      const double along = std::abs(c * dx + s * dy), across = std::abs(c * dy - s * dx);
      const std::size_t place = index(i, j);
      if (along < 0.5 * length + 2 && across < 0.5 * width + 2 && covers_[place] != Cover::kHouse) {
        heights_[place] = static_cast<float>(std::min(ground(i * kStep, j * kStep), at.z()));
        covers_[place] = Cover::kMeadow;
      }
      if (along < 0.5 * length && across < 0.5 * width) {
        heights_[place] = static_cast<float>(at.z() + wall + roof * (1 - 2 * across / width));
        covers_[place] = Cover::kHouse;
      }
    }
  }
}

void Valley::buildVillage() {
  for (int k = 0; k < 18; ++k) {
    const double y = 170 + 8.5 * k + 4 * random(seed_ + 5, k, 0);
    const double side = k % 2 ? 1 : -1;
    const double x = river(y) + side * (14 + 22 * random(seed_ + 6, k, 0));
    const Vec3 at(x, y, ground(x, y));
    buildHouse(at, 8 + 5 * random(seed_ + 7, k, 0), 6.5, 3.5,
               std::numbers::pi * random(seed_ + 8, k, 0));
  }
  const double y = 236, x = river(y) - 16;
  const Vec3 church(x, y, ground(x, y));
  buildHouse(church, 18, 9, 7, 0.3);
  buildHouse(church + Vec3(-9, -3, 0), 4.5, 4.5, 19, 0.3);
}

void Valley::findBlocks() {
  for (int level = 0; level < kLevels; ++level) {
    const int side = kSides[level], blocks = (kSamples - 1) / side;
    std::vector<float>& highest = highest_[level];
    highest.assign(static_cast<std::size_t>(blocks) * blocks, -1e9F);
    for (int j = 0; j < blocks; ++j) {
      for (int i = 0; i < blocks; ++i) {
        float& most = highest[static_cast<std::size_t>(j) * blocks + i];
        for (int y = j * side; y <= (j + 1) * side; ++y) {
          const auto row = heights_.begin() + static_cast<std::ptrdiff_t>(index(i * side, y));
          most = std::max(most, *std::max_element(row, row + side + 1));
        }
      }
    }
  }
}

void Valley::castShadows() {
  std::vector<float> sharp(lit_.size());
  parallelFor(kSamples, [&](std::size_t row) {
    const int j = static_cast<int>(row);
    for (int i = 0; i < kSamples; ++i) {
      const Vec3 point(i * kStep, j * kStep, heights_[index(i, j)] + 0.2);
      sharp[index(i, j)] = std::isinf(hit(point, towardsSun(), 0.5)) ? 1.0F : 0.0F;
    }
  });
  parallelFor(kSamples, [&](std::size_t row) {
    const int j = static_cast<int>(row);
    for (int i = 0; i < kSamples; ++i) {
      float sum = 0, count = 0;
      for (int b = std::max(0, j - 1); b <= std::min(kSamples - 1, j + 1); ++b)
        for (int a = std::max(0, i - 1); a <= std::min(kSamples - 1, i + 1); ++a)
          sum += sharp[index(a, b)], count += 1;
      lit_[index(i, j)] = sum / count;
    }
  });
}

Vec3 Valley::towardsSun() {
  return Vec3(0.45, 0.85, 0.42).normalized();
}

double Valley::hitBySteps(const Vec3& eye, const Vec3& direction, double begin, double end) const {
  const auto aboveAt = [&](double s) {
    return eye.z() + s * direction.z() -
           height(eye.x() + s * direction.x(), eye.y() + s * direction.y());
  };
  const double step = 0.7 * kStep / std::max(direction.head<2>().norm(), 1e-3);
  double from = begin, above = aboveAt(from);
  if (above <= 0)
    return begin;
  while (from < end) {
    const double to = std::min(from + step, end + 1e-6), next = aboveAt(to);
    if (next <= 0)
      return from + (to - from) * above / (above - next);
    from = to, above = next;
  }
  return kInfinity;
}

double Valley::hitInBlocks(int level, const Vec3& eye, const Vec3& direction, double begin,
                           double end) const {
  const int blocks = (kSamples - 1) / kSides[level];
  const double side = kSides[level] * kStep;
  for (double s = begin; s < end;) {
    const Vec3 at = eye + (s + 1e-7) * direction;
    const int block[2] = {std::clamp(static_cast<int>(at.x() / side), 0, blocks - 1),
                          std::clamp(static_cast<int>(at.y() / side), 0, blocks - 1)};
    double leave = end;
    for (int axis = 0; axis < 2; ++axis) {
      const double d = direction[axis];
      if (std::abs(d) > 1e-9)
        leave =
            std::min(leave, std::max(((block[axis] + (d > 0)) * side - eye[axis]) / d, s + 1e-6));
    }
    const double lowest = eye.z() + (direction.z() < 0 ? leave : s) * direction.z();
    if (lowest <= highest_[level][static_cast<std::size_t>(block[1]) * blocks + block[0]]) {
      const double found = level > 0 ? hitInBlocks(level - 1, eye, direction, s, leave)
                                     : hitBySteps(eye, direction, s, leave);
      if (found < kInfinity)
        return found;
    }
    s = leave;
  }
  return kInfinity;
}

double Valley::hit(const Vec3& eye, const Vec3& direction, double begin) const {
  const Box3 box{Vec3(0, 0, -1e6), Vec3(kSide, kSide, 1e6)};
  const Interval inside = box.intersect(eye, direction).intersect({begin, 1e5});
  return inside.empty() ? kInfinity
                        : hitInBlocks(kLevels - 1, eye, direction, inside.begin, inside.end);
}

Rgb Valley::sky(const Vec3& direction) const {
  const double up = std::clamp(direction.z(), 0.0, 1.0);
  const double sun = std::max(0.0, direction.dot(towardsSun()));
  const Rgb air =
      rgb(0.62, 0.70, 0.78) + (rgb(0.16, 0.32, 0.62) - rgb(0.62, 0.70, 0.78)) * std::sqrt(up);
  return air + rgb(0.9, 0.62, 0.3) * (0.35 * std::pow(sun, 8) + 1.5 * std::pow(sun, 400));
}

Rgb Valley::shade(const Vec3& point) const {
  constexpr double kWide = 0.6 * kStep;
  const double x = point.x(), y = point.y();
  const Vec3 normal = Vec3(height(x - kWide, y) - height(x + kWide, y),
                           height(x, y - kWide) - height(x, y + kWide), 2 * kWide)
                          .normalized();
  const int i = std::clamp(static_cast<int>(x / kStep + 0.5), 0, kSamples - 1);
  const int j = std::clamp(static_cast<int>(y / kStep + 0.5), 0, kSamples - 1);
  const double speckle = 0.8 + 0.4 * noise(seed_ + 20, x / 1.5, y / 1.5);
  Rgb albedo = rgb(0.16, 0.24, 0.06) * (0.7 + 0.6 * rough(seed_ + 21, x / 20, y / 20));
  switch (covers_[index(i, j)]) {
    case Cover::kMeadow:
      break;
    case Cover::kForest:
      albedo = rgb(0.07, 0.10, 0.03);
      break;
    case Cover::kRock:
      albedo = rgb(0.26, 0.25, 0.21);
      break;
    case Cover::kWater:
      albedo = rgb(0.06, 0.12, 0.17);
      break;
    case Cover::kCrown:
      albedo = rgb(0.05, 0.11, 0.035);
      break;
    case Cover::kHouse:
      albedo = normal.z() < 0.55 ? rgb(0.62, 0.57, 0.47) : rgb(0.36, 0.12, 0.07);
      break;
  }
  const double facing = std::max(0.0, normal.dot(towardsSun()));
  const Rgb light = rgb(2.6, 2.1, 1.45) * facing * double(lit_[index(i, j)]) +
                    rgb(0.34, 0.42, 0.55) * (0.6 + 0.4 * normal.z());
  return albedo * speckle * light;
}

Valley::Frame Valley::look(const Camera& camera) const {
  Frame frame{Image(camera.width(), camera.height()), Image(camera.width(), camera.height(), 1)};
  parallelFor(camera.height(), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < camera.width(); ++x) {
      const Segment middle = camera.ray(x + 0.5, y + 0.5);
      const double begin = std::isinf(middle.begin) ? -1e4 : middle.begin;
      frame.depth.at(x, y) = static_cast<float>(hit(middle.origin, middle.direction, begin) *
                                                middle.direction.dot(camera.forward()));
      Rgb sum = Rgb::Zero();
      for (int k = 0; k < 4; ++k) {
        const Segment ray = camera.ray(x + 0.25 + 0.5 * (k % 2), y + 0.25 + 0.5 * (k / 2));
        const double s = hit(ray.origin, ray.direction, begin);
        sum += std::isinf(s) ? sky(ray.direction) : shade(ray.at(s));
      }
      for (int c = 0; c < 3; ++c) frame.color.at(x, y, c) = static_cast<float>(sum[c] / 4);
    }
  });
  return frame;
}

TriangleMesh Valley::surfaces(int every) const {
  TriangleMesh mesh;
  for (const Rgb& color : {rgb(0.16, 0.24, 0.06), rgb(0.07, 0.10, 0.03), rgb(0.26, 0.25, 0.21),
                           rgb(0.06, 0.12, 0.17), rgb(0.05, 0.11, 0.035), rgb(0.36, 0.12, 0.07)})
    mesh.materials.push_back({color, Rgb::Zero()});  // in the order of Cover
  const auto corner = [&](int i, int j) {
    return Vec3(i * kStep, j * kStep, heights_[index(i, j)]);
  };
  for (int j = 0; j + every < kSamples; j += every) {
    for (int i = 0; i + every < kSamples; i += every) {
      const auto cover = static_cast<std::uint32_t>(covers_[index(i + every / 2, j + every / 2)]);
      const Vec3 here = corner(i, j), across = corner(i + every, j + every);
      mesh.triangles.push_back({{here, corner(i + every, j), across}, cover});
      mesh.triangles.push_back({{here, across, corner(i, j + every)}, cover});
    }
  }
  return mesh;
}

Image Valley::fogMap(int size) const {
  Image map(size, size, 1);
  for (int row = 0; row < size; ++row) {
    for (int i = 0; i < size; ++i) {
      const double x = (i + 0.5) * kSide / size, y = (size - row - 0.5) * kSide / size;
      const double beside = std::abs(x - river(y));
      const double low = std::exp(-std::pow(beside / 42, 2));
      const double banks = smoothstep(0.42, 0.66, rough(seed_ + 30, x / 55, y / 55));
      const double value = std::clamp(
          low * (0.12 + 0.95 * banks) + 0.25 * banks * std::exp(-std::pow(beside / 95, 2)), 0.0,
          1.0);
      map.at(i, row) = static_cast<float>(std::round(255 * value) / 255);
    }
  }
  return map;
}

View3 Valley::view() const {
  const Vec3 eye(river(95) + 26, 95, 0);
  return {eye + Vec3(0, 0, height(eye.x(), eye.y()) + 13), Vec3(river(240) - 4, 250, 5)};
}

View3 Valley::flight(double share) const {
  const double y = 70 + 215 * share;
  const double turn = 0.6 * std::sin(2 * std::numbers::pi * share);
  const Vec3 eye(river(y) + 14 * turn, y, 17 + 9 * std::cos(2 * std::numbers::pi * share));
  const double ahead = y + 75;
  return {eye, Vec3(river(ahead), ahead, 7 + 4 * share)};
}

}  // namespace volute
