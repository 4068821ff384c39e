// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/knots.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace volute {
namespace {

double numberAt(const nlohmann::ordered_json& list, std::size_t i, std::size_t column) {
  return list.at(i).at(column).get<double>();
}

}  // namespace

void setKnot(nlohmann::ordered_json& knots, std::size_t i, const std::vector<double>& knot,
             double most) {
  double place = knot[0];
  if (i > 0)
    place = std::max(place, numberAt(knots, i - 1, 0));
  if (i + 1 < knots.size())
    place = std::min(place, numberAt(knots, i + 1, 0));
  knots.at(i) = nlohmann::ordered_json::array({place, std::clamp(knot[1], 0.0, most)});
}

void duplicateKnot(nlohmann::ordered_json& knots, std::size_t i, double apart) {
  nlohmann::ordered_json copy = knots.at(i);
  const double own = numberAt(knots, i, 0);
  const bool last = i + 1 == knots.size();
  const double other = numberAt(knots, last ? i - 1 : i + 1, 0);
  copy[0] = last ? own + std::max(own - other, apart) : 0.5 * (own + other);
  if (!last)
    copy[1] = 0.5 * (numberAt(knots, i, 1) + numberAt(knots, i + 1, 1));
  knots.insert(knots.begin() + static_cast<std::ptrdiff_t>(i) + 1, std::move(copy));
}

}  // namespace volute
