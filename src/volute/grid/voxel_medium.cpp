// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/voxel_medium.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "volute/base/assert.hpp"
#include "volute/grid/voxel_march.hpp"
#include "volute/math/quadrature.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

CellGrid cellsOf(const BrickSlice& slice) {
  const Vec3 voxel = slice.bounds().size().cwiseQuotient(Vec3(slice.x(), slice.y(), slice.z()));
  if (slice.basis() == Basis::kBox)
    return {slice.bounds().min, voxel, {slice.x(), slice.y(), slice.z()}};
  // Cell i lies between the centres of voxels i - 1 and i.
  return {slice.bounds().min - 0.5 * voxel, voxel, {slice.x() + 1, slice.y() + 1, slice.z() + 1}};
}

/// The cells that voxels of stored bricks reach into.
CellRange occupiedCells(const BrickSlice& slice, const CellGrid& cells) {
  CellRange range{cells.count, {0, 0, 0}};
  const int reach = slice.basis() == Basis::kTrilinear ? 1 : 0;
  for (int bz = 0; bz < slice.bricksZ(); ++bz) {
    for (int by = 0; by < slice.bricksY(); ++by) {
      for (int bx = 0; bx < slice.bricksX(); ++bx) {
        if (slice.brickAt(bx, by, bz) == BrickSlice::kEmpty)
          continue;
        const std::array<int, 3> brick{bx, by, bz};
        for (int axis = 0; axis < 3; ++axis) {
          const int first = brick[axis] * BrickSlice::kSide;
          range.begin[axis] = std::min(range.begin[axis], first);
          range.end[axis] = std::max(
              range.end[axis], std::min(first + BrickSlice::kSide + reach, cells.count[axis]));
        }
      }
    }
  }
  return range;
}

/// The eight voxels around a trilinear cell, x fastest.
constexpr std::array<std::array<int, 3>, 8> kCorners{{{-1, -1, -1},
                                                      {0, -1, -1},
                                                      {-1, 0, -1},
                                                      {0, 0, -1},
                                                      {-1, -1, 0},
                                                      {0, -1, 0},
                                                      {-1, 0, 0},
                                                      {0, 0, 0}}};

/// Where a point is in its cell: from 0 to 1 across it on each axis, rounding kept inside.
Vec3 placeInCell(const CellGrid& grid, const std::array<int, 3>& cell, const Vec3& point) {
  Vec3 place;
  for (int axis = 0; axis < 3; ++axis) {
    place[axis] =
        std::clamp((point[axis] - grid.plane(axis, cell[axis])) / grid.cell[axis], 0.0, 1.0);
  }
  return place;
}

/// A ray inside one cell: its place is linear in u.
struct InCell {
  Vec3 at;        ///< where u = 0
  Vec3 velocity;  ///< per metre

  InCell(const CellGrid& grid, const std::array<int, 3>& cell, const Segment& segment, double begin,
         double end)
      : at(placeInCell(grid, cell, segment.at(begin))),
        velocity((placeInCell(grid, cell, segment.at(end)) - at) / (end - begin)) {}
};

/// The share of each corner at a place in the cell.
std::array<double, 8> cornerShares(const Vec3& place) {
  std::array<double, 8> shares;
  for (int i = 0; i < 8; ++i) {
    shares[i] = (i & 1 ? place.x() : 1 - place.x()) * (i & 2 ? place.y() : 1 - place.y()) *
                (i & 4 ? place.z() : 1 - place.z());
  }
  return shares;
}

/// The corners' line integrals over `length`: shares are cubic in u, so two Gauss points are exact.
std::array<double, 8> cornerIntegrals(const InCell& ray, double length) {
  std::array<double, 8> sum{};
  const GaussRule rule = gaussRule(2);
  for (std::size_t k = 0; k < 2; ++k) {
    const double u = 0.5 * length * (1 + rule.nodes[k]);
    const auto shares = cornerShares(ray.at + u * ray.velocity);
    for (int i = 0; i < 8; ++i) sum[i] += 0.5 * length * rule.weights[k] * shares[i];
  }
  return sum;
}

/// The interpolated value along the ray as a polynomial of u.
Cubic cornerCubic(const InCell& ray, std::array<double, 8> v) {
  // To v[0] + v[1] x + v[2] y + v[3] xy + v[4] z ..., then by Horner's rule with linear functions
  // for x, y, z.
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < 8; ++i) {
      if (i & (1 << axis))
        v[i] -= v[i ^ (1 << axis)];
    }
  }
  const auto times = [](const Cubic& p, double a, double b) {  // p * (a + b u)
    return Cubic{
        {a * p.c[0], a * p.c[1] + b * p.c[0], a * p.c[2] + b * p.c[1], a * p.c[3] + b * p.c[2]}};
  };
  std::array<Cubic, 8> p;
  for (int i = 0; i < 8; ++i) p[i].c[0] = v[i];
  for (int axis = 2; axis >= 0; --axis) {
    for (int i = 0; i < (1 << axis); ++i)
      p[i] += times(p[i | (1 << axis)], ray.at[axis], ray.velocity[axis]);
  }
  return p[0];
}

}  // namespace

struct VoxelMedium::Counters {
  std::atomic<std::uint64_t> voxels{0};
  std::atomic<std::uint64_t> bricksVisited{0};
  std::atomic<std::uint64_t> bricksSkipped{0};
};

VoxelMedium::VoxelMedium(std::shared_ptr<const BrickSlice> slice, double emissionScale,
                         double extinctionScale)
    : slice_(std::move(slice)),
      emissionScale_(emissionScale),
      extinctionScale_(extinctionScale),
      cells_(cellsOf(*slice_)),
      occupied_(occupiedCells(*slice_, cells_)),
      march_(makeMarchGrid(slice_, cells_, emissionScale, extinctionScale)),
      counters_(std::make_shared<Counters>()) {}

double VoxelMedium::meanOfChannels(int x, int y, int z) const {
  double sum = 0;
  for (int c = 0; c < slice_->channels(); ++c) sum += slice_->value(x, y, z, c);
  return sum / slice_->channels();
}

double VoxelMedium::weightedValue(const Vec3& point, int channel) const {
  if (!bounds().contains(point))
    return 0;
  const auto cell = cells_.cellAt(point);
  if (!trilinear())
    return slice_->value(cell[0], cell[1], cell[2], channel);
  const auto shares = cornerShares(placeInCell(cells_, cell, point));
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const auto& [dx, dy, dz] = kCorners[i];
    sum += shares[i] * slice_->value(cell[0] + dx, cell[1] + dy, cell[2] + dz, channel);
  }
  return sum;
}

double VoxelMedium::extinction(const Vec3& point) const {
  double sum = 0;
  for (int c = 0; c < slice_->channels(); ++c) sum += weightedValue(point, c);
  return extinctionScale_ * (sum / slice_->channels());
}

Rgb VoxelMedium::emission(const Vec3& point) const {
  Rgb result;
  for (int c = 0; c < 3; ++c)
    result[c] = emissionScale_ * weightedValue(point, slice_->channels() == 3 ? c : 0);
  return result;
}

void VoxelMedium::opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
  for (std::size_t s = 0; s < segments.size(); ++s) {
    double sum = 0;
    traverseCells(cells_, occupied_, segments[s],
                  [&](const std::array<int, 3>& cell, double begin, double end) {
                    if (!trilinear()) {
                      sum += (end - begin) * meanOfChannels(cell[0], cell[1], cell[2]);
                      return;
                    }
                    const auto integrals =
                        cornerIntegrals(InCell(cells_, cell, segments[s], begin, end), end - begin);
                    for (int i = 0; i < 8; ++i) {
                      const auto& [dx, dy, dz] = kCorners[i];
                      sum +=
                          integrals[i] * meanOfChannels(cell[0] + dx, cell[1] + dy, cell[2] + dz);
                    }
                  });
    depths[s] = extinctionScale_ * sum;
  }
}

void VoxelMedium::pieces(std::span<const Segment> segments,
                         std::span<std::vector<Piece>> pieces) const {
  const int channels = slice_->channels();
  const int corners = trilinear() ? 8 : 1;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    pieces[s].clear();
    traverseCells(cells_, occupied_, segments[s],
                  [&](const std::array<int, 3>& cell, double begin, double end) {
                    Piece piece{begin, end, {}, {}, 0};
                    bool empty = true;
                    for (int c = 0; c < channels; ++c) {
                      std::array<double, 8> values{};
                      for (int i = 0; i < corners; ++i) {
                        const auto& [dx, dy, dz] = kCorners[trilinear() ? i : 7];
                        values[i] = slice_->value(cell[0] + dx, cell[1] + dy, cell[2] + dz, c);
                        empty = empty && values[i] == 0;
                      }
                      const Cubic cubic =
                          trilinear()
                              ? cornerCubic(InCell(cells_, cell, segments[s], begin, end), values)
                              : Cubic{{values[0], 0, 0, 0}};
                      piece.extinction += cubic * (extinctionScale_ / channels);
                      piece.emission[c] = cubic * emissionScale_;
                    }
                    if (channels == 1)
                      piece.emission[1] = piece.emission[2] = piece.emission[0];
                    if (!empty)
                      pieces[s].push_back(piece);
                  });
  }
}

void VoxelMedium::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  if (!march_->fits)
    return radianceByPieces(*this, segments, out);
  MarchCounts counts;
  marchRadiance(*march_, cells_, occupied_, segments, out, counts);
  counters_->voxels += counts.voxels;
  counters_->bricksVisited += counts.bricksVisited;
  counters_->bricksSkipped += counts.bricksSkipped;
}

std::vector<double> VoxelMedium::coefficients() const {
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(slice_->z()) * slice_->y() * slice_->x() *
                 slice_->channels());
  for (int z = 0; z < slice_->z(); ++z) {
    for (int y = 0; y < slice_->y(); ++y) {
      for (int x = 0; x < slice_->x(); ++x) {
        for (int c = 0; c < slice_->channels(); ++c) values.push_back(slice_->value(x, y, z, c));
      }
    }
  }
  return values;
}

VoxelMedium VoxelMedium::withCoefficients(std::span<const double> coefficients) const {
  VolumeInfo info;
  info.z = slice_->z(), info.y = slice_->y(), info.x = slice_->x();
  info.channels = slice_->channels();
  info.bounds = slice_->bounds();
  info.basis = slice_->basis();
  VOLUTE_ASSERT(coefficients.size() == info.frameValues());
  const std::vector<float> values(coefficients.begin(), coefficients.end());
  return {std::make_shared<BrickSlice>(BrickSlice::fromDense(info, values)), emissionScale_,
          extinctionScale_};
}

void VoxelMedium::scatter(std::span<const Segment> segments, std::span<const double> weights,
                          std::span<double> gradient) const {
  const int channels = slice_->channels();
  const auto add = [&](int x, int y, int z, double amount) {
    if (x < 0 || y < 0 || z < 0 || x >= slice_->x() || y >= slice_->y() || z >= slice_->z())
      return;
    const std::size_t voxel = (static_cast<std::size_t>(z) * slice_->y() + y) * slice_->x() + x;
    for (int c = 0; c < channels; ++c)
      gradient[voxel * channels + c] += amount * extinctionScale_ / channels;
  };
  const CellRange all{{0, 0, 0}, cells_.count};
  for (std::size_t s = 0; s < segments.size(); ++s) {
    traverseCells(cells_, all, segments[s],
                  [&](const std::array<int, 3>& cell, double begin, double end) {
                    if (!trilinear()) {
                      add(cell[0], cell[1], cell[2], weights[s] * (end - begin));
                      return;
                    }
                    const auto integrals =
                        cornerIntegrals(InCell(cells_, cell, segments[s], begin, end), end - begin);
                    for (int i = 0; i < 8; ++i) {
                      const auto& [dx, dy, dz] = kCorners[i];
                      add(cell[0] + dx, cell[1] + dy, cell[2] + dz, weights[s] * integrals[i]);
                    }
                  });
  }
}

MarchCounts VoxelMedium::counts() const {
  return {counters_->voxels, counters_->bricksVisited, counters_->bricksSkipped};
}

}  // namespace volute
