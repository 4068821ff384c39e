// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/singular_values.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace volute {
namespace {

constexpr std::size_t kLanes = 8;
using Lanes = Eigen::Array<float, kLanes, 1>;

/// A symmetric matrix in each lane.
struct Symmetric {
  Lanes xx, yy, zz, xy, xz, yz;

  Lanes determinant() const {
    return xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  }
};

/// slopes' slopes, of which the eigenvalues are the squares of the singular values.
Symmetric squares(std::span<const ColourSlopes> slopes) {
  Symmetric g;
  for (Lanes* entry : {&g.xx, &g.yy, &g.zz, &g.xy, &g.xz, &g.yz}) entry->setZero();
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    const auto lane = static_cast<Eigen::Index>(i);
    const auto& [a, b, c] = slopes[i];
    g.xx[lane] = a[0] * a[0] + b[0] * b[0] + c[0] * c[0];
    g.yy[lane] = a[1] * a[1] + b[1] * b[1] + c[1] * c[1];
    g.zz[lane] = a[2] * a[2] + b[2] * b[2] + c[2] * c[2];
    g.xy[lane] = a[0] * a[1] + b[0] * b[1] + c[0] * c[1];
    g.xz[lane] = a[0] * a[2] + b[0] * b[2] + c[0] * c[2];
    g.yz[lane] = a[1] * a[2] + b[1] * b[2] + c[1] * c[2];
  }
  return g;
}

/// Descending; of matrices that have no negative ones (Smith 1961, "Eigenvalues of a symmetric 3 x
/// 3 matrix").
std::array<Lanes, 3> eigenvalues(const Symmetric& g) {
  const Lanes mean = (g.xx + g.yy + g.zz) / 3;
  Symmetric rest = g;
  rest.xx -= mean;
  rest.yy -= mean;
  rest.zz -= mean;
  const Lanes size = ((rest.xx.square() + rest.yy.square() + rest.zz.square() +
                       2 * (g.xy.square() + g.xz.square() + g.yz.square())) /
                      6)
                         .sqrt()
                         .max(1e-12F);
  const Lanes cosine = (rest.determinant() / (2 * size.cube())).max(-1.0F).min(1.0F);
  // cos(acos(cosine) / 3) of the half angle's cosine, to 1.2e-6.
  const Lanes u = (0.5F * (1 + cosine)).sqrt();
  const Lanes c =
      0.50000121F +
      u * (0.57725813F +
           u * (-0.10994401F + u * (0.047797095F + u * (-0.01930424F + u * 0.0041927417F))));
  constexpr float kRoot3 = 1.7320508F;
  const Lanes s = kRoot3 * (1 - c.square()).max(0.0F).sqrt();
  return {mean + 2 * size * c, (mean - size * (c - s)).max(0.0F),
          (mean - size * (c + s)).max(0.0F)};
}

/// min(1, 1 / sqrt(x)) of the matrices: the polynomial that takes its values at the three
/// eigenvalues, in Newton's form.
Symmetric shrinking(const Symmetric& g, const std::array<Lanes, 3>& value) {
  std::array<Lanes, 3> above, root;
  for (std::size_t k = 0; k < 3; ++k) {
    above[k] = value[k].max(1.0F);
    root[k] = above[k].sqrt();
  }
  // Without cancellation.
  const auto dividedDifference = [&](std::size_t a, std::size_t b) -> Lanes {
    return (above[b] - above[a]) /
           ((value[a] - value[b]).max(1e-9F * value[0]) * root[a] * root[b] * (root[a] + root[b]));
  };
  const Lanes none = root[0].inverse(), first = dividedDifference(0, 1);
  const Lanes width = value[0] - value[2];
  const Lanes second = (width > 1e-4F * value[0])
                           .select((first - dividedDifference(1, 2)) / width.max(1e-20F), 0.0F);
  const Lanes ax = g.xx - value[0], ay = g.yy - value[0], az = g.zz - value[0];
  const Lanes bx = g.xx - value[1], by = g.yy - value[1], bz = g.zz - value[1];
  const Lanes xy = g.xy.square(), xz = g.xz.square(), yz = g.yz.square();
  return {none + first * ax + second * (ax * bx + xy + xz),
          none + first * ay + second * (ay * by + xy + yz),
          none + first * az + second * (az * bz + xz + yz),
          first * g.xy + second * (ax * g.xy + g.xy * by + g.xz * g.yz),
          first * g.xz + second * (ax * g.xz + g.xy * g.yz + g.xz * bz),
          first * g.yz + second * (g.xy * g.xz + ay * g.yz + g.yz * bz)};
}

/// Whether all channels are the same: then there is one singular value, and rounding must not bring
/// colour into what has none.
bool allGrey(std::span<const ColourSlopes> slopes) {
  return std::ranges::all_of(slopes, [](const ColourSlopes& one) {
    return std::ranges::all_of(
        one, [](const Colour& slope) { return slope[0] == slope[1] && slope[1] == slope[2]; });
  });
}

void clipGrey(std::span<ColourSlopes> slopes) {
  for (ColourSlopes& one : slopes) {
    float squared = 0;
    for (const Colour& slope : one) squared += slope.square().sum();
    if (squared > 1) {
      for (Colour& slope : one) slope *= 1 / std::sqrt(squared);
    }
  }
}

}  // namespace

void clipSingularValues(std::span<ColourSlopes> slopes) {
  for (std::size_t begin = 0; begin < slopes.size(); begin += kLanes) {
    const auto block = slopes.subspan(begin, std::min(kLanes, slopes.size() - begin));
    if (allGrey(block)) {
      clipGrey(block);
      continue;
    }
    const Symmetric g = squares(block);
    if ((g.xx + g.yy + g.zz <= 1).all())
      continue;
    const auto value = eigenvalues(g);
    const Symmetric f = shrinking(g, value);
    for (std::size_t i = 0; i < block.size(); ++i) {
      const auto lane = static_cast<Eigen::Index>(i);
      if (value[0][lane] <= 1)
        continue;
      const Colour x(f.xx[lane], f.xy[lane], f.xz[lane], 0),
          y(f.xy[lane], f.yy[lane], f.yz[lane], 0), z(f.xz[lane], f.yz[lane], f.zz[lane], 0);
      for (Colour& slope : block[i]) slope = Colour(slope[0] * x + slope[1] * y + slope[2] * z);
    }
  }
}

}  // namespace volute
