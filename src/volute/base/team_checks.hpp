// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "volute/base/team.hpp"

namespace volute {

/// Fails on all ranks alike unless all were started as the same program with the same arguments.
/// Collective.
[[nodiscard]] Status checkSameProgram(Team& team, std::string_view version,
                                      const std::vector<std::string>& arguments);

/// Fails on all ranks unless all see the folder that `target` will lie in: rank 0 writes a file
/// there for a short time. Collective.
[[nodiscard]] Status checkFolderIsShared(const std::string& target, Team& team);

}  // namespace volute
