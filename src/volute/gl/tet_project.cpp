// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/tet_project.hpp"

namespace volute {

std::array<double, 4> eyeShares(const TetMesh& mesh, std::int32_t tet, const ViewOrigin& view) {
  if (!view.orthographic)
    return mesh.shares(tet, view.eye);
  std::array<double, 4> shares{};
  const auto slopes = mesh.slopes(tet);
  for (int i = 0; i < 4; ++i) shares[i] = -slopes[i].dot(view.forward);
  return shares;
}

ProjectedTet projectTet(const std::array<double, 4>& eyeShares) {
  std::int8_t positive[4], negative[4];
  int positives = 0, negatives = 0;
  for (std::int8_t i = 0; i < 4; ++i) {
    if (eyeShares[i] >= 0)
      positive[positives++] = i;
    else
      negative[negatives++] = i;
  }
  // The eye is the sum of shares times vertices, so that the positive ones' mean, the negative
  // ones' and the eye lie on one ray: what they span is seen to cross.
  if (positives == 2)
    return {TetClass::kQuad, 4, {positive[0], negative[0], positive[1], negative[1]}};
  if (positives == 3)
    return {TetClass::kTriangle, 3, {positive[0], positive[1], positive[2], negative[0]}};
  if (positives == 1)
    return {TetClass::kTriangle, 3, {negative[0], negative[1], negative[2], positive[0]}};
  return {};
}

}  // namespace volute
