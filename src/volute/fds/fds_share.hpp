// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/base/result.hpp"
#include "volute/fds/smv_index.hpp"

namespace volute {

/// Which meshes of a case are held in memory: all, or one of `count` shares of them.
struct FdsShare {
  int index = 0;
  int count = 1;
};

/// Whether each mesh belongs to a share. Shares are runs of meshes in the order of the index, which
/// have about as many cells each, and one mesh at least. kUnsupported for more shares than meshes.
[[nodiscard]] Result<std::vector<bool>> meshesOfShare(const SmvIndex& index, const FdsShare& share);

}  // namespace volute
