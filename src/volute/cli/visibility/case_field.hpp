// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "volute/cli/arguments.hpp"
#include "volute/cli/context.hpp"
#include "volute/cli/option.hpp"
#include "volute/visibility/sight_field.hpp"

namespace volute::cli {

/// The smoke of a case as sight lines ask for it.
struct SightCase {
  std::unique_ptr<SightField> field;
  std::string smoke;                 ///< where the extinction comes from, for people
  std::vector<std::string> remarks;  ///< what the case's reader has to say
};

/// Opens smoke on tetrahedra (.vtu, .pvd) or an FDS case (.smv).
[[nodiscard]] Result<SightCase> openSightCase(const std::string& path, const Arguments& arguments,
                                              Context& context);

/// What the field of a case means; those of a scene's smoke.
std::vector<Option> sightCaseOptions();

}  // namespace volute::cli
