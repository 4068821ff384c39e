// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/tet_sight.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

/// Gaps in the mesh shorter than this are rounding [m].
constexpr double kTolerance = 1e-5;
/// So near to the target a face counts as behind it [m].
constexpr double kRounding = 1e-8;

/// Where a ray leaves a tet, and the field there.
struct Exit {
  double at = 0;
  int across = -1;  ///< the vertex across the face
  double value = 0;
};

/// A tet as its walk needs it: shares are 6 times the volumes over the faces.
class TetRay {
 public:
  TetRay(const TetMesh& mesh, std::int32_t tet, const Vec3& origin, const Vec3& direction) {
    const Tet& v = mesh.tets()[static_cast<std::size_t>(tet)];
    const auto vertices = mesh.vertices();
    const Vec3 a = vertices[v[0]];
    const Vec3 e1 = vertices[v[1]] - a, e2 = vertices[v[2]] - a, e3 = vertices[v[3]] - a;
    const Vec3 n1 = e2.cross(e3), n2 = e3.cross(e1), n3 = e1.cross(e2);
    const double scale = 1 / e1.dot(n1);
    const Vec3 from = origin - a;
    share_[1] = scale * n1.dot(from), slope_[1] = scale * n1.dot(direction);
    share_[2] = scale * n2.dot(from), slope_[2] = scale * n2.dot(direction);
    share_[3] = scale * n3.dot(from), slope_[3] = scale * n3.dot(direction);
    share_[0] = 1 - share_[1] - share_[2] - share_[3];
    slope_[0] = -slope_[1] - slope_[2] - slope_[3];
  }

  /// The field along the ray: c0 + c1 s.
  void field(const float* values, const Tet& tet, double& c0, double& c1) const {
    c0 = c1 = 0;
    for (int k = 0; k < 4; ++k) {
      c0 += share_[k] * values[tet[k]];
      c1 += slope_[k] * values[tet[k]];
    }
  }

  /// The nearest face ahead; `across` is -1 when two are equally near, so that the way on is
  /// not sure.
  Exit exit() const {
    Exit exit;
    exit.at = std::numeric_limits<double>::infinity();
    double second = exit.at;
    for (int k = 0; k < 4; ++k) {
      if (!(slope_[k] < 0))
        continue;
      const double at = -share_[k] / slope_[k];
      if (at < exit.at) {
        second = exit.at;
        exit.at = at, exit.across = k;
      } else if (at < second) {
        second = at;
      }
    }
    if (!(second - exit.at > 1e-9 * (1 + std::abs(exit.at))))
      exit.across = -1;
    return exit;
  }

 private:
  double share_[4], slope_[4];
};

Segment segmentOf(const SightLine& line) {
  const double length = line.length();
  const Vec3 direction = length > 0 ? Vec3((line.target - line.eye) / length) : Vec3::UnitX();
  return {line.eye, direction, 0, length};
}

}  // namespace

TetInstant::TetInstant(std::shared_ptr<const TetLocator> locator, std::vector<float> extinction)
    : locator_(std::move(locator)), extinction_(std::move(extinction)) {
  VOLUTE_ASSERT(extinction_.size() == locator_->mesh().vertices().size());
}

double TetInstant::valueAt(std::int32_t tet, const Vec3& point) const {
  const auto shares = locator_->mesh().shares(tet, point);
  const Tet& vertices = locator_->mesh().tets()[static_cast<std::size_t>(tet)];
  double sum = 0;
  for (int k = 0; k < 4; ++k) sum += std::max(shares[k], 0.0) * extinction_[vertices[k]];
  return sum;
}

Sight TetInstant::lookSlowly(const SightLine& line) const {
  const Segment segment = segmentOf(line);
  std::vector<TetCrossing> crossings;
  locator_->crossings(segment, crossings);
  Sight sight;
  // Beyond the mesh nothing is known; a gap between two parts of the way is something opaque.
  double last = 0;
  bool entered = false;
  for (const TetCrossing& crossing : crossings) {
    if (crossing.begin - last > kTolerance) {
      if (entered)
        sight.blocked = true;
      else
        sight.covered = false;
    }
    entered = true;
    last = std::max(last, crossing.end);
    sight.depth += (crossing.end - crossing.begin) *
                   valueAt(crossing.tet, segment.at(0.5 * (crossing.begin + crossing.end)));
  }
  if (segment.end - last > kTolerance) {
    sight.blocked |= entered;
    sight.covered &= entered;
  }
  sight.low = sight.high = sight.depth;
  return sight;
}

/// False where the way is not sure or leaves the mesh before the target.
bool TetInstant::walk(const SightLine& line, Sight& sight) const {
  const TetMesh& mesh = locator_->mesh();
  const Segment segment = segmentOf(line);
  std::int32_t tet = locator_->find(line.eye);
  double at = 0, sum = 0;
  for (std::size_t steps = 0; tet >= 0 && steps <= mesh.tets().size(); ++steps) {
    const TetRay ray(mesh, tet, segment.origin, segment.direction);
    const Exit exit = ray.exit();
    const double end = std::min(exit.at, segment.end);
    if (end > at) {
      double c0 = 0, c1 = 0;
      ray.field(extinction_.data(), mesh.tets()[static_cast<std::size_t>(tet)], c0, c1);
      sum += (end - at) * std::max(0.0, c0 + 0.5 * c1 * (at + end));
    }
    if (exit.at >= segment.end - kRounding) {
      sight = {};
      sight.depth = sight.low = sight.high = sum;
      return true;
    }
    // Backwards by more than rounding: lost.
    if (exit.across < 0 || exit.at < at - kTolerance)
      return false;
    at = std::max(at, end);
    const std::int32_t next = mesh.opposite(4 * tet + exit.across);
    tet = next == TetMesh::kBoundary ? -1 : next / 4;
  }
  return false;
}

void TetInstant::look(std::span<const SightLine> lines, std::span<Sight> sights) const {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!walk(lines[i], sights[i]))
      sights[i] = lookSlowly(lines[i]);
  }
}

void TetInstant::places(std::span<const Vec3> points, std::span<Place> places) const {
  for (std::size_t i = 0; i < points.size(); ++i)
    places[i] = locator_->find(points[i]) >= 0 ? Place::kGas : Place::kOutside;
}

void TetInstant::extinction(std::span<const Vec3> points, std::span<double> extinction) const {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::int32_t tet = locator_->find(points[i]);
    extinction[i] = tet < 0 ? std::numeric_limits<double>::quiet_NaN() : valueAt(tet, points[i]);
  }
}

}  // namespace volute
