// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_share.hpp"

#include <algorithm>

namespace volute {

Result<std::vector<bool>> meshesOfShare(const SmvIndex& index, const FdsShare& share) {
  const std::size_t count = index.meshes.size();
  const auto shares = static_cast<std::size_t>(share.count);
  if (shares > count) {
    return fail(ErrorCode::kUnsupported,
                "{}: has {} meshes, and {} ranks cannot hold one each; start {} at most",
                index.path.string(), count, shares, count);
  }
  double all = 0;
  for (const FdsMesh& mesh : index.meshes) all += static_cast<double>(mesh.cellCount());
  std::vector<bool> held(count, false);
  double before = 0;
  std::size_t now = 0, ofNow = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto cells = static_cast<double>(index.meshes[i].cellCount());
    const bool full = before + 0.5 * cells >= all * static_cast<double>(now + 1) / shares;
    const bool needed = count - i == shares - now - 1;  // one for each share that is left
    if (ofNow > 0 && now + 1 < shares && (full || needed)) {
      ++now;
      ofNow = 0;
    }
    ++ofNow;
    before += cells;
    held[i] = now == static_cast<std::size_t>(share.index);
  }
  return held;
}

}  // namespace volute
