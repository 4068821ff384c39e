// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_field.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"

namespace volute {

Result<std::size_t> checkField(std::span<float> values, Negatives negatives,
                               std::string_view name) {
  std::size_t negative = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) {
      return fail(ErrorCode::kInvalidData, "{}: value {} is {}; expected finite numbers", name, i,
                  values[i]);
    }
    if (values[i] < 0 && negatives == Negatives::kRefuse) {
      return fail(ErrorCode::kInvalidData,
                  "{}: value {} is {}; concentrations are not negative; ask for them to be clamped "
                  "to 0 if they are the solver's noise",
                  name, i, values[i]);
    }
    if (negatives == Negatives::kKeep)
      continue;
    negative += values[i] < 0;
    values[i] = std::max(values[i], 0.0F);
  }
  return negative;
}

std::vector<float> cellToPoint(const TetMesh& mesh, std::span<const float> cellValues,
                               std::span<const std::int32_t> cellOf, CellMean mean,
                               std::span<const float> weights) {
  const bool inverses = mean == CellMean::kInverses;
  std::vector<double> sum(mesh.vertices().size(), 0), weight(mesh.vertices().size(), 0);
  for (std::size_t t = 0; t < mesh.tets().size(); ++t) {
    const std::size_t cell = cellOf.empty() ? t : static_cast<std::size_t>(cellOf[t]);
    const double volume = mesh.volume(static_cast<std::int32_t>(t)) *
                          (weights.empty() ? 1.0 : static_cast<double>(weights[cell]));
    const double value = cellValues[cell];
    for (const std::int32_t v : mesh.tets()[t]) {
      sum[v] += inverses ? volume / value : volume * value;
      weight[v] += volume;
    }
  }
  std::vector<float> values(sum.size());
  for (std::size_t v = 0; v < sum.size(); ++v) {
    const double whole = inverses ? weight[v] / sum[v] : sum[v] / weight[v];
    values[v] = static_cast<float>(weight[v] == 0 ? 0 : whole);
  }
  return values;
}

void interpolateFields(std::span<const float> a, std::span<const float> b, double share,
                       std::span<float> out) {
  VOLUTE_ASSERT(a.size() == b.size() && a.size() == out.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    out[i] = static_cast<float>((1 - share) * a[i] + share * b[i]);
}

}  // namespace volute
