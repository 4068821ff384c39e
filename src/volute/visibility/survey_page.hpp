// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/visibility/watch.hpp"

namespace volute {

/// Writes report.html, which needs no other files: what was asked, the criteria and their sources,
/// the share of eyes that see a sign over time, and `body`.
[[nodiscard]] Status writeSurveyPage(const std::filesystem::path& file, const Json& report,
                                     const std::string& body);

}  // namespace volute
