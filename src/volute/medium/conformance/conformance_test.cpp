// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/medium/conformance.hpp"

#include "volute/math/rotation.hpp"
#include "volute/medium/affine_medium.hpp"
#include "volute/medium/conformance/dummy_media.hpp"

namespace volute {
namespace {

/// Turned about a slanted axis, mirrored, sheared if so, and moved.
conformance::MediumUnderTest turned(AnyMedium medium, double shear = 0) {
  Mat3 skew = Vec3(1, 1, -1).asDiagonal();
  skew(0, 1) = shear, skew(1, 2) = -0.5 * shear, skew(2, 2) -= 0.3 * shear;
  const Mat3 turn = turnAbout(Vec3(1, -2, 0.5).normalized(), 0.8) * skew;
  conformance::Traits traits;
  // The suite's Simpson ends near jumps that do not lie along the axes.
  traits.tolerance.quadrature = 5e-3;
  return conformance::underTest(AffineMedium(std::move(medium), {turn, Vec3(0.3, -1, 2)}), traits);
}

}  // namespace

VOLUTE_CONFORMANCE(TrilinearVoxels, conformance::trilinearVoxelsUnderTest());
VOLUTE_CONFORMANCE(Atmosphere, conformance::atmosphereUnderTest());
VOLUTE_CONFORMANCE(TwoBoxes, conformance::twoBoxesUnderTest());
VOLUTE_CONFORMANCE(TurnedVoxels, turned(conformance::trilinearVoxelsUnderTest().medium));
VOLUTE_CONFORMANCE(TurnedBoxes, turned(conformance::twoBoxesUnderTest().medium));
VOLUTE_CONFORMANCE(ShearedVoxels, turned(conformance::trilinearVoxelsUnderTest().medium, 0.6));

}  // namespace volute
