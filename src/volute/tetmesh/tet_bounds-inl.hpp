// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What a tet is before the pixels of a tile, for each SIMD target: included by kernels alone.
#if defined(VOLUTE_TETMESH_TET_BOUNDS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLUTE_TETMESH_TET_BOUNDS_INL
#undef VOLUTE_TETMESH_TET_BOUNDS_INL
#else
#define VOLUTE_TETMESH_TET_BOUNDS_INL
#endif

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "volute/math/float_lanes-inl.hpp"
#include "volute/tetmesh/tet_raster.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {
namespace {

static_assert(offsetof(FacePlane, offset) == 3 * sizeof(double));

constexpr int kBlock = TetTile::kBlock;
constexpr int kPixels = kBlock * kBlock;
constexpr float kEye = 1e-18F;  // [m]; the depth where rays begin

/// 1 / x but for the last bit or two.
HWY_INLINE VF Reciprocal(VF x) {
  const VF guess = hn::ApproximateReciprocal(x);
  return hn::Mul(guess, hn::NegMulAdd(x, guess, Constant(2)));
}

/// at + x dx + y dy, dx and dy in pixels from the tile's first.
struct Affine {
  float at, x, y;
};

/// A tet over a tile. A pixel's ray is inside while its inverse depth (orthographic: minus its
/// depth) is above the first `lows` bounds and below the others: each is affine over the picture.
struct TetBounds {
  Affine bound[4];
  int lows = 0;
  float lowest, highest;  // of the vertices
};

/// Four products at once: a function a . x + b of space over a tile's pixels is (a, b) times one of
/// these matrices, in double.
struct alignas(32) RowMatrix {
  double rows[4][4];
};

/// A tile's rays.
struct TileRays {
  RowMatrix plane;  ///< of a FacePlane: the bound times its divisor at the first pixel, its steps
                    ///< along x and y, the divisor
  RowMatrix field;  ///< of a LinearField: perspective: its slope along the depth, three as above,
                    ///< and its value at the eye; orthographic: its value at depth 0, three, and
                    ///< the slope

  TileRays(const ScreenView& view, int x0, int y0) {
    const Vec3 right = view.right / view.perPixel, down = view.down / view.perPixel;
    const double x = x0 + 0.5 - 0.5 * view.width, y = y0 + 0.5 - 0.5 * view.height;
    const Vec3 first = x * right + y * down + (view.orthographic ? view.eye : view.forward);
    for (int k = 0; k < 3; ++k) {
      const double steps[3] = {first[k], right[k], down[k]};
      for (int i = 0; i < 3; ++i) plane.rows[k][i] = field.rows[k][i] = steps[i];
      plane.rows[k][3] = view.orthographic ? view.forward[k] : -view.eye[k];
      field.rows[k][3] = view.orthographic ? view.forward[k] : view.eye[k];
    }
    for (int i = 0; i < 4; ++i) {
      plane.rows[3][i] = view.orthographic ? -(i == 0) : i == 3;
      field.rows[3][i] = view.orthographic ? i == 0 : i == 3;
    }
  }
};

HWY_INLINE void Multiply(const double* by, const RowMatrix& matrix, double* out) {
  constexpr hn::CappedTag<double, 4> dd;
  for (std::size_t i = 0; i < 4; i += hn::Lanes(dd)) {
    auto sum = hn::Mul(hn::Set(dd, by[0]), hn::Load(dd, matrix.rows[0] + i));
    for (int k = 1; k < 4; ++k)
      sum = hn::MulAdd(hn::Set(dd, by[k]), hn::Load(dd, matrix.rows[k] + i), sum);
    hn::Store(sum, dd, out + i);
  }
}

/// The order of a tet's faces with those of a set of bits first.
struct BitsFirst {
  std::uint8_t order[16][4], count[16];

  constexpr BitsFirst() : order(), count() {
    for (int bits = 0; bits < 16; ++bits) {
      int first = 0, last = 4;
      for (std::uint8_t k = 0; k < 4; ++k) order[bits][bits >> k & 1 ? first++ : --last] = k;
      count[bits] = static_cast<std::uint8_t>(first);
    }
  }
};

using FourDoubles = hn::CappedTag<double, 4>;
using Doubles = hn::Vec<FourDoubles>;

/// One over what planes' functions are at the eye (orthographic: along the view).
HWY_INLINE Doubles OverDivisor(Doubles divisor) {
  constexpr FourDoubles dd;
  constexpr double kMin = 1e-12;  // an eye in a face's plane
  const auto least = hn::Set(dd, kMin);
  const auto safe = hn::IfThenElse(hn::Gt(divisor, hn::Zero(dd)), hn::Max(divisor, least),
                                   hn::Min(divisor, hn::Neg(least)));
  return hn::Div(hn::Set(dd, 1), safe);
}

template <int kRows>
HWY_INLINE Doubles Times(const Doubles (&plane)[4], const RowMatrix& matrix, int column) {
  constexpr FourDoubles dd;
  auto sum = hn::Mul(plane[0], hn::Set(dd, matrix.rows[0][column]));
  for (int row = 1; row < kRows; ++row)
    sum = hn::MulAdd(plane[row], hn::Set(dd, matrix.rows[row][column]), sum);
  return sum;
}

/// A tet's planes one after the other; returns a bit for each whose second tet it is.
HWY_INLINE unsigned PlanesOf(const SplatMesh& mesh, std::int32_t tet, double (&planes)[4][4]) {
  unsigned second = 0;
  for (int k = 0; k < 4; ++k) {
    const std::int32_t face = mesh.faces[4 * static_cast<std::int64_t>(tet) + k];
    std::copy_n(mesh.planes[face >> 1].normal.data(), 4, planes[k]);  // and the offset behind it
    second |= static_cast<unsigned>(face & 1) << k;
  }
  return second;
}

/// The first `kRows` numbers of planes over what their functions are at the eye, side by side;
/// returns a bit for each that is above 0 there.
template <int kRows>
HWY_INLINE unsigned OverEye(const RowMatrix& rays, const double* planes, Doubles (&over)[4]) {
  constexpr FourDoubles dd;
  Doubles plane[4];
  hn::LoadInterleaved4(dd, planes, plane[0], plane[1], plane[2], plane[3]);
  const auto by = OverDivisor(Times<4>(plane, rays, 3));
  for (int row = 0; row < kRows; ++row) over[row] = hn::Mul(plane[row], by);
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(dd, hn::Gt(by, hn::Zero(dd)), bits);
  return bits[0];
}

/// Both tets at a face find the same bound, bit by bit: what one of them is too long the other is
/// too short. The four faces go side by side. `kKept`: the mesh has `eyeTets`.
template <bool kOrthographic, bool kKept>
HWY_INLINE void SetBounds(const TileRays& rays, const SplatMesh& mesh, std::int32_t tet,
                          TetBounds& out) {
  constexpr FourDoubles dd;
  constexpr hn::Rebind<float, FourDoubles> narrow;
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(dd));
  constexpr int kRows = kOrthographic ? 4 : 3;  // the offset counts at the eye, or all along
  static constexpr BitsFirst kBitsFirst;
  alignas(16) float at[3][4];
  if constexpr (kKept) {
    const EyeTet& eyeTet = mesh.eyeTets[tet];
    for (int k = 0; k < 4; k += kLanes) {
      Doubles over[4];
      for (int row = 0; row < 3; ++row) over[row] = hn::Load(dd, eyeTet.planes[row] + k);
      for (int column = 0; column < 3; ++column)
        hn::Store(hn::DemoteTo(narrow, Times<3>(over, rays.plane, column)), narrow, at[column] + k);
    }
    for (int k = 0; k < 4; ++k) out.bound[k] = {at[0][k], at[1][k], at[2][k]};
    out.lows = mesh.lows[tet];
  } else {
    alignas(32) double planes[4][4];
    const unsigned second = PlanesOf(mesh, tet, planes);
    unsigned before = 0;
    for (int k = 0; k < 4; k += kLanes) {
      Doubles over[4];
      before |= OverEye<kRows>(rays.plane, planes[k], over) << k;
      for (int column = 0; column < 3; ++column) {
        hn::Store(hn::DemoteTo(narrow, Times<kRows>(over, rays.plane, column)), narrow,
                  at[column] + k);
      }
    }
    const unsigned low = (before ^ second) & 15;
    const std::uint8_t* order = kBitsFirst.order[low];
    for (int k = 0; k < 4; ++k) out.bound[k] = {at[0][order[k]], at[1][order[k]], at[2][order[k]]};
    out.lows = kBitsFirst.count[low];
  }
}

/// What SetBounds() finds of a tet for all tiles of perspective pictures from an eye; returns how
/// many bounds are lower ones.
HWY_INLINE std::uint8_t SetEyeTet(const TileRays& rays, const SplatMesh& mesh, std::int32_t tet,
                                  EyeTet& out) {
  constexpr FourDoubles dd;
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(dd));
  static constexpr BitsFirst kBitsFirst;
  alignas(32) double planes[4][4], all[3][4];
  const unsigned second = PlanesOf(mesh, tet, planes);
  unsigned before = 0;
  for (int k = 0; k < 4; k += kLanes) {
    Doubles over[4];
    before |= OverEye<3>(rays.plane, planes[k], over) << k;
    for (int row = 0; row < 3; ++row) hn::Store(over[row], dd, all[row] + k);
  }
  const unsigned low = (before ^ second) & 15;
  for (int row = 0; row < 3; ++row) {
    for (int k = 0; k < 4; ++k) out.planes[row][k] = all[row][kBitsFirst.order[low][k]];
  }
  return kBitsFirst.count[low];
}

/// Asks for the planes of a tet `soon`, and for what leads to those of one `later`.
template <bool kKept>
HWY_INLINE void PrefetchPlanes(const SplatMesh& mesh, std::int32_t soon, std::int32_t later) {
  if constexpr (kKept) {
    hwy::Prefetch(mesh.eyeTets[later].planes[0]);
    hwy::Prefetch(mesh.eyeTets[later].planes[2] + 3);
    hwy::Prefetch(mesh.lows + later);
  } else {
    hwy::Prefetch(mesh.faces + 4 * static_cast<std::int64_t>(later));
    for (int k = 0; k < 4; ++k)
      hwy::Prefetch(&mesh.planes[mesh.faces[4 * static_cast<std::int64_t>(soon) + k] >> 1]);
  }
}

/// Between which inverse depths a tet's vertices are.
template <bool kOrthographic>
HWY_INLINE void SetRange(const BinnedTet& tet, TetBounds& out) {
  constexpr float kAround = 1e-6F, kNear = 1e-6F;
  if constexpr (kOrthographic) {
    const float around = kAround * std::max(std::abs(tet.nearest), std::abs(tet.farthest));
    out.lowest = -tet.farthest - around;
    out.highest = -tet.nearest + around;
  } else {
    out.lowest = (1 - kAround) / std::max(tet.farthest, kNear);
    out.highest = (1 + kAround) / std::max(tet.nearest, kEye);
  }
}

/// A field, linear in a tet, along the rays of a tile: value + (depth - z0) slope.
struct TetRamp {
  Affine value, slope;
};

template <bool kOrthographic>
HWY_INLINE TetRamp RampOf(const TileRays& rays, const LinearField& field, float z0) {
  alignas(32) double all[4];
  Multiply(field.gradient.data(), rays.field, all);
  if constexpr (kOrthographic) {
    return {{static_cast<float>(all[0] + z0 * all[3]), static_cast<float>(all[1]),
             static_cast<float>(all[2])},
            {static_cast<float>(all[3]), 0, 0}};
  } else {
    return {{static_cast<float>(all[3] + z0 * all[0]), static_cast<float>(z0 * all[1]),
             static_cast<float>(z0 * all[2])},
            {static_cast<float>(all[0]), static_cast<float>(all[1]), static_cast<float>(all[2])}};
  }
}

/// An affine function along a row of pixels.
struct Row {
  VF flat, slope;

  HWY_INLINE Row() = default;

  HWY_INLINE Row(const Affine& plane, VF dy)
      : flat(hn::MulAdd(dy, Constant(plane.y), Constant(plane.at))), slope(Constant(plane.x)) {}

  HWY_INLINE VF at(VF dx) const { return hn::MulAdd(dx, slope, flat); }
};

/// Which blocks of each row of blocks a tet may touch, from `first` to `last`.
struct RowSpans {
  alignas(64) std::int32_t first[TetTile::kBlocks];
  alignas(64) std::int32_t last[TetTile::kBlocks];
};

/// From the tet's silhouette: a pixel is inside where each upper bound is above each lower one,
/// which is a side of a line.
template <int kLows>
HWY_INLINE void SetSpans(const TetBounds& tet, const BinnedTet& blocks, RowSpans& spans) {
  constexpr int kLines = kLows * (4 - kLows);
  constexpr float kFar = 1e6F, kMin = 1e-30F, kMargin = 1e-6F, kFlat = 1e-3F;
  constexpr float kReach = kBlock - 1;
  Affine begins[kLines + 1], ends[kLines + 1];  // in blocks, `y` for a row of them
  for (int line = 0; line < kLines; ++line) {
    const Affine& low = tet.bound[line / (4 - kLows)];
    const Affine& high = tet.bound[kLows + line % (4 - kLows)];
    const float x = high.x - low.x, y = high.y - low.y;
    const float rounding = kMargin * (std::abs(high.at) + std::abs(low.at) +
                                      TetTile::kSide * (std::abs(high.x) + std::abs(low.x) +
                                                        std::abs(high.y) + std::abs(low.y)));
    const float at = high.at - low.at + std::max(0.0F, kReach * y) + rounding;
    const bool begin = x > 0;
    const float least = kFlat * rounding + kMin;
    const float by = -1 / (begin ? std::max(x, least) : std::min(x, -least));
    const float from = at * by / kBlock, step = y * by;
    begins[line] = {begin ? from - kReach / kBlock : -kFar, 0, begin ? step : 0};
    ends[line] = {begin ? kFar : from, 0, begin ? 0 : step};
  }
  for (int row = 0; row < TetTile::kBlocks; row += static_cast<int>(hn::Lanes(df))) {
    const VF y = hn::ConvertTo(df, hn::Iota(di, row));
    VF first = Constant(blocks.x0), last = Constant(blocks.x1);
    for (int line = 0; line < kLines; ++line) {
      first = hn::Max(first, hn::MulAdd(y, Constant(begins[line].y), Constant(begins[line].at)));
      last = hn::Min(last, hn::MulAdd(y, Constant(ends[line].y), Constant(ends[line].at)));
    }
    first = hn::Min(first, Constant(kFar)), last = hn::Max(last, Constant(-1));
    hn::Store(hn::ConvertTo(di, hn::Ceil(first)), di, spans.first + row);
    hn::Store(hn::ConvertTo(di, last), di, spans.last + row);
  }
}

/// A tet's bounds along a row of pixels.
template <int kLows>
struct BoundRows {
  Row rows[4];
  VF lowest, highest;

  HWY_INLINE BoundRows(const TetBounds& tet, VF dy)
      : lowest(Constant(tet.lowest)), highest(Constant(tet.highest)) {
    for (int k = 0; k < 4; ++k) rows[k] = Row(tet.bound[k], dy);
  }

  HWY_INLINE void at(VF dx, VF& low, VF& high) const {
    low = lowest, high = highest;
    for (int k = 0; k < kLows; ++k) low = hn::Max(low, rows[k].at(dx));
    for (int k = kLows; k < 4; ++k) high = hn::Min(high, rows[k].at(dx));
  }
};

/// Where the pixels of a row and of a column of blocks are in the tile.
struct BlockPixels {
  alignas(64) float columns[TetTile::kBlocks * kPixels];
  alignas(64) float rows[TetTile::kBlocks * kPixels];

  BlockPixels() {
    for (int i = 0; i < TetTile::kBlocks * kPixels; ++i) {
      columns[i] = static_cast<float>(i / kPixels * kBlock + i % kBlock);
      rows[i] = static_cast<float>(i / kPixels * kBlock + i % kPixels / kBlock);
    }
  }
};

}  // namespace
}  // namespace volute::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();
#endif
