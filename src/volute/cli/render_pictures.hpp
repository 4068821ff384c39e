// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/base/progress.hpp"
#include "volute/base/team.hpp"
#include "volute/cli/picture_writer.hpp"
#include "volute/cli/render_job.hpp"

namespace volute::cli {

/// Renders and writes every moment of a job; settles the exposure first when it is to be found
/// (0). A picture is a unit of work: ranks write their stills themselves, and send pictures of a
/// film to rank 0, which writes them in order and holds a few at most. Collective.
[[nodiscard]] Status renderPictures(RenderJob& job, const std::string& target,
                                    Development& development, std::uint64_t maxMemory,
                                    Progress& progress, Team& team);

/// What --stats writes, of all ranks together. Collective.
[[nodiscard]] Result<nlohmann::ordered_json> sumOfStats(const RenderJob& job, Team& team);

}  // namespace volute::cli
