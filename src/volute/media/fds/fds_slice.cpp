// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_slice.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "volute/image/colormap.hpp"
#include "volute/image/srgb.hpp"

namespace volute {
namespace {

constexpr std::uint32_t kColours = 256;

/// The quantities of 2D slices that a case has, in words.
std::string quantitiesOf(const SmvIndex& index) {
  std::set<std::string> names;
  for (const FdsSliceEntry& slice : index.slices) names.insert(slice.labels.quantity);
  return names.empty() ? "no slices" : fmt::format("slices of {}", fmt::join(names, ", "));
}

/// A cell of a thin lattice, and its value.
struct Square {
  std::array<int, 3> cell;
  double value = 0;
};

double valueOf(const FdsLattice& lattice, const FdsValues& values, const std::array<int, 3>& cell) {
  if (!lattice.nodal)
    return values.value[lattice.cellAt(cell)];
  double sum = 0;
  const std::size_t strideY = lattice.planes[0].size();
  const std::size_t strideZ = strideY * lattice.planes[1].size();
  const std::size_t first =
      cell[2] * strideZ + cell[1] * strideY + static_cast<std::size_t>(cell[0]);
  for (std::size_t corner = 0; corner < 8; ++corner)
    sum +=
        values
            .value[first + (corner & 1) + ((corner >> 1) & 1) * strideY + (corner >> 2) * strideZ];
  return sum / 8;
}

template <class Visit>
void forSquares(const FdsField& field, std::size_t number, Visit&& visit) {
  const FdsLattice& lattice = field.grid().lattices()[number];
  for (int z = 0; z < lattice.cells(2); ++z) {
    for (int y = 0; y < lattice.cells(1); ++y) {
      for (int x = 0; x < lattice.cells(0); ++x) {
        const std::array<int, 3> cell{x, y, z};
        if (field.cells(number)[lattice.cellAt(cell)] == FdsCell::kGas)
          visit(Square{cell, valueOf(lattice, field.values(number), cell)});
      }
    }
  }
}

void addSquare(TriangleMesh& mesh, const FdsLattice& lattice, const std::array<int, 3>& cell,
               std::uint32_t material) {
  const int u = (lattice.thinAxis + 1) % 3, v = (lattice.thinAxis + 2) % 3;
  const auto corner = [&](int du, int dv) {
    Vec3 point;
    point[lattice.thinAxis] = lattice.place;
    point[u] = lattice.planes[u][static_cast<std::size_t>(cell[u] + du)];
    point[v] = lattice.planes[v][static_cast<std::size_t>(cell[v] + dv)];
    return point;
  };
  mesh.triangles.push_back({{corner(0, 0), corner(1, 0), corner(1, 1)}, material});
  mesh.triangles.push_back({{corner(0, 0), corner(1, 1), corner(0, 1)}, material});
}

}  // namespace

Result<FdsSliceSheet> FdsSliceSheet::open(const SmvIndex& index, const std::string& quantity,
                                          std::optional<std::array<double, 2>> range,
                                          Reading& reading) {
  FdsOptions options{.quantity = quantity};
  options.maxMemory = reading.maxMemory;
  for (const FdsSource& source : findSources(index, quantity)) {
    if (source.kind == FdsFileKind::kSlice && !source.volume && options.source.empty())
      options.source = source.name;
  }
  if (options.source.empty()) {
    return fail(ErrorCode::kNotFound, "{}: no 2D slice of '{}'; the case has {}",
                index.path.string(), quantity, quantitiesOf(index));
  }
  VOLUTE_ASSIGN(auto opened, FdsCase::open(index, options));
  FdsSliceSheet sheet;
  sheet.quantity_ = quantity;
  sheet.unit_ = index.slices[opened.source().parts.front().entry].labels.unit;
  sheet.case_ = std::make_shared<FdsCase>(std::move(opened));
  if (range)
    sheet.range_ = *range;
  else
    VOLUTE_TRY(sheet.findRange(reading));
  return sheet;
}

Status FdsSliceSheet::findRange(Reading& reading) {
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (const double time : case_->times()) {
    if (reading.progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: reading slices of {}", quantity_);
    VOLUTE_ASSIGN(const FdsField field, case_->field(time));
    for (std::size_t i = 0; i < field.grid().lattices().size(); ++i) {
      forSquares(field, i, [&](const Square& square) {
        least = std::min(least, square.value);
        most = std::max(most, square.value);
      });
    }
  }
  range_ = least < most ? std::array{least, most} : std::array{least, least + 1};
  return {};
}

Status FdsSliceSheet::addTo(TriangleMesh& mesh, double time) const {
  VOLUTE_ASSIGN(const FdsField field, case_->field(time));
  const auto first = static_cast<std::uint32_t>(mesh.materials.size());
  for (std::uint32_t i = 0; i < kColours; ++i) {
    const Rgb colour =
        displayColor(ColorMap::kViridis, (i + 0.5) / kColours).unaryExpr(&srgbDecode);
    mesh.materials.push_back({Rgb::Zero(), colour});
  }
  for (std::size_t i = 0; i < field.grid().lattices().size(); ++i) {
    const FdsLattice& lattice = field.grid().lattices()[i];
    forSquares(field, i, [&](const Square& square) {
      const double share = (square.value - range_[0]) / (range_[1] - range_[0]);
      const auto colour = static_cast<std::uint32_t>(
          std::clamp(share * kColours, 0.0, static_cast<double>(kColours - 1)));
      addSquare(mesh, lattice, square.cell, first + colour);
    });
  }
  return {};
}

}  // namespace volute
