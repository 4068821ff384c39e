// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cmath>

#include "volute/base/assert.hpp"
#include "volute/medium/conformance/dummy_media.hpp"
#include "volute/medium/conformance/random.hpp"
#include "volute/medium/conformance/support.hpp"

namespace volute::conformance {
namespace {

/// (a + b s) times a polynomial.
Cubic times(const Cubic& p, double a, double b) {
  Cubic out;
  for (int i = 0; i < 4; ++i) out.c[i] = a * p.c[i] + (i > 0 ? b * p.c[i - 1] : 0);
  return out;
}

}  // namespace

TrilinearVoxels::TrilinearVoxels(const Index& nodes, const Vec3& origin, const Vec3& cell,
                                 std::uint32_t seed)
    : nodes_(nodes), origin_(origin), cell_(cell) {
  VOLUTE_ASSERT(nodes[0] >= 2 && nodes[1] >= 2 && nodes[2] >= 2);
  Random random(seed);
  const std::size_t count = std::size_t(nodes[0]) * nodes[1] * nodes[2];
  extinction_ = random.numbers(count, 0, 1);
  for (auto& channel : emission_) channel = random.numbers(count, 0, 1);
}

Box3 TrilinearVoxels::bounds() const {
  return {origin_, origin_ + cell_.cwiseProduct(Vec3(nodes_[0] - 1, nodes_[1] - 1, nodes_[2] - 1))};
}

TrilinearVoxels::Index TrilinearVoxels::cellOf(const Vec3& point) const {
  Index index;
  for (int axis = 0; axis < 3; ++axis) {
    const double position = std::floor((point[axis] - origin_[axis]) / cell_[axis]);
    index[axis] = int(std::clamp(position, 0.0, double(nodes_[axis] - 2)));
  }
  return index;
}

/// The basis functions are products of x or 1 - x on each axis, x linear in s.
TrilinearVoxels::Crossing TrilinearVoxels::crossing(const Segment& segment, double begin,
                                                    double end) const {
  const Index cell = cellOf(segment.at(0.5 * (begin + end)));
  const Vec3 corner = origin_ + cell_.cwiseProduct(Vec3(cell[0], cell[1], cell[2]));
  const Vec3 x = (segment.at(begin) - corner).cwiseQuotient(cell_);
  const Vec3 slope = segment.direction.cwiseQuotient(cell_);
  Crossing out{begin, end, {}, {}};
  for (int k = 0; k < 8; ++k) {
    const Index upper{k & 1, (k >> 1) & 1, k >> 2};
    out.nodes[k] =
        (std::size_t(cell[2] + upper[2]) * nodes_[1] + (cell[1] + upper[1])) * nodes_[0] + cell[0] +
        upper[0];
    out.basis[k] = Cubic{{1, 0, 0, 0}};
    for (int axis = 0; axis < 3; ++axis) {
      out.basis[k] = upper[axis] ? times(out.basis[k], x[axis], slope[axis])
                                 : times(out.basis[k], 1 - x[axis], -slope[axis]);
    }
  }
  return out;
}

std::vector<TrilinearVoxels::Crossing> TrilinearVoxels::crossings(const Segment& segment) const {
  const Interval inside =
      bounds().intersect(segment.origin, segment.direction).intersect({segment.begin, segment.end});
  if (inside.empty())
    return {};
  std::vector<double> cuts{inside.begin, inside.end};
  for (int axis = 0; axis < 3; ++axis) {
    if (segment.direction[axis] == 0)
      continue;
    for (int i = 1; i + 1 < nodes_[axis]; ++i) {
      const double s =
          (origin_[axis] + i * cell_[axis] - segment.origin[axis]) / segment.direction[axis];
      if (s > inside.begin && s < inside.end)
        cuts.push_back(s);
    }
  }
  std::sort(cuts.begin(), cuts.end());
  std::vector<Crossing> out;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    if (cuts[i] < cuts[i + 1])
      out.push_back(crossing(segment, cuts[i], cuts[i + 1]));
  }
  return out;
}

double TrilinearVoxels::interpolate(const std::vector<double>& values, const Vec3& point) const {
  if (!bounds().contains(point))
    return 0;
  const Crossing here = crossing({point, Vec3::UnitX(), 0, 0}, 0, 0);
  double sum = 0;
  for (int k = 0; k < 8; ++k) sum += values[here.nodes[k]] * here.basis[k].c[0];
  return sum;
}

double TrilinearVoxels::extinction(const Vec3& point) const {
  return interpolate(extinction_, point);
}

Rgb TrilinearVoxels::emission(const Vec3& point) const {
  return {interpolate(emission_[0], point), interpolate(emission_[1], point),
          interpolate(emission_[2], point)};
}

void TrilinearVoxels::opticalDepth(std::span<const Segment> segments,
                                   std::span<double> depths) const {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    depths[i] = 0;
    for (const Crossing& cell : crossings(segments[i])) {
      for (int k = 0; k < 8; ++k)
        depths[i] += extinction_[cell.nodes[k]] * cell.basis[k].integral(cell.end - cell.begin);
    }
  }
}

void TrilinearVoxels::pieces(std::span<const Segment> segments,
                             std::span<std::vector<Piece>> pieces) const {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    pieces[i].clear();
    for (const Crossing& cell : crossings(segments[i])) {
      Piece piece{cell.begin, cell.end, {}, {}, 0};
      for (int k = 0; k < 8; ++k) {
        piece.extinction += cell.basis[k] * extinction_[cell.nodes[k]];
        for (int channel = 0; channel < 3; ++channel) {
          piece.emission[channel] += cell.basis[k] * emission_[channel][cell.nodes[k]];
        }
      }
      pieces[i].push_back(piece);
    }
  }
}

TrilinearVoxels TrilinearVoxels::withCoefficients(std::span<const double> coefficients) const {
  TrilinearVoxels other = *this;
  other.extinction_.assign(coefficients.begin(), coefficients.end());
  return other;
}

std::array<std::vector<double>, 3> TrilinearVoxels::planes() const {
  std::array<std::vector<double>, 3> out;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < nodes_[axis]; ++i) out[axis].push_back(origin_[axis] + i * cell_[axis]);
  }
  return out;
}

Traits traitsOf(const TrilinearVoxels& voxels) {
  return {.planes = voxels.planes()};
}

MediumUnderTest trilinearVoxelsUnderTest() {
  const TrilinearVoxels voxels({5, 4, 6}, Vec3(-1, 0.5, 2), Vec3(0.5, 0.75, 0.25), 7);
  return underTest(voxels, traitsOf(voxels));
}

}  // namespace volute::conformance
