// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "volute/fds/fds_volume.hpp"
#include "volute/io/reading.hpp"

namespace volute {

/// The smoke of an FDS case as a volume; `source` names what it is read from, empty: the best that
/// fills meshes. Says in remarks what is read and what is left out.
[[nodiscard]] Result<std::unique_ptr<FdsVolume>> openFdsVolume(const std::string& path,
                                                               const std::string& source,
                                                               std::optional<Box3> bounds,
                                                               std::optional<int> mesh,
                                                               Reading& reading);

}  // namespace volute
