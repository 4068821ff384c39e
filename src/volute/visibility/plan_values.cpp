// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/plan_values.hpp"

#include <limits>
#include <nlohmann/json.hpp>

namespace volute {
namespace {

/// Rows of what `at` says about each eye; null elsewhere.
template <class At>
Json rowsBy(const PlanValues& values, At&& at) {
  const FloorPlan& plan = *values.plan;
  std::vector<Json> all(plan.size());
  for (std::size_t i = 0; i < values.places.size(); ++i) all[values.places[i]] = at(i);
  if (values.parts != nullptr) {
    std::string text;
    for (std::size_t i = 0; i < all.size(); ++i) {
      text += i == 0 ? "[\n[" : (i % static_cast<std::size_t>(plan.nx) == 0 ? "],\n[" : ",");
      if (all[i].is_number_float())
        appendJson(text, all[i].get<double>());
      else
        text += all[i].dump(-1, ' ', false, Json::error_handler_t::replace);
    }
    return values.parts->add(text += "]\n]");
  }
  Json rows = Json::array();
  for (int y = 0; y < plan.ny; ++y) {
    Json row = Json::array();
    for (int x = 0; x < plan.nx; ++x)
      row.push_back(std::move(all[static_cast<std::size_t>(y) * plan.nx + x]));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

std::vector<float> PlanValues::cells(std::span<const double> values) const {
  std::vector<float> out(plan->size(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < places.size(); ++i) out[places[i]] = static_cast<float>(values[i]);
  return out;
}

Json PlanValues::rows(std::span<const double> values) const {
  return rowsBy(*this, [&](std::size_t i) { return jsonNumber(values[i]); });
}

Json PlanValues::rowsOfJson(std::span<const Json> values) const {
  return rowsBy(*this, [&](std::size_t i) { return values[i]; });
}

Json PlanValues::rowsOfText(std::span<const std::string> texts) const {
  return rowsBy(*this, [&](std::size_t i) { return texts[i].empty() ? Json() : Json(texts[i]); });
}

}  // namespace volute
