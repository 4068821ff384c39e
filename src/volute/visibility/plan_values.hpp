// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/report/json_parts.hpp"
#include "volute/visibility/floor_plan.hpp"

namespace volute {

/// A plan, and which of its points have eyes: values of eyes become values over the plan.
struct PlanValues {
  const FloorPlan* plan = nullptr;
  std::span<const std::size_t> places;  ///< of each eye in the plan
  JsonParts* parts = nullptr;           ///< where rows wait for their file; null: in the tree

  /// NaN where there is no eye. Shape (y, x).
  std::vector<float> cells(std::span<const double> values) const;

  /// Rows from the smallest y; null where there is no eye, or no finite value.
  Json rows(std::span<const double> values) const;

  /// The same of any values of the eyes; null where there is no eye.
  Json rowsOfJson(std::span<const Json> values) const;

  /// The same of texts; null where there is no eye, or no text.
  Json rowsOfText(std::span<const std::string> texts) const;
};

}  // namespace volute
