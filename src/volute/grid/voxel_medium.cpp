// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/voxel_medium.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "volute/base/assert.hpp"
#include "volute/grid/cubic_voxels.hpp"
#include "volute/grid/voxel_cells.hpp"
#include "volute/grid/voxel_march.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {

using namespace voxels;  // NOLINT: of this module

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
      counters_(std::make_shared<Counters>()) {
  if (slice_->basis() == Basis::kCubic)
    cubic_ = std::make_shared<const CubicVoxels>(slice_, emissionScale, extinctionScale);
  else
    march_ = makeMarchGrid(slice_, cells_, emissionScale, extinctionScale);
}

VoxelMedium::VoxelMedium(const std::shared_ptr<const MarchGrid>& march, double emissionScale,
                         double extinctionScale)
    : slice_(march->slice),
      emissionScale_(emissionScale),
      extinctionScale_(extinctionScale),
      cells_(cellsOf(*slice_)),
      occupied_(occupiedCells(*slice_, cells_)),
      counters_(std::make_shared<Counters>()) {
  VOLUTE_ASSERT(march->trilinear && march->channels == 1 && march->lightChannel < 0);
  auto own = std::make_shared<MarchGrid>(*march);
  own->emissionScale = emissionScale, own->extinctionScale = extinctionScale;
  own->shaded = false, own->emissionChannel = -1;
  own->steps = MarchGrid().steps, own->lightLost = MarchGrid().lightLost;
  march_ = std::move(own);
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
  if (cubic_)
    return cubic_->extinction(point);
  double sum = 0;
  for (int c = 0; c < slice_->channels(); ++c) sum += weightedValue(point, c);
  return extinctionScale_ * (sum / slice_->channels());
}

Rgb VoxelMedium::emission(const Vec3& point) const {
  if (cubic_)
    return cubic_->emission(point);
  Rgb result;
  for (int c = 0; c < 3; ++c)
    result[c] = emissionScale_ * weightedValue(point, slice_->channels() == 3 ? c : 0);
  return result;
}

void VoxelMedium::opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
  if (cubic_)
    return cubic_->opticalDepth(segments, depths);
  if (extinctionScale_ == 0) {  // fire in the light of a sun
    std::ranges::fill(depths, 0);
    return;
  }
  const int channels = slice_->channels();
  for (std::size_t s = 0; s < segments.size(); ++s) {
    double sum = 0;
    forMarchedCells(*march_, cells_, segments[s],
                    [&](const std::array<int, 3>& cell, std::int32_t, const float* values,
                        double begin, double end) {
                      const auto mean = [&](int corner) {
                        double all = 0;
                        for (int c = 0; c < channels; ++c)
                          all += cornerOf(*march_, values, corner, c);
                        return all / channels;
                      };
                      if (!trilinear()) {
                        sum += (end - begin) * mean(0);
                        return;
                      }
                      const auto integrals = cornerIntegrals(
                          InCell(cells_, cell, segments[s], begin, end), end - begin);
                      for (int i = 0; i < 8; ++i) sum += integrals[i] * mean(i);
                    });
    depths[s] = extinctionScale_ * sum;
  }
}

void VoxelMedium::pieces(std::span<const Segment> segments,
                         std::span<std::vector<Piece>> pieces) const {
  if (cubic_)
    return cubic_->pieces(segments, pieces);
  const int channels = slice_->channels();
  const int corners = trilinear() ? 8 : 1;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    pieces[s].clear();
    forMarchedCells(*march_, cells_, segments[s],
                    [&](const std::array<int, 3>& cell, std::int32_t, const float* first,
                        double begin, double end) {
                      Piece piece{begin, end, {}, {}, 0};
                      bool empty = true;
                      for (int c = 0; c < channels; ++c) {
                        std::array<double, 8> values{};
                        for (int i = 0; i < corners; ++i) {
                          values[i] = cornerOf(*march_, first, i, c);
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
  if (cubic_)
    return cubic_->radiance(segments, out);
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

MarchCounts VoxelMedium::counts() const {
  if (cubic_)
    return cubic_->counts();
  return {counters_->voxels, counters_->bricksVisited, counters_->bricksSkipped};
}

}  // namespace volute
