// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/reference_projector.hpp"

#include "volute/math/quadrature.hpp"

namespace volute {
namespace {

/// visit(voxel, integral of its basis function) over all voxels that the segment reaches, a voxel
/// once for each cell.
template <class Visit>
void forVoxels(const VolumeGeometry& geometry, Basis basis, const CellGrid& cells,
               const Segment& segment, Visit&& visit) {
  const auto& n = geometry.resolution;
  const CellRange all{{0, 0, 0}, cells.count};
  traverseCells(cells, all, segment, [&](const std::array<int, 3>& cell, double begin, double end) {
    if (basis == Basis::kBox) {
      visit((static_cast<std::size_t>(cell[2]) * n[1] + cell[1]) * n[0] + cell[0], end - begin);
      return;
    }
    for (int corner = 0; corner < 8; ++corner) {
      const std::array<int, 3> up{corner & 1, corner >> 1 & 1, corner >> 2};
      std::array<int, 3> voxel{};
      bool inside = true;
      for (int a = 0; a < 3; ++a) {
        voxel[a] = cell[a] + up[a] - 1;
        inside = inside && voxel[a] >= 0 && voxel[a] < n[a];
      }
      if (!inside)
        continue;
      const double weight = gaussIntegral(2, begin, end, [&](double s) {
        double product = 1;
        for (int a = 0; a < 3; ++a) {
          const double place = (segment.at(s)[a] - cells.plane(a, cell[a])) / cells.cell[a];
          product *= up[a] ? place : 1 - place;
        }
        return product;
      });
      visit((static_cast<std::size_t>(voxel[2]) * n[1] + voxel[1]) * n[0] + voxel[0], weight);
    }
  });
}

}  // namespace

double ReferenceProjector::forward(std::span<const double> values, const Segment& segment) const {
  double sum = 0;
  forVoxels(geometry_, basis_, cells_, segment,
            [&](std::size_t voxel, double integral) { sum += values[voxel] * integral; });
  return sum;
}

void ReferenceProjector::adjoint(double weight, const Segment& segment,
                                 std::span<double> gradient) const {
  forVoxels(geometry_, basis_, cells_, segment,
            [&](std::size_t voxel, double integral) { gradient[voxel] += weight * integral; });
}

}  // namespace volute
