// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/math/box.hpp"

namespace volute {

/// What the files of a medium say, as far as its controls depend on it.
struct MediumFacts {
  int frames = 1;
  double seconds = 0;            ///< from its first frame to its last
  Box3 bounds{};                 ///< of a volume: the file's own, before its transform [m]
  double largestExtinction = 0;  ///< of smoke on a mesh [1/m]; 0: not known
};

/// Of the scene's media and billboards, in the order of its file.
struct SceneFacts {
  std::vector<MediumFacts> media, billboards;
};

}  // namespace volute
