// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fog/fog_testing.hpp"
#include "volute/medium/conformance.hpp"

namespace volute {
namespace {

conformance::Traits traits(const FogMedium& fog) {
  conformance::Traits traits;
  const CellRect cells = fog.levels().mapCells();
  const Vec3 corner = fog.domainCorner();
  for (int x = cells.x0; x <= cells.x1; ++x)
    traits.planes[0].push_back(corner.x() + x * fog.cell());
  for (int y = cells.y0; y <= cells.y1; ++y)
    traits.planes[1].push_back(corner.y() + y * fog.cell());
  for (const auto& zone : fog.profile().zones()) {
    if (zone.bottom > -1000)
      traits.planes[2].push_back(corner.z() + zone.bottom);
  }
  Box3 region = fog.bounds();
  region.min.z() = std::max(region.min.z(), corner.z() - 4);
  region.max.z() = std::min(region.max.z(), corner.z() + 9);
  traits.region = region;
  // The adaptive Simpson of the suite steps over the corners where the density or the profile jump.
  traits.tolerance.quadrature = 5e-3;
  return traits;
}

/// What a FogMedium says in double: all but its fast path.
class InDouble {
 public:
  explicit InDouble(FogMedium fog) : fog_(std::move(fog)) {}

  Box3 bounds() const { return fog_.bounds(); }

  double extinction(const Vec3& point) const { return fog_.extinction(point); }

  Rgb emission(const Vec3& point) const { return fog_.emission(point); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    fog_.opticalDepth(segments, depths);
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    fog_.pieces(segments, pieces);
  }

  std::vector<double> coefficients() const { return fog_.coefficients(); }

  InDouble withCoefficients(std::span<const double> c) const {
    return InDouble(fog_.withCoefficients(c));
  }

 private:
  FogMedium fog_;
};

FogMedium make(int degree, std::size_t profile) {
  return fogtest::fog(fogtest::map(9, 7), fogtest::profiles()[profile].profile,
                      {.degree = degree, .levels = 2, .color = Rgb(0.8, 0.9, 1.1)});
}

conformance::MediumUnderTest inDouble(int degree, std::size_t profile) {
  const FogMedium fog = make(degree, profile);
  return conformance::underTest(InDouble(fog), traits(fog));
}

/// The fast path works in float.
conformance::MediumUnderTest inFloat(int degree, std::size_t profile) {
  const FogMedium fog = make(degree, profile);
  conformance::Traits loose = traits(fog);
  loose.tolerance.closedForm = 2e-6;
  return conformance::underTest(fog, loose);
}

conformance::MediumUnderTest withTop(int degree) {
  const FogMap map = *FogMap::fromCoefficients(fogtest::map(9, 7), {.cell = 1.3});
  FogMap top = *FogMap::fromCoefficients(fogtest::map(6, 6, 4, 1), {.cell = 2.1});
  for (double& height : top.coefficients.c) height = 1 + 4 * height;
  const FogMedium fog = *FogMedium::make(map, *FogProfile::slab(-1, 6), {.degree = degree}, top);
  conformance::Traits loose = traits(fog);
  loose.tolerance.points = 1e-8;  // the top is where a square root says
  return conformance::underTest(fog, loose);
}

VOLUTE_CONFORMANCE(Slab0, inDouble(0, 0));
VOLUTE_CONFORMANCE(Slab1, inDouble(1, 0));
VOLUTE_CONFORMANCE(Slab2, inDouble(2, 0));
VOLUTE_CONFORMANCE(Slab3, inDouble(3, 0));
VOLUTE_CONFORMANCE(Linear0, inDouble(0, 1));
VOLUTE_CONFORMANCE(Linear1, inDouble(1, 1));
VOLUTE_CONFORMANCE(Linear2, inDouble(2, 1));
VOLUTE_CONFORMANCE(Linear3, inDouble(3, 1));
VOLUTE_CONFORMANCE(Exponential0, inDouble(0, 2));
VOLUTE_CONFORMANCE(Exponential1, inDouble(1, 2));
VOLUTE_CONFORMANCE(Exponential2, inDouble(2, 2));
VOLUTE_CONFORMANCE(Exponential3, inDouble(3, 2));
VOLUTE_CONFORMANCE(Layers0, inDouble(0, 3));
VOLUTE_CONFORMANCE(Layers1, inDouble(1, 3));
VOLUTE_CONFORMANCE(Layers2, inDouble(2, 3));
VOLUTE_CONFORMANCE(Layers3, inDouble(3, 3));
VOLUTE_CONFORMANCE(Top0, withTop(0));
VOLUTE_CONFORMANCE(Top1, withTop(1));
VOLUTE_CONFORMANCE(Top2, withTop(2));
VOLUTE_CONFORMANCE(Top3, withTop(3));
VOLUTE_CONFORMANCE(FastSlab0, inFloat(0, 0));
VOLUTE_CONFORMANCE(FastSlab1, inFloat(1, 0));
VOLUTE_CONFORMANCE(FastSlab2, inFloat(2, 0));
VOLUTE_CONFORMANCE(FastSlab3, inFloat(3, 0));
VOLUTE_CONFORMANCE(FastLinear0, inFloat(0, 1));
VOLUTE_CONFORMANCE(FastLinear1, inFloat(1, 1));
VOLUTE_CONFORMANCE(FastLinear2, inFloat(2, 1));
VOLUTE_CONFORMANCE(FastLinear3, inFloat(3, 1));
VOLUTE_CONFORMANCE(FastExponential0, inFloat(0, 2));
VOLUTE_CONFORMANCE(FastExponential1, inFloat(1, 2));
VOLUTE_CONFORMANCE(FastExponential2, inFloat(2, 2));
VOLUTE_CONFORMANCE(FastExponential3, inFloat(3, 2));
VOLUTE_CONFORMANCE(FastLayers0, inFloat(0, 3));
VOLUTE_CONFORMANCE(FastLayers1, inFloat(1, 3));
VOLUTE_CONFORMANCE(FastLayers2, inFloat(2, 3));
VOLUTE_CONFORMANCE(FastLayers3, inFloat(3, 3));

}  // namespace
}  // namespace volute
