// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <optional>

#include "volute/visibility/exposure_meter.hpp"
#include "volute/visibility/plan_picture.hpp"
#include "volute/visibility/plan_values.hpp"
#include "volute/visibility/plan_vti.hpp"
#include "volute/visibility/watch.hpp"

namespace volute {

/// Tenability over a plan: when each criterion is reached at each point, which is the first of all,
/// and what is left of it after the time that people need.
class PlanTenability {
 public:
  /// With the survey's criteria and its field.
  /// @param shapes  what maps draw at its place, at the eyes' height
  /// @param signs   that maps draw
  PlanTenability(const Survey& survey, std::span<const Vec3> eyes, PlanValues values,
                 std::vector<PlanShape> shapes, std::vector<SightTarget> signs);

  /// Each time; those between stored ones are passed over.
  [[nodiscard]] Status take(const SurveyTime& at);

  /// Writes maps, adds to the report, the arrays of aset.vti and the verdict, and returns its part
  /// of the page.
  /// @param signs  losses of sight of all signs, rounded up in depth; `inSight` where one is seen
  ///               before there is smoke.
  [[nodiscard]] Result<std::string> finish(const LossTimes& signs, const std::vector<bool>& inSight,
                                           Json& report, std::vector<PlanArray>& arrays,
                                           Json& verdict);

 private:
  /// A map in which nothing is said of any point yet.
  PlanPicture emptyPicture(std::string title) const;
  Json criterionJson(std::size_t c) const;
  void combine(const LossTimes& signs, const std::vector<bool>& inSight);
  /// @param unknown  whether a criterion, or any of them, has no data at an eye
  Status writeTimes(const std::string& name, const std::string& title,
                    std::span<const double> times,
                    const std::function<bool(std::size_t eye)>& unknown) const;
  Status writeFirst() const;
  Result<std::string> margin(Json& report, std::vector<PlanArray>& arrays, Json& verdict);
  Json sentence(std::size_t c) const;

  const Survey* survey_;
  std::span<const Vec3> eyes_;
  PlanValues values_;
  std::vector<PlanShape> shapes_;
  std::vector<SightTarget> signs_;
  ExposureMeter meter_;
  LossTimes all_;           // of all criteria together
  std::vector<int> which_;  // the first: -1 none, 0 sight of signs, else criterion + 1
};

/// The criteria of a survey as a report's list, with what was missing and assumed.
Json criteriaJson(const ExposureMeter& meter);

/// The same as a table of the page.
std::string criteriaTable(const ExposureMeter& meter);

}  // namespace volute
