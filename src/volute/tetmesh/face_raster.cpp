// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/face_raster.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/tetmesh/face_raster.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, 16>;
using VF = hn::Vec<DF>;
using Mask = hn::Mask<DF>;
constexpr DF df;
constexpr int kBlock = 4;

HWY_INLINE VF Constant(float x) {
  return hn::Set(df, x);
}

/// Both products are rounded before they are subtracted, so that exchanging the ends changes
/// nothing but the sign: both faces at an edge agree on which side a ray passes.
HWY_INLINE VF Edge(VF px, VF py, VF qx, VF qy) {
  return hn::Sub(hn::Mul(px, qy), hn::Mul(py, qx));
}

void SplatFaces(const ScreenView& view, const ScreenVertex* vertices, const PixelPlace* places,
                std::span<const LiveFace> faces, std::span<const BoundaryLine> lines,
                std::span<const std::int32_t> list, SplatTile& tile) {
  constexpr int kPixels = kBlock * kBlock;
  alignas(64) float offsetX[kPixels], offsetY[kPixels];
  for (int i = 0; i < kPixels; ++i)
    offsetX[i] = static_cast<float>(i % kBlock), offsetY[i] = static_cast<float>(i / kBlock);
  const auto perPixels = static_cast<float>(1 / (view.perPixel * view.perPixel));
  const auto left = static_cast<float>(view.pixelX(tile.x0)),
             top = static_cast<float>(view.pixelY(tile.y0));
  const VF zero = hn::Zero(df);
  for (const std::int32_t id : list) {
    const LiveFace& face = faces[id];
    const ScreenVertex& a = vertices[face.vertices[0]];
    const ScreenVertex& b = vertices[face.vertices[1]];
    const ScreenVertex& c = vertices[face.vertices[2]];
    const PixelPlace& pa = places[face.vertices[0]];
    const PixelPlace& pb = places[face.vertices[1]];
    const PixelPlace& pc = places[face.vertices[2]];
    const PixelBox box =
        pa.ahead && pb.ahead && pc.ahead ? pixelBox(view, pa, pb, pc) : pixelBox(view, a, b, c);
    const int bx0 = (std::max(box.x0, tile.x0) - tile.x0) / kBlock;
    const int by0 = (std::max(box.y0, tile.y0) - tile.y0) / kBlock;
    const int bx1 = (std::min(box.x1, tile.x0 + SplatTile::kSide - 1) - tile.x0) / kBlock;
    const int by1 = (std::min(box.y1, tile.y0 + SplatTile::kSide - 1) - tile.y0) / kBlock;
    const VF ax = Constant(a.x), ay = Constant(a.y), aw = Constant(a.w), az = Constant(a.z);
    const VF bx = Constant(b.x), by = Constant(b.y), bw = Constant(b.w), bz = Constant(b.z);
    const VF cx = Constant(c.x), cy = Constant(c.y), cw = Constant(c.w), cz = Constant(c.z);
    const VF nearest = Constant(std::min(a.z, std::min(b.z, c.z)));
    const VF farthest = Constant(std::max(a.z, std::max(b.z, c.z)));
    const VF bend = Constant(face.bend * perPixels);
    for (int y = by0; y <= by1; ++y) {
      for (int x = bx0; x <= bx1; ++x) {
        const int at = (y * (SplatTile::kSide / kBlock) + x) * kPixels;
        for (int part = 0; part < kPixels; part += static_cast<int>(hn::Lanes(df))) {
          const VF px = hn::Add(Constant(left + static_cast<float>(x * kBlock)),
                                hn::Load(df, offsetX + part));
          const VF py =
              hn::Add(Constant(top + static_cast<float>(y * kBlock)), hn::Load(df, offsetY + part));
          const VF rax = hn::NegMulAdd(px, aw, ax), ray = hn::NegMulAdd(py, aw, ay);
          const VF rbx = hn::NegMulAdd(px, bw, bx), rby = hn::NegMulAdd(py, bw, by);
          const VF rcx = hn::NegMulAdd(px, cw, cx), rcy = hn::NegMulAdd(py, cw, cy);
          const VF ea = Edge(rbx, rby, rcx, rcy), eb = Edge(rcx, rcy, rax, ray),
                   ec = Edge(rax, ray, rbx, rby);
          const VF least = hn::Min(ea, hn::Min(eb, ec)), most = hn::Max(ea, hn::Max(eb, ec));
          // Both signs: the ray passes by. A least or most of 0: it meets an edge.
          const Mask touched = hn::Or(hn::Ge(least, zero), hn::Le(most, zero));
          if (hn::AllFalse(df, touched))
            continue;
          const Mask inside = hn::Or(hn::Gt(least, zero), hn::Lt(most, zero));
          const VF total = hn::Add(ea, hn::Add(eb, ec));
          const VF per = hn::Div(Constant(1), total);
          const VF za = hn::MulAdd(ea, az, hn::MulAdd(eb, bz, hn::Mul(ec, cz)));
          const VF t = hn::Min(farthest, hn::Max(nearest, hn::Mul(za, per)));
          const VF end = hn::Load(df, tile.end + at + part);
          Mask counted = inside;
          if (!view.orthographic)
            counted = hn::And(counted, hn::Gt(t, zero));
          if (tile.bounded)
            counted = hn::And(counted, hn::Lt(t, hn::Load(df, tile.limit + at + part)));
          const VF q = hn::Sub(end, t);
          VF added;
          if (face.boundary < 0) {
            added = hn::Mul(hn::Mul(bend, hn::Abs(total)), hn::Mul(q, q));
          } else {
            const BoundaryLine& line = lines[face.boundary];
            const VF slope =
                hn::MulAdd(px, Constant(line.slopeX),
                           hn::MulAdd(py, Constant(line.slopeY), Constant(line.slope)));
            const VF tau =
                hn::Mul(hn::MulAdd(ea, Constant(a.tau),
                                   hn::MulAdd(eb, Constant(b.tau), hn::Mul(ec, Constant(c.tau)))),
                        per);
            const VF sign = hn::CopySign(Constant(1), hn::Mul(total, Constant(line.sign)));
            added = hn::Mul(sign, hn::Mul(q, hn::MulAdd(hn::Mul(Constant(0.5F), slope), q, tau)));
          }
          float* sum = tile.sum + at + part;
          hn::Store(hn::Add(hn::Load(df, sum), hn::IfThenElseZero(counted, added)), df, sum);
          const Mask onEdge = hn::AndNot(inside, touched);
          if (HWY_UNLIKELY(!hn::AllFalse(df, onEdge))) {
            float* doubt = tile.doubt + at + part;
            hn::Store(hn::IfThenElse(onEdge, Constant(1), hn::Load(df, doubt)), df, doubt);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace volute::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {
namespace {

HWY_EXPORT(SplatFaces);

}  // namespace

void splatFaces(const ScreenView& view, const ScreenVertex* vertices, const PixelPlace* places,
                std::span<const LiveFace> faces, std::span<const BoundaryLine> lines,
                std::span<const std::int32_t> list, SplatTile& tile) {
  HWY_DYNAMIC_DISPATCH(SplatFaces)(view, vertices, places, faces, lines, list, tile);
}

}  // namespace volute
#endif  // HWY_ONCE
