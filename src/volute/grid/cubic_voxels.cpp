// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/cubic_voxels.hpp"

#include <algorithm>
#include <array>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/grid/cubic_march.hpp"
#include "volute/grid/cubic_spline.hpp"

namespace volute {
namespace {

constexpr int kCellsOfBrick = BrickSlice::kSide;

using SplineCoefficients = std::array<double, voxels::kSplineCorners>;

SplineCoefficients cornersFrom(const float* from) {
  SplineCoefficients out;
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t i = 0; i < 4; ++i)
        out[16 * k + 4 * j + i] = from[(k * CubicGrid::kSide + j) * CubicGrid::kSide + i];
    }
  }
  return out;
}

/// The coefficients that the extinction has, without its scale.
SplineCoefficients extinctionCorners(const float* from, int channels) {
  SplineCoefficients sum = cornersFrom(from);
  if (channels != 3)
    return sum;
  for (int c = 1; c < 3; ++c) {
    const SplineCoefficients more = cornersFrom(from + c * CubicGrid::kCoefficients);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += more[i];
  }
  for (double& value : sum) value /= 3;
  return sum;
}

void copyCoefficients(const BrickSlice& slice, int x, int y, int z, float* out) {
  for (int c = 0; c < slice.channels(); ++c) {
    for (int k = 0; k < CubicGrid::kSide; ++k) {
      for (int j = 0; j < CubicGrid::kSide; ++j) {
        for (int i = 0; i < CubicGrid::kSide; ++i)
          *out++ = slice.value(x * kCellsOfBrick + i - 3, y * kCellsOfBrick + j - 3,
                               z * kCellsOfBrick + k - 3, c);
      }
    }
  }
}

/// Of cells that one of the coefficients reaches.
void markFilled(const float* from, int channels, std::bitset<BrickSlice::kVoxels>& filled) {
  constexpr int kAll = CubicGrid::kSide;
  for (int c = 0; c < channels; ++c) {
    for (int k = 0; k < kAll; ++k) {
      for (int j = 0; j < kAll; ++j) {
        for (int i = 0; i < kAll; ++i) {
          if (*from++ == 0)
            continue;
          for (int z = std::max(k - 3, 0); z <= std::min(k, kCellsOfBrick - 1); ++z) {
            for (int y = std::max(j - 3, 0); y <= std::min(j, kCellsOfBrick - 1); ++y) {
              for (int x = std::max(i - 3, 0); x <= std::min(i, kCellsOfBrick - 1); ++x)
                filled.set(static_cast<std::size_t>((z * kCellsOfBrick + y) * kCellsOfBrick + x));
            }
          }
        }
      }
    }
  }
}

}  // namespace

CubicGrid::CubicGrid(std::shared_ptr<const BrickSlice> of, double emission, double extinction)
    : slice(std::move(of)),
      emissionScale(emission),
      extinctionScale(extinction),
      cells(voxels::cellsOf(*slice)) {
  VOLUTE_ASSERT(slice->basis() == Basis::kCubic);
  bricks = {cells.origin, BrickSlice::kSide * cells.cell, {}};
  for (std::size_t axis = 0; axis < 3; ++axis)
    bricks.count[axis] = (cells.count[axis] + BrickSlice::kSide - 1) / BrickSlice::kSide;
  const std::vector<BrickPlace> places = slice->reached(bricks.count, table);
  const std::size_t each =
      static_cast<std::size_t>(kCoefficients) * static_cast<std::size_t>(slice->channels());
  stored.resize(places.size());
  coefficients.resize(places.size() * each + 1);  // the last row is read four at a time
  parallelRanges(places.size(), 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      stored[b].begin = b * each;
      copyCoefficients(*slice, places[b][0], places[b][1], places[b][2], &coefficients[b * each]);
      markFilled(&coefficients[b * each], slice->channels(), stored[b].filled);
    }
  });
}

CubicVoxels::CubicVoxels(std::shared_ptr<const BrickSlice> slice, double emissionScale,
                         double extinctionScale)
    : grid_(std::make_shared<const CubicGrid>(std::move(slice), emissionScale, extinctionScale)),
      cells_(grid_->cells) {}

double CubicVoxels::extinction(const Vec3& point) const {
  return grid_->channels() == 4 ? valueAt(point, 0)
         : grid_->channels() == 1
             ? grid_->extinctionScale * valueAt(point, 0)
             : grid_->extinctionScale *
                   ((valueAt(point, 0) + valueAt(point, 1) + valueAt(point, 2)) / 3);
}

Rgb CubicVoxels::emission(const Vec3& point) const {
  const int channels = grid_->channels();
  Rgb sent;
  for (int c = 0; c < 3; ++c) {
    sent[c] = channels == 4 ? valueAt(point, 1 + c)
                            : grid_->emissionScale * valueAt(point, channels == 3 ? c : 0);
  }
  return sent;
}

double CubicVoxels::valueAt(const Vec3& point, int channel) const {
  if (!bounds().contains(point))
    return 0;
  const auto cell = cells_.cellAt(point);
  SplineCoefficients corners;
  std::size_t i = 0;
  for (int z = -3; z <= 0; ++z) {
    for (int y = -3; y <= 0; ++y) {
      for (int x = -3; x <= 0; ++x)
        corners[i++] = grid_->slice->value(cell[0] + x, cell[1] + y, cell[2] + z, channel);
    }
  }
  return voxels::splineValue(corners, voxels::placeInCell(cells_, cell, point));
}

void CubicVoxels::opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
  const int channels = grid_->channels();
  const double scale = channels == 4 ? 1 : grid_->extinctionScale;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    double sum = 0;
    if (scale != 0) {
      grid_->traverse(
          segments[s], [&](const auto& cell, const float* from, double begin, double end) {
            const voxels::InCell in(cells_, cell, segments[s], begin, end);
            sum += voxels::splineIntegral(extinctionCorners(from, channels), in, end - begin);
            return true;
          });
    }
    depths[s] = scale * sum;
  }
}

void CubicVoxels::pieces(std::span<const Segment> segments,
                         std::span<std::vector<Piece>> pieces) const {
  const int channels = grid_->channels();
  const double scale = channels == 4 ? 1 : grid_->emissionScale;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    pieces[s].clear();
    grid_->traverse(
        segments[s], [&](const auto& cell, const float* from, double begin, double end) {
          const voxels::InCell in(cells_, cell, segments[s], begin, end);
          Piece piece{begin, end, {}, {}, 0};
          std::array<Polynomial, 4> curves;
          for (int c = 0; c < channels; ++c) {
            curves[static_cast<std::size_t>(c)] =
                voxels::splineAlong(cornersFrom(from + c * CubicGrid::kCoefficients), in);
          }
          for (std::size_t c = 0; c < 3; ++c)
            piece.emission[c] = curves[channels == 4 ? c + 1 : channels == 3 ? c : 0] * scale;
          piece.extinction = curves[0];
          if (channels == 3) {
            piece.extinction += curves[1];
            piece.extinction += curves[2];
          }
          if (channels != 4)
            piece.extinction = piece.extinction * (grid_->extinctionScale / channels);
          pieces[s].push_back(piece);
          return true;
        });
  }
}

void CubicVoxels::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  for (std::size_t i = 0; i < segments.size(); ++i) out[i] = marchCubic(*grid_, segments[i]);
}

MarchCounts CubicVoxels::counts() const {
  return {grid_->counts->cells, grid_->counts->visited, 0};
}

}  // namespace volute
