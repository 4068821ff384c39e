// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
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

/// An opaque surface that is not made of triangles.
class CurvedSurface {
 public:
  virtual ~CurvedSurface() = default;

  /// Where a segment meets it first, at begin < s < end.
  virtual std::optional<double> nearest(const Segment& segment) const = 0;

  /// Its normal where a segment meets it, of unit length: outwards, against the segment where that
  /// comes from outside.
  virtual Vec3 outward(const Segment& segment, double distance) const = 0;

  /// How far its shape may stand out over the plane of a normal nearby [m]: it casts no shadow on
  /// what is so near to it.
  virtual double roughness() const = 0;

  virtual const Box3& bounds() const = 0;

  /// Appends flat pieces for it, whose corners lie on it.
  virtual void addTriangles(std::uint32_t material, std::vector<Triangle>& to) const = 0;

  /// p becomes transform * (p, 1).
  virtual std::shared_ptr<const CurvedSurface> moved(const Mat4& transform) const = 0;
};

/// One in a scene.
struct CurvedPart {
  std::shared_ptr<const CurvedSurface> surface;
  std::uint32_t material = 0;  ///< its place in the scene's list
};

/// What a file of geometry holds.
struct TriangleMesh {
  std::vector<Triangle> triangles;
  std::vector<Material> materials;     ///< at least as many as the triangles name
  std::vector<CurvedPart> curved{};    ///< the same
  std::vector<std::string> remarks{};  ///< what its file says beyond that, one sentence each
  char up = 0;  ///< the axis that points upwards for what wrote the file; 0: not known
};

/// Where a segment meets a surface first.
struct Hit {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::uint32_t kCurved = 1u << 31;  ///< from here on they are curved surfaces

  double distance = std::numeric_limits<double>::infinity();  ///< [m], the segment's parameter
  std::uint32_t triangle = kNone;                             ///< its place in the scene's list

  bool found() const { return triangle != kNone; }

  bool onCurved() const { return found() && triangle >= kCurved; }
};

/// Where light comes from: a point, or so far away that its rays are parallel.
struct LightPoint {
  Vec3 place = Vec3::UnitZ();  ///< [m]; of a far one the direction to it, of any length
  bool far = true;
};

/// Moves triangles: p becomes transform * (p, 1). Affine; mirrors too.
std::vector<Triangle> transformed(std::span<const Triangle> triangles, const Mat4& transform);

/// Appends another mesh with its materials.
void append(TriangleMesh& to, TriangleMesh mesh);

/// Opaque surfaces. All calls are const and thread-safe and take segments in batches. A segment
/// meets a surface at begin < s < end, so that one which starts on it, to the last bit, does not
/// meet it. Neighbouring triangles leave no gap. Cheap to copy: the triangles are shared and const.
class TriangleScene {
 public:
  /// Whether Embree or the tree of this module finds hits.
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
  [[nodiscard]] static Result<TriangleScene> of(TriangleMesh mesh,
                                                Execution execution = Execution::kFast);

  /// The first surface on each segment, its distance in double from the triangle or the curved
  /// surface. Where several are as near, any of them.
  void nearest(std::span<const Segment> segments, std::span<Hit> hits) const;

  /// 1 where something is in the way, else 0.
  void occluded(std::span<const Segment> segments, std::span<std::uint8_t> blocked) const;

  /// Replaces `dark` by the parts of a segment that the surfaces keep a light from, in order and
  /// apart from each other. Exact, from the triangles that the plane through the segment and the
  /// light cuts, those of curved surfaces too; no samples. Those of a far light by a tree of what
  /// it sees, which is kept.
  void shadows(const Segment& segment, const LightPoint& light, std::vector<Interval>& dark) const;

  /// All of it, curved surfaces as flat pieces, which are made when they are asked for first.
  std::span<const Triangle> triangles() const;
  /// Which curved surface one of those stands for; null: it is flat by itself.
  const CurvedSurface* surfaceOf(std::size_t triangle) const;
  /// All triangles in one list; Hit::triangle is a position in it.
  std::span<const Triangle> flat() const;
  std::span<const CurvedPart> curved() const;
  std::span<const Material> materials() const;
  const Box3& bounds() const;  ///< empty without surfaces; flat where all of them are

  /// A copy of what it was built of.
  TriangleMesh mesh() const {
    return {{flat().begin(), flat().end()},
            {materials().begin(), materials().end()},
            {curved().begin(), curved().end()}};
  }

  bool empty() const { return flat().empty() && curved().empty(); }

  const Material& materialOf(const Hit& hit) const {
    return materials()[hit.onCurved() ? curved()[hit.triangle - Hit::kCurved].material
                                      : flat()[hit.triangle].material];
  }

  /// The unit normal where a segment met something: towards the front of a triangle, outwards of a
  /// curved surface.
  Vec3 outward(const Segment& segment, const Hit& hit) const {
    return hit.onCurved()
               ? curved()[hit.triangle - Hit::kCurved].surface->outward(segment, hit.distance)
               : Vec3(flat()[hit.triangle].normal().normalized());
  }

  /// CurvedSurface::roughness(), 0 of triangles.
  double roughness(const Hit& hit) const {
    return hit.onCurved() ? curved()[hit.triangle - Hit::kCurved].surface->roughness() : 0;
  }

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace volute
