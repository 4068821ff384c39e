// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_shares.hpp"

#include "volute/fds/fds_share.hpp"

namespace volute {
namespace {

/// Which share each mesh belongs to.
Result<std::vector<int>> sharesOf(const SmvIndex& index, int shares) {
  std::vector<int> shareOf(index.meshes.size(), 0);
  for (int share = 0; share < shares; ++share) {
    VOLUTE_ASSIGN(const auto held, meshesOfShare(index, {share, shares}));
    for (std::size_t i = 0; i < held.size(); ++i) {
      if (held[i])
        shareOf[i] = share;
    }
  }
  return shareOf;
}

}  // namespace

Status checkShares(const FdsDescription& description, const SmvIndex& index, int shares,
                   bool burns) {
  if (!description.look.iso.empty()) {
    return fail(ErrorCode::kUnsupported,
                "{}: ranks that hold a share of its meshes each draw no iso-surfaces: leave them "
                "out, or let each rank hold all",
                description.file);
  }
  if (!burns)
    return {};
  VOLUTE_ASSIGN(const auto shareOf, sharesOf(index, shares));
  constexpr double kTouch = 1e-3;  // [m]
  for (std::size_t a = 0; a < shareOf.size(); ++a) {
    for (std::size_t b = a + 1; b < shareOf.size(); ++b) {
      const Box3 one = index.meshes[a].bounds(), other = index.meshes[b].bounds();
      const Vec3 common = one.max.cwiseMin(other.max) - one.min.cwiseMax(other.min);
      if (shareOf[a] == shareOf[b] || common.minCoeff() < kTouch)
        continue;
      return fail(ErrorCode::kUnsupported, Hint::set("fire", "0").so("leaves the fire out"),
                  "{}: meshes {} and {} overlap, so two ranks cannot hold one each where there is "
                  "fire; start fewer ranks",
                  description.file, a + 1, b + 1);
    }
  }
  return {};
}

}  // namespace volute
