// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "volute/base/team.hpp"

namespace volute {

/// What each rank did, in their order: the units of each stage, seconds of wall and CPU time,
/// seconds that it waited, the largest amount of memory [bytes]. Collective.
[[nodiscard]] Result<nlohmann::ordered_json> teamStats(Team& team);

}  // namespace volute
