// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/fog/plane_walk.hpp"
#include "volute/wavelet/spline_pyramid.hpp"

namespace volute {

/// Giroud and Biri 2010 as they describe it, in double and without SIMD: the timed baseline of the
/// merged walk, which it must agree with. Decomposes by the shortest CDF wavelet of the degree, on
/// cells of side 1 with a wide margin; no profile.
///
/// Rays and distances are those of the map: coefficient (i, j) peaks at i + (degree + 1) / 2.
class PaperFog {
 public:
  PaperFog(const SplineGrid& map, int degree, int levels);

  /// Each level on its own distance mu^l |OP| (equation 12), in the four bases phi phi, phi psi,
  /// psi phi, psi psi (equation 10, mended), on the cells of the coarser level.
  double undeconstructed(const PlaneRay& ray, double distance, double mu) const;

  /// The same, each detail band turned back into splines of its own resolution (section 4.4).
  double deconstructed(const PlaneRay& ray, double distance, double mu) const;

  /// One walk over the sums of the bands that are active at each distance.
  double merged(const PlaneRay& ray, double distance, double mu) const;

  /// A grid at one level, and the cells where it is not zero.
  struct Band {
    SplineGrid grid;
    CellRect cells;
  };

  /// The three sets of wavelet coefficients between a level and the next coarser one.
  struct Wavelets {
    SplineGrid phiPsi, psiPhi, psiPsi;  ///< first letter: along x
    CellRect cells;                     ///< of the finer level
  };

  int degree() const { return degree_; }

  int levels() const { return levels_; }

  /// Cells of the finest level around the map.
  double margin() const { return margin_; }

  /// The sum of all bands from the coarsest to a level.
  const Band& approximation(int level) const { return merged_[level]; }

  /// What a level adds to the next coarser one, in its own splines and in wavelets.
  const Band& detail(int level) const { return details_[level]; }

  const Wavelets& wavelets(int level) const { return wavelets_[level]; }

 private:
  double bandIntegral(const Band& band, int level, const PlaneRay& ray, double begin,
                      double end) const;
  double waveletIntegral(const Wavelets& wavelets, int level, const PlaneRay& ray,
                         double end) const;
  double waveletDensity(const Wavelets& wavelets, int x, int y, double u, double v) const;
  PlaneRay inLevel(const PlaneRay& ray, int level) const;

  int degree_ = 1, levels_ = 0;
  double margin_ = 0;
  std::vector<Band> merged_, details_;
  std::vector<Wavelets> wavelets_;
};

/// The paper's tables of paths through a unit cell (section 4.3): the integrals of the four
/// bilinear functions, with the length of the chord, over samples of where the ray enters and
/// leaves on the perimeter; bilinear between samples. Rays that begin or end inside a cell take the
/// closed form.
class PathTable {
 public:
  /// @param samples  on each edge of the cell
  explicit PathTable(int samples);

  /// Through a map of degree 1.
  double depth(const SplineGrid& map, const PlaneRay& ray, double end) const;

 private:
  struct Corners {
    float value[4] = {0, 0, 0, 0};
  };

  const Corners& entry(int a, int b) const;

  int side_ = 0;  ///< samples on the perimeter
  std::vector<Corners> table_;
};

}  // namespace volute
