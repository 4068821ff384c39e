// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/tet_sight.hpp"

#include <cmath>
#include <limits>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

/// Gaps in the mesh shorter than this are rounding [m].
constexpr double kTetTolerance = 1e-5;
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

Segment tetSegment(const SightLine& line) {
  const double length = line.length();
  const Vec3 direction = length > 0 ? Vec3((line.target - line.eye) / length) : Vec3::UnitX();
  return {line.eye, direction, 0, length};
}

}  // namespace

TetSightSnapshot::TetSightSnapshot(std::shared_ptr<const TetLocator> locator,
                                   std::vector<float> extinction, std::uint64_t geometry)
    : locator_(std::move(locator)), extinction_(std::move(extinction)), geometry_(geometry) {
  VOLUTE_ASSERT(extinction_.size() == locator_->mesh().vertices().size());
}

double TetSightSnapshot::valueAt(std::int32_t tet, const Vec3& point) const {
  const auto shares = locator_->mesh().shares(tet, point);
  const Tet& vertices = locator_->mesh().tets()[static_cast<std::size_t>(tet)];
  double sum = 0;
  for (int k = 0; k < 4; ++k) sum += std::max(shares[k], 0.0) * extinction_[vertices[k]];
  return sum;
}

template <class Visit>
void TetSightSnapshot::cross(const Segment& segment, Sight& sight, Visit&& visit) const {
  std::vector<TetCrossing> crossings;
  locator_->crossings(segment, crossings);
  sight = {};
  // Beyond the mesh nothing is known; a gap between two parts of the way is something opaque.
  double last = 0;
  bool entered = false;
  for (const TetCrossing& crossing : crossings) {
    if (crossing.begin - last > kTetTolerance) {
      if (entered)
        sight.blocked = true;
      else
        sight.covered = false;
    }
    entered = true;
    last = std::max(last, crossing.end);
    visit(crossing.tet, crossing.begin, crossing.end);
  }
  if (segment.end - last > kTetTolerance) {
    sight.blocked |= entered;
    sight.covered &= entered;
  }
  sight.blocked |= locator_->wallOn(segment).has_value();
}

template <class Visit>
bool TetSightSnapshot::walk(const Segment& segment, Visit&& visit) const {
  const TetMesh& mesh = locator_->mesh();
  std::int32_t tet = locator_->wallOn(segment) ? -1 : locator_->find(segment.origin);
  double at = 0;
  for (std::size_t steps = 0; tet >= 0 && steps <= mesh.tets().size(); ++steps) {
    const Exit exit = TetRay(mesh, tet, segment.origin, segment.direction).exit();
    const double end = std::min(exit.at, segment.end);
    if (end > at)
      visit(tet, at, end);
    if (exit.at >= segment.end - kRounding)
      return true;
    // Backwards by more than rounding: lost.
    if (exit.across < 0 || exit.at < at - kTetTolerance)
      return false;
    at = std::max(at, end);
    const std::int32_t next = mesh.opposite(4 * tet + exit.across);
    tet = next == TetMesh::kBoundary ? -1 : next / 4;
  }
  return false;
}

Sight TetSightSnapshot::lookSlowly(const SightLine& line) const {
  const Segment segment = tetSegment(line);
  Sight sight;
  double sum = 0;
  // Linear along the line: the middle is the mean.
  cross(segment, sight, [&](std::int32_t tet, double begin, double end) {
    sum += (end - begin) * valueAt(tet, segment.at(0.5 * (begin + end)));
  });
  sight.depth = sight.low = sight.high = sum;
  return sight;
}

void TetSightSnapshot::look(std::span<const SightLine> lines, std::span<Sight> sights) const {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Segment segment = tetSegment(lines[i]);
    double sum = 0;
    const bool arrived = walk(segment, [&](std::int32_t tet, double begin, double end) {
      sum += (end - begin) * valueAt(tet, segment.at(0.5 * (begin + end)));
    });
    sights[i] = arrived ? Sight{.depth = sum, .low = sum, .high = sum} : lookSlowly(lines[i]);
  }
}

void TetSightSnapshot::weigh(const SightLine& line, std::vector<SightWeight>& weights,
                             Sight& sight) const {
  const Segment segment = tetSegment(line);
  const TetMesh& mesh = locator_->mesh();
  const std::size_t first = weights.size();
  const auto add = [&](std::int32_t tet, double begin, double end) {
    const auto shares = mesh.shares(tet, segment.at(0.5 * (begin + end)));
    const Tet& vertices = mesh.tets()[static_cast<std::size_t>(tet)];
    for (int k = 0; k < 4; ++k) {
      addWeight(weights, first, static_cast<std::uint32_t>(vertices[k]),
                (end - begin) * std::max(shares[k], 0.0));
    }
  };
  sight = {};
  if (walk(segment, add))
    return;
  weights.resize(first);
  cross(segment, sight, add);
}

void TetSightSnapshot::places(std::span<const Vec3> points, std::span<Place> places) const {
  for (std::size_t i = 0; i < points.size(); ++i) {
    places[i] = locator_->isOnWall(points[i])    ? Place::kSolid
                : locator_->find(points[i]) >= 0 ? Place::kGas
                                                 : Place::kOutside;
  }
}

void TetSightSnapshot::floors(std::span<const Vec3> points, double drop,
                              std::span<double> z) const {
  BasicSightSnapshot::floors(points, drop, z);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto down = locator_->wallOn({points[i], -Vec3::UnitZ(), 0, drop});
    if (down && !(z[i] > points[i].z() - *down))
      z[i] = points[i].z() - *down;
  }
}

void TetSightSnapshot::extinction(std::span<const Vec3> points,
                                  std::span<double> extinction) const {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::int32_t tet = locator_->find(points[i]);
    extinction[i] = tet < 0 ? std::numeric_limits<double>::quiet_NaN() : valueAt(tet, points[i]);
  }
}

}  // namespace volute
