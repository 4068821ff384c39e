// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>

#include "volute/viewer/document.hpp"

namespace volute {

/// Opens whatever the viewer shows: a scene, a volume, a map of fog, smoke on a mesh, an FDS case,
/// a capture of any kind. `maxMemory` in bytes.
OpenDocument documentOpener(std::uint64_t maxMemory);

}  // namespace volute
