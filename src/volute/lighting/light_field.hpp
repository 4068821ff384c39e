// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "volute/lighting/lamp.hpp"
#include "volute/medium/any_medium.hpp"

namespace volute {

/// Gives the optical depth from any point to a lamp sooner or better than bricks do.
class KnownDepth {
 public:
  virtual ~KnownDepth() = default;

  virtual double opticalDepth(const Vec3& point) const = 0;

  /// exp(-opticalDepth()) of many points, sooner, within 1e-4.
  virtual void shares(std::span<const Vec3> points, std::span<double> shares) const = 0;
};

/// Where a medium is: its shadow begins there.
struct ShadingBall {
  Vec3 centre = Vec3::Zero();
  double radius = 0;
};

struct LightFieldOptions {
  double tolerance = 2e-3;                    ///< of the transmittance, along each axis of a brick
  int halvings = 8;                           ///< of a brick along an axis, at most
  double finest = 0;                          ///< [m] no cells smaller, but where small media shade
  std::shared_ptr<const KnownDepth> known{};  ///< of what is not among the media; may be null
};

/// How much of a lamp's light several media together let through to any point, surfaces apart:
/// those are asked by rays.
///
/// Known at the nodes of bricks of 8^3 cells along rays from the lamp, as sums of optical depths
/// between the nodes of a ray, and trilinear between. Bricks are halved along each axis on which
/// the values are not linear, and made when a point in them is first asked for: the same values for
/// any order of points and any number of threads. The coordinates of a sun are two across its light
/// and one along it; of a lamp, the faces of a cube around it and the logarithm of the distance.
///
/// Immutable but for the bricks that are made; shared, and used by all threads.
class LightField {
 public:
  /// Transmittance at a place, from the bricks around it.
  struct Sample {
    double share = 1;  ///< of the light, 0..1
    double cell = 0;   ///< [m] below this distance it is all but linear; 0: it is exact
  };

  /// @param lit  where points are asked for; elsewhere each costs a ray. Finite
  LightField(const Lamp& lamp, std::vector<AnyMedium> media, const Box3& lit,
             const LightFieldOptions& options = {});

  /// All bricks at once, where ranks hold a share of the media each: the same on all of them.
  /// Collective.
  /// @param depthsOfAll  of what all hold, along the same ways on each
  LightField(const Lamp& lamp, std::vector<AnyMedium> media, const Box3& lit,
             const LightFieldOptions& options,
             const std::function<void(std::span<const Segment>, std::span<double>)>& depthsOfAll);

  Sample at(const Vec3& point) const;

  /// By a ray, not by bricks.
  double exactly(const Vec3& point) const;

  /// From a point on in any direction, the shadows of finite media are even about so far [m].
  double evenFor(const Vec3& point) const;

  /// The finite media.
  std::span<const ShadingBall> balls() const;

  /// May be null. Its share is a factor beside that of the bricks.
  const KnownDepth* known() const;

  /// There are no media but what is known.
  bool isKnown() const;

  std::uint64_t memoryBytes() const;

  /// All bricks in a row, empty where there are no media, for a shader (gl/glsl/light_field.glsl).
  /// The roots are the first ones; a brick's parts stand together, ordered by the axes along which
  /// it is halved, x fastest.
  struct Bricks {
    static constexpr int kNodes = 9;  ///< of a brick along an axis
    static constexpr int kStride =
        2 + kNodes * kNodes * kNodes;  ///< first part or -1; axes; values

    Mat3 axes = Mat3::Zero();  ///< of a sun: from a point to a place in roots
    Vec3 offset = Vec3::Zero();
    std::array<int, 3> roots{};     ///< along each axis; of a lamp for one of six faces
    double nearest = 1, scale = 1;  ///< of a lamp: roots are scale * log(1 + distance / nearest)
    std::vector<std::uint32_t> words;
  };

  /// @param mostWords  bricks are not halved where that would take more
  Bricks bricks(std::size_t mostWords) const;

  const Lamp& lamp() const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

}  // namespace volute
