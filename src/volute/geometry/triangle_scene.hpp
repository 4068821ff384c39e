// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/math/box.hpp"
#include "volute/math/vec.hpp"
#include "volute/medium/medium.hpp"

namespace volute {

/// How an opaque surface looks: what it reflects, the same in all directions (Lambert), and what it
/// sends out by itself. Both sides look alike.
struct Material {
  Rgb baseColor = Rgb::Constant(0.8);  ///< share of the light that is reflected, linear RGB, 0..1
  Rgb emission = Rgb::Zero();          ///< radiance, linear RGB
};

/// A flat piece of an opaque surface. Its front is where its corners go round anticlockwise; both
/// sides stop light. One without area is never met.
struct Triangle {
  Vec3 corners[3];             ///< [m], in the world
  std::uint32_t material = 0;  ///< its place in the scene's list

  /// (b - a) x (c - a): towards the front, twice the area long [m2].
  Vec3 normal() const {
    const Vec3 a = corners[1] - corners[0], b = corners[2] - corners[0];
    return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(),
            a.x() * b.y() - a.y() * b.x()};
  }
};

/// What a file of geometry holds.
struct TriangleMesh {
  std::vector<Triangle> triangles;
  std::vector<Material> materials;  ///< at least as many as the triangles name
};

/// Where a segment meets a surface first.
struct Hit {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  double distance = std::numeric_limits<double>::infinity();  ///< [m], the segment's parameter
  std::uint32_t triangle = kNone;                             ///< its place in the scene's list

  bool found() const { return triangle != kNone; }
};

/// Where light comes from: a point, or so far away that its rays are parallel.
struct LightPoint {
  Vec3 place = Vec3::UnitZ();  ///< [m]; of a far one the direction to it, of any length
  bool far = true;
};

/// Moves triangles: p becomes transform * (p, 1). Affine; mirrors too.
std::vector<Triangle> transformed(std::span<const Triangle> triangles, const Mat4& transform);

/// Opaque surfaces. All calls are const and thread-safe and take segments in batches. A segment
/// meets a surface at begin < s < end, so that one which starts on it, to the last bit, does not
/// meet it. Neighbouring triangles leave no gap. Cheap to copy: the triangles are shared and const.
class TriangleScene {
 public:
  /// Who answers.
  enum class Execution {
    kFast,       ///< Embree where the library was built with it, else the reference
    kReference,  ///< a tree of boxes, in double
  };

  /// Without any triangle: nothing is met.
  TriangleScene();

  /// @param materials  at least as many as the triangles name; empty: one of the default material
  /// kInvalidArgument for a corner that is not finite or a material that is not there; kTooLarge
  /// for more than 2^31 triangles.
  [[nodiscard]] static Result<TriangleScene> build(std::vector<Triangle> triangles,
                                                   std::vector<Material> materials = {},
                                                   Execution execution = Execution::kFast);

  /// The first surface on each segment, its distance in double from the triangle. Where several
  /// are as near, any of them.
  void nearest(std::span<const Segment> segments, std::span<Hit> hits) const;

  /// 1 where something is in the way, else 0.
  void occluded(std::span<const Segment> segments, std::span<std::uint8_t> blocked) const;

  /// Replaces `dark` by the parts of a segment that the surfaces keep a light from, in order and
  /// apart from each other. Exact, from the triangles that the plane through the segment and the
  /// light cuts; no samples. Those of a far light by a tree of what it sees, which is kept.
  void shadows(const Segment& segment, const LightPoint& light, std::vector<Interval>& dark) const;

  std::span<const Triangle> triangles() const;
  std::span<const Material> materials() const;
  const Box3& bounds() const;  ///< empty without triangles; flat where all of them are

  bool empty() const { return triangles().empty(); }

  const Material& materialOf(const Hit& hit) const {
    return materials()[triangles()[hit.triangle].material];
  }

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace volute
