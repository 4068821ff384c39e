// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_slice.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string_view>

#include "volute/base/number_word.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/fds/frame_file.hpp"
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

double valueOf(const FdsLattice& lattice, const FdsValues& values, const std::array<int, 3>& cell) {
  if (!lattice.nodal)
    return values.value[lattice.cellAt(cell)];
  double sum = 0;
  const NodePlaces places(lattice);
  for (int corner = 0; corner < 8; ++corner)
    sum += values.value[places.first(cell) + places.offset(corner)];
  return sum / 8;
}

/// "TEMPERATURE z=1.5": the quantity, the axis and the place; nothing: no plane is named.
struct Named {
  std::string quantity;
  int axis = -1;
  double place = 0;
};

Result<Named> nameIn(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == text.npos)
    return Named{text};
  Named named;
  const bool number = readNumber(std::string_view(text).substr(equals + 1), named.place);
  const std::size_t axis = equals > 1 ? std::string_view("xyz").find(text[equals - 1]) : 3;
  if (!number || axis > 2 || text[equals - 2] != ' ') {
    return fail(ErrorCode::kInvalidArgument,
                "'{}' is no slice; expected a quantity, as TEMPERATURE, or one and a plane, as "
                "TEMPERATURE z=1.5",
                text);
  }
  named.axis = static_cast<int>(axis);
  named.quantity = text.substr(0, equals - 2);
  return named;
}

}  // namespace

/// A rectangle across an axis, and its value.
struct FdsSliceSheet::Square {
  int axis = 2;
  Vec3 min, max;  ///< [m]
  double value = 0;
};

namespace {

/// Whether a 2D slice's lattice is where a plane is wanted: within half a cell.
bool liesAt(const FdsLattice& lattice, int axis, double place) {
  const auto& planes = lattice.planes[static_cast<std::size_t>(axis)];
  return lattice.thinAxis == axis &&
         std::abs(lattice.place - place) <= 0.5 * (planes.back() - planes.front()) + 1e-6;
}

bool isFlat(const FdsSource& source) {
  return source.kind == FdsFileKind::kSlice && !source.volume;
}

}  // namespace

std::vector<FdsSliceSheet::Square> FdsSliceSheet::squaresOf(const FdsField& field) const {
  std::vector<Square> squares;
  const bool flat = isFlat(case_->source());
  for (std::size_t i = 0; i < field.grid().lattices().size(); ++i) {
    const FdsLattice& lattice = field.grid().lattices()[i];
    std::array<int, 3> begin{}, end{lattice.cells(0), lattice.cells(1), lattice.cells(2)};
    int axis = lattice.thinAxis;
    double place = lattice.place;
    if (flat && plane_ && !liesAt(lattice, plane_->axis, plane_->place))
      continue;
    if (!flat) {
      axis = plane_->axis, place = plane_->place;
      const auto& planes = lattice.planes[axis];
      if (place < planes.front() || place > planes.back() ||
          (place == planes.front() && place > field.grid().bounds().min[axis]))
        continue;  // the mesh below it has it
      begin[axis] = cellBetween(planes, place);
      end[axis] = begin[axis] + 1;
    }
    for (int z = begin[2]; z < end[2]; ++z) {
      for (int y = begin[1]; y < end[1]; ++y) {
        for (int x = begin[0]; x < end[0]; ++x) {
          const std::array<int, 3> cell{x, y, z};
          if (field.cells(i)[lattice.cellAt(cell)] != FdsCell::kGas)
            continue;
          Square square{.axis = axis, .min = {}, .max = {}, .value = 0};
          for (int a = 0; a < 3; ++a) {
            square.min[a] = lattice.planes[a][static_cast<std::size_t>(cell[a])];
            square.max[a] = lattice.planes[a][static_cast<std::size_t>(cell[a]) + 1];
          }
          square.min[axis] = square.max[axis] = place;
          square.value = flat ? valueOf(lattice, field.values(i), cell)
                              : field.extinction(0.5 * (square.min + square.max));
          squares.push_back(square);
        }
      }
    }
  }
  return squares;
}

std::string hottestSlice(const SmvIndex& index) {
  constexpr std::size_t kFramesToRead = 6;
  std::string best;
  double hottest = -std::numeric_limits<double>::infinity();
  for (const FdsSliceEntry& slice : index.slices) {
    const FdsMesh& mesh = index.meshes[static_cast<std::size_t>(slice.mesh)];
    const auto file = FdsSliceFile::open(slice, mesh);
    if (!file || file->frames().times.empty())
      continue;
    const FdsNodeBox& nodes = file->nodes();
    int axis = 0;
    while (axis < 3 && nodes.begin[axis] != nodes.end[axis]) ++axis;
    if (axis == 3)
      continue;
    if (best.empty())
      best = slice.labels.quantity;
    if (slice.labels.quantity != "TEMPERATURE")
      continue;
    const auto& planes = mesh.planes[axis];
    const auto node = static_cast<std::size_t>(nodes.begin[axis]);
    const double place =
        slice.cellCentred && node > 0 ? 0.5 * (planes[node - 1] + planes[node]) : planes[node];
    std::vector<float> values(file->values());
    const std::size_t last = file->frames().times.size() - 1;
    for (std::size_t i = 0; i < kFramesToRead; ++i) {
      if (!file->readFrame(last * i / (kFramesToRead - 1), values))
        break;
      const double most = *std::ranges::max_element(values);
      if (most > hottest) {
        hottest = most;
        best = fmt::format("TEMPERATURE {}={}", "xyz"[axis], plainNumber(place));
      }
    }
  }
  return best;
}

Result<FdsSliceSheet> FdsSliceSheet::open(const SmvIndex& index, const std::string& quantity,
                                          std::optional<std::array<double, 2>> range,
                                          Reading& reading) {
  VOLUTE_ASSIGN(const Named named, nameIn(quantity));
  FdsSliceSheet sheet;
  sheet.quantity_ = quantity;
  if (named.axis >= 0)
    sheet.plane_ = {named.axis, named.place};
  FdsOptions options{.quantity = named.quantity};
  options.maxMemory = reading.maxMemory;
  // 2D slices where they are wanted, else what fills meshes.
  for (const bool flat : {true, false}) {
    for (const FdsSource& source : findSources(index, named.quantity)) {
      if (isFlat(source) != flat || (!flat && (!sheet.plane_ || !source.volume)))
        continue;
      options.source = source.name;
      VOLUTE_ASSIGN(auto opened, FdsCase::open(index, options));
      const auto lattices = opened.grid().lattices();
      const auto wanted = [&](const FdsLattice& lattice) {
        return !flat || !sheet.plane_ || liesAt(lattice, named.axis, named.place);
      };
      if (std::ranges::none_of(lattices, wanted))
        continue;
      if (!flat && (named.place < opened.bounds().min[named.axis] ||
                    named.place > opened.bounds().max[named.axis])) {
        return fail(ErrorCode::kInvalidArgument,
                    "{}: {} is outside of the case; expected {} to {} m", index.path.string(),
                    quantity, plainNumber(opened.bounds().min[named.axis]),
                    plainNumber(opened.bounds().max[named.axis]));
      }
      if (source.kind == FdsFileKind::kSlice || source.kind == FdsFileKind::kPlot)
        sheet.unit_ = labelsOf(index, source, source.parts.front()).unit;
      sheet.case_ = std::make_shared<FdsCase>(std::move(opened));
      if (range)
        sheet.range_ = *range;
      else
        VOLUTE_TRY(sheet.findRange(reading));
      return sheet;
    }
  }
  return fail(ErrorCode::kNotFound, "{}: no {}slice of '{}'; the case has {}{}",
              index.path.string(), sheet.plane_ ? "" : "2D ", quantity, quantitiesOf(index),
              sheet.plane_ ? "" : "; a plane, as z=1.5 behind the name, cuts 3D ones");
}

Status FdsSliceSheet::findRange(Reading& reading) {
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (const double time : case_->times()) {
    if (reading.progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: reading slices of {}", quantity_);
    VOLUTE_ASSIGN(const FdsField field, case_->field(time));
    for (const Square& square : squaresOf(field)) {
      least = std::min(least, square.value);
      most = std::max(most, square.value);
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
  for (const Square& square : squaresOf(field)) {
    const double share = (square.value - range_[0]) / (range_[1] - range_[0]);
    const auto colour = first + static_cast<std::uint32_t>(std::clamp(
                                    share * kColours, 0.0, static_cast<double>(kColours - 1)));
    const int u = (square.axis + 1) % 3, v = (square.axis + 2) % 3;
    Vec3 b = square.min, d = square.min;
    b[u] = square.max[u];
    d[v] = square.max[v];
    mesh.triangles.push_back({{square.min, b, square.max}, colour});
    mesh.triangles.push_back({{square.min, square.max, d}, colour});
  }
  return {};
}

}  // namespace volute
