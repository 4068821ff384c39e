// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/tet_project.hpp"

namespace volute {
namespace {

constexpr std::int8_t kThick = ProjectedTet::kThick;

void addTriangle(ProjectedTet& tet, int a, int b, std::int8_t c) {
  tet.corners[tet.triangles++] = {static_cast<std::int8_t>(a), static_cast<std::int8_t>(b), c};
}

/// The eye sees all faces from within.
ProjectedTet around(const std::array<double, 4>& shares) {
  ProjectedTet tet;
  tet.shape = TetClass::kAround;
  tet.front = shares;
  for (int across = 0; across < 4; ++across) {
    const int a = across == 0 ? 1 : 0, b = across <= 1 ? 2 : 1, c = across <= 2 ? 3 : 2;
    addTriangle(tet, a, b, static_cast<std::int8_t>(c));
  }
  return tet;
}

}  // namespace

std::array<double, 4> eyeShares(const TetMesh& mesh, std::int32_t tet, const TetEye& eye) {
  if (!eye.orthographic)
    return mesh.shares(tet, eye.point);
  std::array<double, 4> shares{};
  const auto slopes = mesh.slopes(tet);
  for (int i = 0; i < 4; ++i) shares[i] = -slopes[i].dot(eye.forward);
  return shares;
}

ProjectedTet projectTet(const std::array<double, 4>& eyeShares) {
  int positive[4], negative[4], positives = 0, negatives = 0;
  double before = 0, behind = 0;
  for (int i = 0; i < 4; ++i) {
    if (eyeShares[i] >= 0) {
      positive[positives++] = i;
      before += eyeShares[i];
    } else {
      negative[negatives++] = i;
      behind += eyeShares[i];
    }
  }
  if (negatives == 0)
    return around(eyeShares);
  ProjectedTet tet;
  if (!(before > 0) || !(behind < 0))  // a tet that rounding has made flat: nothing to draw
    return tet;
  // The eye is the sum of shares times vertices, so that the positive ones' mean, the negative
  // ones' and the eye lie on one ray, and the positive ones' is between the others.
  for (int i = 0; i < positives; ++i) tet.front[positive[i]] = eyeShares[positive[i]] / before;
  for (int i = 0; i < negatives; ++i) tet.back[negative[i]] = eyeShares[negative[i]] / behind;
  if (positives == 2) {
    tet.shape = TetClass::kQuad;
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) addTriangle(tet, positive[i], negative[j], kThick);
    }
    return tet;
  }
  const int* face = positives == 3 ? positive : negative;
  for (int i = 0; i < 3; ++i) addTriangle(tet, face[i], face[(i + 1) % 3], kThick);
  return tet;
}

}  // namespace volute
