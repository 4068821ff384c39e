// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "volute/viewer/document.hpp"

namespace volute {

/// Opens whatever the viewer shows: a scene, a volume, a map of fog, smoke on a mesh, an FDS case,
/// a capture of any kind.
/// @param maxMemory  [bytes]
/// @param smoke  members of a scene's smoke ("field", "quantity", "unit"), for cases alone
OpenDocument documentOpener(std::uint64_t maxMemory, nlohmann::ordered_json smoke = {});

}  // namespace volute
