// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "volute/base/result.hpp"
#include "volute/report/json.hpp"

namespace volute {

/// What a survey's page is made of.
struct SurveyPage {
  Json report;       ///< as in visibility.json
  std::string body;  ///< maps, tenability and pictures: HTML
};

/// Writes report.html, which needs no other files: the verdict, what was asked, the criteria and
/// their sources, the share of eyes that see a sign over time, and the body.
[[nodiscard]] Status writeSurveyPage(const std::filesystem::path& file, const SurveyPage& page);

/// The same of surveys of one case from several heights: what they share stands there once, the
/// rest of each begins on a new page.
/// @param heights  z of the eyes [m], as many as `storeys`
[[nodiscard]] Status writeStoreysPage(const std::filesystem::path& file,
                                      std::span<const double> heights,
                                      std::span<const SurveyPage> storeys);

}  // namespace volute
