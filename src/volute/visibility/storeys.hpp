// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <span>
#include <string>

#include "volute/visibility/survey_job.hpp"

namespace volute {

/// A plan of each storey: a folder with one survey of each height of the eyes, visibility.json and
/// a page that shows all. Appears whole or not at all. The summary has the sight lines of all, the
/// verdict of each and the mean of the shares. Collective, and so is `survey`.
/// @param heights  z of the eyes [m], at least one
/// @param pdf  print that page as report.pdf; a remark where that cannot be
/// @param survey  does one of them into a folder
[[nodiscard]] Result<SurveySummary> surveyStoreys(
    std::span<const double> heights, const std::string& output, bool pdf, Progress& progress,
    Team& team, const std::function<Result<SurveySummary>(double, const std::string&)>& survey);

}  // namespace volute
