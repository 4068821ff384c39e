// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/cli/arguments.hpp"
#include "volute/cli/context.hpp"
#include "volute/cli/option.hpp"
#include "volute/visibility/survey_job.hpp"

namespace volute::cli {

/// Opens smoke on tetrahedra (.vtu, .pvd) or an FDS case (.smv).
[[nodiscard]] Result<SightCase> openSightCase(const std::string& path, const Arguments& arguments,
                                              Context& context);

/// What the field of a case means; those of a scene's smoke.
std::vector<Option> sightCaseOptions();

}  // namespace volute::cli
