// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/diffuse_light.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <random>

#include "volute/lighting/lit_medium.hpp"
#include "volute/math/phase_function.hpp"

namespace volute {
namespace {

constexpr double kReach = 1;  ///< clouds are within a box of twice that

/// A cloud in [-1, 1]^3: extinction `sigma` times a density of at most 1, even in each of 40^3
/// cells.
class DenseCloud {
 public:
  DenseCloud(const std::function<double(const Vec3&)>& density, double sigma) : sigma(sigma) {
    for (int i = 0; i < kCells * kCells * kCells; ++i) {
      const Vec3 cell(i % kCells, i / kCells % kCells, i / (kCells * kCells));
      cells_.push_back(
          static_cast<float>(density(kReach * (2 * (cell.array() + 0.5) / kCells - 1).matrix())));
    }
  }

  Box3 bounds() const { return {Vec3::Constant(-kReach), Vec3::Constant(kReach)}; }

  double extinction(const Vec3& point) const {
    int cell = 0;
    for (int axis = 2; axis >= 0; --axis) {
      const double place = (point[axis] / kReach + 1) * kCells / 2;
      if (!(place >= 0 && place <= kCells))
        return 0;
      cell = cell * kCells + std::min(static_cast<int>(place), kCells - 1);
    }
    return sigma * cells_[static_cast<std::size_t>(cell)];
  }

  Rgb emission(const Vec3&) const { return Rgb::Zero(); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      depths[i] = 0;
      each(segments[i], [&](double begin, double end, double extinction) {
        depths[i] += extinction * (end - begin);
      });
    }
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> out) const {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      out[i].clear();
      each(segments[i], [&](double begin, double end, double extinction) {
        Piece piece;
        piece.begin = begin, piece.end = end;
        piece.extinction.c[0] = extinction;
        out[i].push_back(piece);
      });
    }
  }

  double sigma;

 private:
  static constexpr int kCells = 40;

  template <class Each>
  void each(const Segment& segment, Each&& visit) const {
    const Interval inside = bounds()
                                .intersect(segment.origin, segment.direction)
                                .intersect({segment.begin, segment.end});
    const int count = inside.empty() ? 0 : static_cast<int>(inside.length() / 0.03) + 1;
    for (int k = 0; k < count; ++k) {
      const double begin = inside.begin + inside.length() * k / count;
      const double end = inside.begin + inside.length() * (k + 1) / count;
      visit(begin, end, extinction(segment.at(0.5 * (begin + end))));
    }
  }

  std::vector<float> cells_;
};

/// Smooth values of 0 to 1 that change over a length of 1.
double noiseAt(const Vec3& point) {
  const Vec3 corner = point.array().floor().matrix(), in = point - corner;
  double sum = 0;
  for (unsigned i = 0; i < 8; ++i) {
    double weight = 1;
    std::uint32_t hash = 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<int>(axis);
      const unsigned high = i >> axis & 1;
      const double smooth = in[a] * in[a] * (3 - 2 * in[a]);
      weight *= high ? smooth : 1 - smooth;
      hash = (hash ^ static_cast<std::uint32_t>(static_cast<int>(corner[a]) + 64 +
                                                static_cast<int>(high))) *
             0x9E3779B1U;
      hash ^= hash >> 15;
    }
    sum += weight * (hash & 0xFFFF) / 65535.0;
  }
  return sum;
}

double puffAt(const Vec3& point) {
  const double noise = 0.6 * noiseAt(4 * point) + 0.4 * noiseAt(9 * point + Vec3::Constant(20));
  return std::clamp(3 * (std::max(0.0, 1 - point.norm() / 0.95) + noise - 0.75), 0.0, 1.0);
}

double boxAt(const Vec3& point) {
  return (point.cwiseAbs().array() < Vec3(0.8, 0.6, 0.7).array()).all() ? 1 : 0;
}

/// The mean light of parallel rays in a direction, over a square around the cloud.
struct MeanLight {
  static constexpr double kHalf = 1.2;

  static Segment ray(const Vec3& direction, double across, double up) {
    const Vec3 right = direction.unitOrthogonal();
    return {kHalf * (across * right + up * direction.cross(right)) - 5 * direction, direction, 0,
            10};
  }
};

/// By paths from the eye, with a ray to the sun from each place where they are scattered.
class TracedPaths {
 public:
  TracedPaths(const DenseCloud& cloud, const Scattering& scattering, const Lamp& sun)
      : cloud_(cloud), scattering_(scattering), sun_(sun) {}

  double mean(const Vec3& view, int paths) {
    double sum = 0;
    for (int i = 0; i < paths; ++i)
      sum += path(MeanLight::ray(view, 2 * random() - 1, 2 * random() - 1));
    return sum / paths;
  }

 private:
  double random() { return uniform_(engine_); }

  double path(Segment ray) {
    double light = 0, weight = 1;
    const double g = scattering_.asymmetry;
    while (travels(ray)) {
      const Segment way = sun_.towards(ray.origin);
      double depth = 0;
      cloud_.opticalDepth({&way, 1}, {&depth, 1});
      weight *= scattering_.albedo[0];
      light += weight * std::exp(-depth) * henyeyGreenstein(g, -sun_.direction.dot(ray.direction));
      if (weight < 0.05) {
        if (random() < 0.5)
          break;
        weight *= 2;
      }
      ray.direction = turned(ray.direction, g);
    }
    return light;
  }

  /// To the next place where it is scattered; false: it leaves the cloud.
  bool travels(Segment& ray) {
    const Interval inside =
        cloud_.bounds().intersect(ray.origin, ray.direction).intersect({0, 100});
    for (double s = inside.begin; !inside.empty();) {
      s -= std::log(1 - random()) / cloud_.sigma;
      if (s >= inside.end)
        return false;
      if (random() * cloud_.sigma < cloud_.extinction(ray.at(s))) {
        ray.origin = ray.at(s);
        return true;
      }
    }
    return false;
  }

  Vec3 turned(const Vec3& way, double g) {
    const double u = random(), s = (1 - g * g) / (1 - g + 2 * g * u);
    const double cosine = g == 0 ? 1 - 2 * u : (1 + g * g - s * s) / (2 * g);
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    const double turn = 2 * std::numbers::pi * random();
    const Vec3 across = way.unitOrthogonal();
    return (cosine * way + sine * (std::cos(turn) * across + std::sin(turn) * way.cross(across)))
        .normalized();
  }

  const DenseCloud& cloud_;
  Scattering scattering_;
  Lamp sun_;
  std::mt19937_64 engine_{7};
  std::uniform_real_distribution<double> uniform_{0, 1};
};

Lamp sunLamp() {
  Lamp sun;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = Vec3(0.3, 0.5, -0.8).normalized();
  return sun;
}

LitMedium litCloud(const DenseCloud& cloud, const Scattering& scattering, bool multiple) {
  const Lamp sun = sunLamp();
  const AnyMedium medium(cloud);
  LitMedium::Options options{scattering, cloud.bounds(), 0.05};
  if (multiple) {
    options.again = std::make_shared<const DiffuseLight>(DiffuseLight::Request{
        .medium = medium, .box = cloud.bounds(), .scattering = scattering, .lamps = {&sun, 1}});
  }
  return {medium,
          {LightField(sun, {medium}, cloud.bounds(), {.tolerance = 0.02, .finest = 0.03})},
          options};
}

double meanOf(const LitMedium& lit, const Vec3& view) {
  constexpr int kAcross = 20;
  std::vector<Segment> rays;
  for (int i = 0; i < kAcross * kAcross; ++i)
    rays.push_back(MeanLight::ray(view, 2 * (i % kAcross + 0.5) / kAcross - 1,
                                  2 * (i / kAcross + 0.5) / kAcross - 1));
  std::vector<Radiance> light(rays.size());
  lit.radiance(rays, light);
  double sum = 0;
  for (const Radiance& one : light) sum += one.emitted[0];
  return sum / static_cast<double>(rays.size());
}

struct CloudCase {
  const char* name;
  DenseCloud cloud;
  Scattering scattering;
};

TEST(DiffuseLight, DenseCloudsAreAsBrightAsTracedPaths) {
  const Vec3 sun = sunLamp().direction;
  const Vec3 views[] = {sun, Vec3(0.8, -0.6, 0), -sun, Vec3(-0.3, 0.9, 0.1).normalized()};
  const CloudCase cases[] = {
      {"box, depth 10, albedo 0.9, g 0.5", {boxAt, 10 / 1.4}, {Rgb::Constant(0.9), 0.5}},
      {"box, depth 5, albedo 0.99, g 0", {boxAt, 5 / 1.4}, {Rgb::Constant(0.99), 0}},
      {"puff, depth 40, albedo 0.99, g 0.6", {puffAt, 40}, {Rgb::Constant(0.99), 0.6}},
      {"puff, depth 50, albedo 0.999, g 0.85", {puffAt, 50}, {Rgb::Constant(0.999), 0.85}}};
  for (const CloudCase& one : cases) {
    TracedPaths paths(one.cloud, one.scattering, sunLamp());
    const LitMedium once = litCloud(one.cloud, one.scattering, false);
    const LitMedium again = litCloud(one.cloud, one.scattering, true);
    double traced = 0, single = 0, multiple = 0;
    for (const Vec3& view : views) {
      traced += paths.mean(view, 15000);
      single += meanOf(once, view);
      multiple += meanOf(again, view);
    }
    std::printf("%s: single %.3f, multiple %.3f of traced paths\n", one.name, single / traced,
                multiple / traced);
    EXPECT_NEAR(multiple / traced, 1, 0.1) << one.name;
    EXPECT_LT(single, multiple) << one.name;
  }
}

TEST(DiffuseLight, NoneIsLostWhereNothingAbsorbs) {
  // What enters a thick cloud that absorbs nothing leaves it: the light of all ways out.
  const DenseCloud cloud(boxAt, 30);
  const Lamp sun = sunLamp();
  const DiffuseLight light({.medium = AnyMedium(cloud),
                            .box = cloud.bounds(),
                            .scattering = {Rgb::Ones(), 0},
                            .lamps = {&sun, 1}});
  const Vec3 half(0.8, 0.6, 0.7);
  double enters = 0;
  for (int axis = 0; axis < 3; ++axis)
    enters += 4 * half.prod() / half[axis] * std::abs(sun.direction[axis]);
  // The flux at the faces of the outer box, where at most half of the light leaves.
  double leaves = 0;
  constexpr int kAcross = 16;
  for (int face = 0; face < 6; ++face) {
    for (int k = 0; k < kAcross * kAcross; ++k) {
      Vec3 point;
      point[face / 2] = face % 2 ? 1 : -1;
      point[(face / 2 + 1) % 3] = 2 * (k % kAcross + 0.5) / kAcross - 1;
      point[(face / 2 + 2) % 3] = 2 * (k / kAcross + 0.5) / kAcross - 1;
      leaves += 4 * std::numbers::pi * light.at(point)[0] / 2 * 4 / (kAcross * kAcross);
    }
  }
  EXPECT_NEAR(leaves / enters, 1, 0.03);
}

TEST(DiffuseLight, ColoursAreThoseOfAlbedoAndLamps) {
  const DenseCloud cloud(boxAt, 10);
  Lamp sun = sunLamp();
  sun.intensity = Rgb(1, 0.5, 0);
  const DiffuseLight light({.medium = AnyMedium(cloud),
                            .box = cloud.bounds(),
                            .scattering = {Rgb(0.9, 0.9, 0.9), 0.3},
                            .lamps = {&sun, 1}});
  const Rgb middle = light.at(Vec3::Zero());
  EXPECT_GT(middle[0], 0);
  EXPECT_NEAR(middle[1] / middle[0], 0.5, 1e-3);
  EXPECT_EQ(middle[2], 0);
  EXPECT_EQ(light.at(Vec3(3, 0, 0)).maxCoeff(), 0);
}

TEST(DiffuseLight, SurfacesKeepItOut) {
  // A wall across the box at x = 0, and a sun from the left.
  const DenseCloud cloud([](const Vec3&) { return 1.0; }, 3);
  Lamp sun = sunLamp();
  sun.direction = Vec3(1, 0, -0.2).normalized();
  const Blocks wall = [](std::span<const Segment> ways, std::span<std::uint8_t> blocked) {
    for (std::size_t i = 0; i < ways.size(); ++i) {
      const double x = ways[i].origin.x(), to = x + ways[i].direction.x() * ways[i].end;
      blocked[i] = (x - 1e-3 > 0) != (to - 1e-3 > 0);
    }
  };
  const DiffuseLight light({.medium = AnyMedium(cloud),
                            .box = cloud.bounds(),
                            .scattering = {Rgb::Constant(0.95), 0.3},
                            .lamps = {&sun, 1},
                            .blocks = wall});
  EXPECT_GT(light.at(Vec3(-0.3, 0, 0))[0], 1e-3);
  EXPECT_LT(light.at(Vec3(0.3, 0, 0))[0], 1e-3 * light.at(Vec3(-0.3, 0, 0))[0]);
}

}  // namespace
}  // namespace volute
