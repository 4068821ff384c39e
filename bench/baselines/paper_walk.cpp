// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/baselines/paper_walk.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "volute/fog/cell_spline.hpp"
#include "volute/math/quadrature.hpp"

namespace volute {
namespace {

/// The cells that coefficients other than zero reach.
CellRect reached(const SplineGrid& grid, int degree) {
  CellRect rect{grid.columns + degree, grid.rows + degree, 0, 0};
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) {
      if (grid.at(i, j) != 0)
        rect = {std::min(rect.x0, i), std::min(rect.y0, j), std::max(rect.x1, i + degree + 1),
                std::max(rect.y1, j + degree + 1)};
    }
  }
  return rect;
}

SplineGrid turned(const SplineGrid& grid) {
  SplineGrid out(grid.rows, grid.columns);
  for (int j = 0; j < grid.rows; ++j)
    for (int i = 0; i < grid.columns; ++i) out.at(j, i) = grid.at(i, j);
  return out;
}

/// Along x: coarse column k = sum of taps_n * fine column 2k + first + n.
SplineGrid analysed(const SplineGrid& fine, const std::vector<double>& taps, int first) {
  SplineGrid coarse(fine.columns / 2, fine.rows);
  for (int j = 0; j < fine.rows; ++j) {
    for (int k = 0; k < coarse.columns; ++k) {
      for (std::size_t n = 0; n < taps.size(); ++n)
        coarse.at(k, j) += taps[n] * fine.orZero(2 * k + first + static_cast<int>(n), j);
    }
  }
  return coarse;
}

SplineGrid analysedBoth(const SplineGrid& fine, const std::vector<double>& x, int firstX,
                        const std::vector<double>& y, int firstY) {
  return turned(analysed(turned(analysed(fine, x, firstX)), y, firstY));
}

/// Where the splines and wavelets of the coarser level are at u in cell `cell` of the finer one.
struct CoarseWeights {
  int firstSpline, firstWavelet;  ///< of those that touch the cell
  int splines, wavelets;          ///< how many do
  std::array<double, 4> spline{};
  std::array<double, 8> wavelet{};

  CoarseWeights(const CdfFilters& filters, const std::vector<double>& p, int cell, double u) {
    const int d = filters.degree;
    const auto fine = splineWeights(d, u);
    const int first = cell - d;  // the first fine coefficient that touches the cell
    const int wide = static_cast<int>(filters.wavelet.size());
    firstSpline = floorHalf(first - d);
    firstWavelet = floorHalf(first - filters.waveletFirst - wide + 2);
    splines = floorHalf(cell) - firstSpline + 1;
    wavelets = floorHalf(cell - filters.waveletFirst) - firstWavelet + 1;
    for (int i = 0; i <= d; ++i) {
      add(spline, p, first + i - 2 * firstSpline, fine[i]);
      add(wavelet, filters.wavelet, first + i - filters.waveletFirst - 2 * firstWavelet, fine[i]);
    }
  }

 private:
  static int floorHalf(int n) { return n >= 0 ? n / 2 : -((1 - n) / 2); }

  /// A fine spline is part of coarse function k with the tap n - 2k.
  template <std::size_t N>
  static void add(std::array<double, N>& to, const std::vector<double>& taps, int n, double by) {
    const int last = static_cast<int>(taps.size()) - 1;
    for (int k = std::max(0, (n - last + 1) / 2); 2 * k <= n && n - 2 * k <= last; ++k)
      to[k] += by * taps[n - 2 * k];
  }
};

/// The sum over `countX` by `countY` coefficients from (firstX, firstY) on.
double weighted(const SplineGrid& grid, int firstX, int countX, const double* x, int firstY,
                int countY, const double* y) {
  double sum = 0;
  for (int j = 0; j < countY; ++j) {
    double row = 0;
    for (int i = 0; i < countX; ++i) row += x[i] * grid.orZero(firstX + i, firstY + j);
    sum += y[j] * row;
  }
  return sum;
}

}  // namespace

PaperFog::PaperFog(const SplineGrid& map, int degree, int levels)
    : degree_(degree), levels_(levels) {
  // Wide enough that the filters of no level reach the border.
  const int margin = 8 << levels, step = 1 << levels;
  SplineGrid wide(map.columns + 2 * margin, map.rows + 2 * margin);
  wide.columns += (step - (wide.columns + degree) % step) % step;
  wide.rows += (step - (wide.rows + degree) % step) % step;
  wide = SplineGrid(wide.columns, wide.rows);
  for (int j = 0; j < map.rows; ++j)
    for (int i = 0; i < map.columns; ++i) wide.at(i + margin, j + margin) = map.at(i, j);
  margin_ = margin;
  merged_.push_back({wide, reached(wide, degree)});
  const CdfFilters& f = shortestCdf(degree);
  for (int level = 0; level < levels; ++level) {
    const SplineGrid& fine = merged_.back().grid;
    SplineGrid coarse = restricted(fine, degree, Restriction::kCdf);
    const SplineGrid detail = difference(fine, prolonged(coarse, degree));
    const CellRect cells = reached(detail, degree);
    details_.push_back({detail, cells});
    wavelets_.push_back({analysedBoth(fine, f.low, f.lowFirst, f.high, f.highFirst),
                         analysedBoth(fine, f.high, f.highFirst, f.low, f.lowFirst),
                         analysedBoth(fine, f.high, f.highFirst, f.high, f.highFirst), cells});
    merged_.push_back({coarse, reached(coarse, degree)});
  }
}

PlaneRay PaperFog::inLevel(const PlaneRay& ray, int level) const {
  const double by = std::ldexp(1.0, -level);
  return {(ray.ox + margin_) * by, (ray.oy + margin_) * by, ray.dx * by, ray.dy * by};
}

double PaperFog::bandIntegral(const Band& band, int level, const PlaneRay& ray, double begin,
                              double end) const {
  const PlaneRay local = inLevel(ray, level);
  double sum = 0;
  walkCells(local, band.cells, begin, end, [&](int x, int y, double b, double e) {
    const CellSpline cell(band.grid, degree_, x, y);
    const double middle = 0.5 * (b + e), length = e - b;
    sum += length * cell.mean(local.ox + local.dx * middle - x, local.oy + local.dy * middle - y,
                              local.dx * length, local.dy * length);
  });
  return sum;
}

double PaperFog::waveletDensity(const Wavelets& wavelets, int x, int y, double u, double v) const {
  static const std::vector<double> twoScales[] = {twoScale(0), twoScale(1), twoScale(2),
                                                  twoScale(3)};
  const CdfFilters& f = shortestCdf(degree_);
  const CoarseWeights wx(f, twoScales[degree_], x, u), wy(f, twoScales[degree_], y, v);
  const auto sum = [](const SplineGrid& grid, const CoarseWeights& x, bool waveletX,
                      const CoarseWeights& y, bool waveletY) {
    return weighted(
        grid, waveletX ? x.firstWavelet : x.firstSpline, waveletX ? x.wavelets : x.splines,
        waveletX ? x.wavelet.data() : x.spline.data(), waveletY ? y.firstWavelet : y.firstSpline,
        waveletY ? y.wavelets : y.splines, waveletY ? y.wavelet.data() : y.spline.data());
  };
  return sum(wavelets.phiPsi, wx, false, wy, true) + sum(wavelets.psiPhi, wx, true, wy, false) +
         sum(wavelets.psiPsi, wx, true, wy, true);
}

double PaperFog::waveletIntegral(const Wavelets& wavelets, int level, const PlaneRay& ray,
                                 double end) const {
  // psi has knots at half integers of its own cells: those are the cells of the finer level.
  const PlaneRay local = inLevel(ray, level);
  double sum = 0;
  walkCells(local, wavelets.cells, 0, end, [&](int x, int y, double b, double e) {
    sum += gaussIntegral(degree_ == 0 ? 2 : degree_ + 1, b, e, [&](double s) {
      return waveletDensity(wavelets, x, y, local.ox + local.dx * s - x,
                            local.oy + local.dy * s - y);
    });
  });
  return sum;
}

double PaperFog::undeconstructed(const PlaneRay& ray, double distance, double mu) const {
  double sum = bandIntegral(merged_[levels_], levels_, ray, 0, distance);
  for (int level = levels_ - 1; level >= 0; --level)
    sum += waveletIntegral(wavelets_[level], level, ray, distance * std::pow(mu, levels_ - level));
  return sum;
}

double PaperFog::deconstructed(const PlaneRay& ray, double distance, double mu) const {
  double sum = bandIntegral(merged_[levels_], levels_, ray, 0, distance);
  for (int level = levels_ - 1; level >= 0; --level)
    sum += bandIntegral(details_[level], level, ray, 0, distance * std::pow(mu, levels_ - level));
  return sum;
}

double PaperFog::merged(const PlaneRay& ray, double distance, double mu) const {
  double sum = 0, begin = 0;
  for (int level = 0; level <= levels_; ++level) {
    const double end = distance * std::pow(mu, levels_ - level);
    if (end > begin)
      sum += bandIntegral(merged_[level], level, ray, begin, end);
    begin = std::max(begin, end);
  }
  return sum;
}

namespace {

/// From 0 to 4 around the cell: bottom, right, top, left.
double perimeter(double u, double v) {
  const double toBottom = v, toRight = 1 - u, toTop = 1 - v, toLeft = u;
  const double least = std::min({toBottom, toRight, toTop, toLeft});
  if (least == toBottom)
    return u;
  if (least == toRight)
    return 1 + v;
  return least == toTop ? 3 - u : 4 - v;
}

std::array<double, 2> onPerimeter(double p) {
  if (p < 1)
    return {p, 0};
  if (p < 2)
    return {1, p - 1};
  if (p < 3)
    return {3 - p, 1};
  return {0, 4 - p};
}

/// The means of (1-u)(1-v), u(1-v), (1-u)v, uv over a chord.
std::array<double, 4> cornerMeans(double u0, double v0, double u1, double v1) {
  const double um = 0.5 * (u0 + u1), vm = 0.5 * (v0 + v1);
  const double uv = um * vm + (u1 - u0) * (v1 - v0) / 12;
  return {1 - um - vm + uv, um - uv, vm - uv, uv};
}

}  // namespace

PathTable::PathTable(int samples)
    : side_(4 * samples), table_(static_cast<std::size_t>(side_) * side_) {
  for (int a = 0; a < side_; ++a) {
    for (int b = 0; b < side_; ++b) {
      const auto from = onPerimeter(4.0 * a / side_), to = onPerimeter(4.0 * b / side_);
      const double chord = std::hypot(to[0] - from[0], to[1] - from[1]);
      const auto means = cornerMeans(from[0], from[1], to[0], to[1]);
      Corners& corners = table_[static_cast<std::size_t>(a) * side_ + b];
      for (int k = 0; k < 4; ++k) corners.value[k] = static_cast<float>(chord * means[k]);
    }
  }
}

const PathTable::Corners& PathTable::entry(int a, int b) const {
  return table_[static_cast<std::size_t>(a % side_) * side_ + b % side_];
}

double PathTable::depth(const SplineGrid& map, const PlaneRay& ray, double end) const {
  const CellRect cells{0, 0, map.columns + 1, map.rows + 1};
  const double perCell = 1 / std::hypot(ray.dx, ray.dy);  // length in space of one cell
  double sum = 0;
  walkCells(ray, cells, 0, end, [&](int x, int y, double b, double e) {
    const double c[4] = {map.orZero(x - 1, y - 1), map.orZero(x, y - 1), map.orZero(x - 1, y),
                         map.orZero(x, y)};
    const auto place = [](double o, double d, double s, int cell) {
      return std::clamp(o + d * s - cell, 0.0, 1.0);
    };
    const double u0 = place(ray.ox, ray.dx, b, x), v0 = place(ray.oy, ray.dy, b, y);
    const double u1 = place(ray.ox, ray.dx, e, x), v1 = place(ray.oy, ray.dy, e, y);
    if (b == 0 || e == end) {
      const auto means = cornerMeans(u0, v0, u1, v1);
      for (int k = 0; k < 4; ++k) sum += (e - b) * means[k] * c[k];
      return;
    }
    const double from = perimeter(u0, v0) * side_ / 4, to = perimeter(u1, v1) * side_ / 4;
    const int i = static_cast<int>(from), j = static_cast<int>(to);
    const double p = from - i, q = to - j;
    double integral = 0;
    for (int k = 0; k < 4; ++k) {
      integral +=
          c[k] * ((1 - p) * ((1 - q) * entry(i, j).value[k] + q * entry(i, j + 1).value[k]) +
                  p * ((1 - q) * entry(i + 1, j).value[k] + q * entry(i + 1, j + 1).value[k]));
    }
    sum += integral * perCell;
  });
  return sum;
}

}  // namespace volute
