// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "volute/cli/context.hpp"
#include "volute/fds/fds_volume.hpp"

namespace volute::cli {

/// The smoke of an FDS case as a volume; `source` names what it is read from, empty: the best that
/// fills meshes. Says in remarks what is read and what is left out.
[[nodiscard]] Result<std::unique_ptr<FdsVolume>> openFdsVolume(const std::string& path,
                                                               const std::string& source,
                                                               std::optional<Box3> bounds,
                                                               std::optional<int> mesh,
                                                               Context& context);

/// What is in a case, and which source says how thick its smoke is. With `values` the extremes of
/// the extinction over all stored times.
[[nodiscard]] Result<Report> describeFdsCase(const std::string& path, const std::string& source,
                                             bool values, Context& context);

}  // namespace volute::cli
