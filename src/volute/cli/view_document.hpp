// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/base/result.hpp"
#include "volute/viewer/document.hpp"

namespace volute::cli {

/// A volume, a map of fog (.png) or a scene, for the viewer. `maxMemory` in bytes.
OpenDocument documentOpener(std::uint64_t maxMemory);

}  // namespace volute::cli
