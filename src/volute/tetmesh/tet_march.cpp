// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_march.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/tetmesh/tet_march.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "volute/tetmesh/segment_weights-inl.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {
namespace {

constexpr float kLightLost = 14;  // optical depth of a lit ray beyond which it ends: 1e-6

void MarchWeights(const float* d0, const float* d1, float* w0, float* w1) {
  for (std::size_t i = 0; i < kWidest; i += hn::Lanes(df)) {
    VF a, b;
    Weights(hn::LoadU(df, d0 + i), hn::LoadU(df, d1 + i), a, b);
    hn::StoreU(a, df, w0 + i);
    hn::StoreU(b, df, w1 + i);
  }
}

/// The cross product of two ends. Both products are rounded before they are subtracted, so that
/// exchanging the ends changes nothing but the sign.
HWY_INLINE VF Edge(VF px, VF py, VF qx, VF qy) {
  return hn::Sub(hn::Mul(px, qy), hn::Mul(py, qx));
}

/// A vertex's x or y as a ray sees it: x - px w. `rest` and `restW` are what x and w leave.
template <class D>
HWY_INLINE hn::Vec<D> Seen(D, hn::Vec<D> pixel, hn::Vec<D> x, hn::Vec<D> w, hn::Vec<D> rest,
                           hn::Vec<D> restW) {
  return hn::Add(hn::NegMulAdd(pixel, w, x), hn::NegMulAdd(pixel, restW, rest));
}

/// A corner of the face that a ray stands on.
struct Corner {
  VF x, y, z, tau, r, g, b;
  VI place;  ///< which vertex of the tet that lies ahead
};

HWY_INLINE VF Choose(Mask mask, VF yes, VF no) {
  return hn::IfThenElse(mask, yes, no);
}

HWY_INLINE VI Choose(Mask mask, VI yes, VI no) {
  return hn::IfThenElse(hn::RebindMask(di, mask), yes, no);
}

template <bool kLit>
HWY_INLINE void Replace(Corner& corner, const Corner& by, Mask mask) {
  corner.x = Choose(mask, by.x, corner.x);
  corner.y = Choose(mask, by.y, corner.y);
  corner.z = Choose(mask, by.z, corner.z);
  corner.tau = Choose(mask, by.tau, corner.tau);
  if constexpr (kLit) {
    corner.r = Choose(mask, by.r, corner.r);
    corner.g = Choose(mask, by.g, corner.g);
    corner.b = Choose(mask, by.b, corner.b);
  }
  corner.place = Choose(mask, by.place, corner.place);
}

/// Four floats of a record for each lane, one vector a float: by blocks of 16 bytes and transposed,
/// which takes a quarter of a gather's loads. `at`: where each lane's record begins.
HWY_INLINE void LoadFour(const float* records, const std::int32_t* at, VF (&out)[4]) {
#if HWY_TARGET == HWY_SCALAR
  for (int k = 0; k < 4; ++k) out[k] = hn::GatherIndex(df, records + k, hn::LoadU(di, at));
#else
  constexpr std::size_t kLanes = hn::MaxLanes(df);
  const VI block = hn::ShiftRight<2>(hn::Iota(di, 0));
  VF rows[4];  // row j has lanes j, j + 4, j + 8 ..
  for (std::size_t j = 0; j < 4; ++j) {
    rows[j] = hn::LoadDup128(df, records + at[j]);
    for (std::size_t b = 1; b < kLanes / 4; ++b) {
      const Mask here =
          hn::RebindMask(df, hn::Eq(block, hn::Set(di, static_cast<std::int32_t>(b))));
      rows[j] = hn::IfThenElse(here, hn::LoadDup128(df, records + at[4 * b + j]), rows[j]);
    }
  }
  const VF low02 = hn::InterleaveLower(df, rows[0], rows[2]),
           high02 = hn::InterleaveUpper(df, rows[0], rows[2]),
           low13 = hn::InterleaveLower(df, rows[1], rows[3]),
           high13 = hn::InterleaveUpper(df, rows[1], rows[3]);
  out[0] = hn::InterleaveLower(df, low02, low13);
  out[1] = hn::InterleaveUpper(df, low02, low13);
  out[2] = hn::InterleaveLower(df, high02, high13);
  out[3] = hn::InterleaveUpper(df, high02, high13);
#endif
}

/// What lanes keep while others are loaded.
struct alignas(64) Lanes {
  float corner[3][7][kWidest];
  std::int32_t place[3][kWidest];
  float weight[3][kWidest];
  float px[kWidest], py[kWidest], scale[kWidest], zEnd[kWidest];
  float z[kWidest], tau[kWidest], rgb[3][kWidest];         // where the ray stands
  float sum[kWidest], passed[kWidest], light[3][kWidest];  // depth; transmittance; emitted
  std::int32_t half[kWidest], steps[kWidest];
  std::int32_t state[kWidest];  // kRunning ...
};

enum State : std::int32_t { kRunning, kLeft, kEnded, kDoubtful, kIdle };

constexpr std::int32_t kMaxSteps = 1 << 20;

struct FaceAtRay {
  float x[3], y[3], e[3];
};

/// The vertices of half-face `half` as the ray sees them, in ascending order.
HWY_INLINE FaceAtRay Look(const MarchMesh& mesh, std::int32_t half, const MarchRay& ray,
                          std::int32_t (&places)[3]) {
  FaceAtRay face;
  const int across = half & 3;
  for (int i = 0; i < 3; ++i) {
    places[i] = i + (i >= across);
    const std::int32_t vertex = mesh.tets[(half & ~3) + places[i]];
    const ScreenVertex& v = mesh.vertices[vertex];
    const ScreenRest& rest = mesh.rests[vertex];
    // By vectors: the same rounding as in the march, whatever the compiler makes of scalars.
    const hn::CappedTag<float, 1> one;
    face.x[i] = hn::GetLane(Seen(one, hn::Set(one, ray.px), hn::Set(one, v.x), hn::Set(one, v.w),
                                 hn::Set(one, rest.x), hn::Set(one, rest.w)));
    face.y[i] = hn::GetLane(Seen(one, hn::Set(one, ray.py), hn::Set(one, v.y), hn::Set(one, v.w),
                                 hn::Set(one, rest.y), hn::Set(one, rest.w)));
  }
  for (int i = 0; i < 3; ++i) {
    const int p = (i + 1) % 3, q = (i + 2) % 3;
    const float a = face.x[p] * face.y[q], b = face.y[p] * face.x[q];
    face.e[i] = a - b;
  }
  return face;
}

/// Puts an entry into a lane. False when the ray does not pierce the face beyond doubt.
bool Enter(const MarchMesh& mesh, const MarchRay& ray, std::int32_t half, std::size_t lane,
           Lanes& lanes) {
  std::int32_t places[3];
  const FaceAtRay face = Look(mesh, half, ray, places);
  const bool positive = face.e[0] > 0 && face.e[1] > 0 && face.e[2] > 0;
  const bool negative = face.e[0] < 0 && face.e[1] < 0 && face.e[2] < 0;
  if (!positive && !negative)
    return false;
  const int order[3] = {0, positive ? 1 : 2, positive ? 2 : 1};
  const float sign = positive ? 1.0F : -1.0F;
  float total = 0, value[5] = {};
  for (int i = 0; i < 3; ++i) {
    const int k = order[i];
    const ScreenVertex& v = mesh.vertices[mesh.tets[(half & ~3) + places[k]]];
    const float values[5] = {v.z, v.tau, v.r, v.g, v.b};
    lanes.corner[i][0][lane] = face.x[k];
    lanes.corner[i][1][lane] = face.y[k];
    lanes.weight[i][lane] = sign * face.e[k];
    lanes.place[i][lane] = places[k];
    total += lanes.weight[i][lane];
    for (int c = 0; c < 5; ++c) {
      lanes.corner[i][2 + c][lane] = values[c];
      value[c] += lanes.weight[i][lane] * values[c];
    }
  }
  lanes.half[lane] = half;
  const float first = lanes.corner[0][2][lane];
  lanes.z[lane] = first + (lanes.weight[1][lane] * (lanes.corner[1][2][lane] - first) +
                           lanes.weight[2][lane] * (lanes.corner[2][2][lane] - first)) /
                              total;
  lanes.tau[lane] = value[1] / total;
  for (int c = 0; c < 3; ++c) lanes.rgb[c][lane] = value[2 + c] / total;
  return true;
}

/// The face of the eye's tet that lies behind the eye.
bool EnterFromEye(const MarchMesh& mesh, const MarchRay& ray, std::int32_t tet, std::size_t lane,
                  Lanes& lanes) {
  for (std::int32_t k = 0; k < 4; ++k) {
    if (!Enter(mesh, ray, 4 * tet + k, lane, lanes) || lanes.z[lane] > 0)
      continue;
    lanes.z[lane] = 0;
    lanes.tau[lane] = mesh.eyeTau;
    for (int c = 0; c < 3; ++c) lanes.rgb[c][lane] = mesh.eyeRgb[c];
    return true;
  }
  return false;
}

/// Rays side by side, one to a lane; a lane whose ray is done takes the next.
template <bool kLit>
class Pack {
 public:
  Pack(const MarchMesh& mesh, std::span<const MarchRay> rays, std::span<const MarchEntry> entries,
       std::span<MarchResult> results)
      : mesh_(mesh), rays_(rays), entries_(entries), results_(results) {}

  std::uint64_t run() {
    const std::size_t width = hn::Lanes(df);
    for (std::size_t lane = 0; lane < width; ++lane) take(lane);
    while (running_ > 0) {
      step();
      for (std::size_t lane = 0; lane < width; ++lane) {
        if (lanes_.state[lane] == kRunning || lanes_.state[lane] == kIdle)
          continue;
        steps_ += static_cast<std::uint64_t>(lanes_.steps[lane]);
        if (lanes_.state[lane] == kLeft && again(lane))
          continue;
        finish(lane);
        --running_;
        take(lane);
      }
    }
    return steps_;
  }

 private:
  /// The next ray into a lane, or none.
  void take(std::size_t lane) {
    for (;; ++next_) {
      if (next_ == rays_.size()) {
        lanes_.state[lane] = kIdle;
        lanes_.zEnd[lane] = 0;
        return;
      }
      const MarchRay& ray = rays_[next_];
      if (ray.entryBegin == ray.entryEnd || results_[next_].doubtful)
        continue;
      rayOf_[lane] = next_;
      entryOf_[lane] = ray.entryBegin;
      lanes_.px[lane] = ray.px;
      lanes_.py[lane] = ray.py;
      lanes_.scale[lane] = ray.scale;
      lanes_.zEnd[lane] = ray.zEnd;
      lanes_.sum[lane] = 0;
      lanes_.passed[lane] = 1;
      for (int c = 0; c < 3; ++c) lanes_.light[c][lane] = 0;
      if (again(lane))
        break;
      finish(lane);
    }
    ++next_;
    ++running_;
  }

  /// Lets the lane's ray in by its next entry; false when there is none.
  bool again(std::size_t lane) {
    const MarchRay& ray = rays_[rayOf_[lane]];
    lanes_.steps[lane] = 0;
    if (entryOf_[lane] == ray.entryEnd || (kLit && lanes_.sum[lane] > kLightLost)) {
      lanes_.state[lane] = kEnded;
      return false;
    }
    const MarchEntry& entry = entries_[entryOf_[lane]++];
    const bool atEye = mesh_.eyeInside && entry.z == 0;
    const bool in = atEye ? EnterFromEye(mesh_, ray, entry.halfFace / 4, lane, lanes_)
                          : Enter(mesh_, ray, entry.halfFace, lane, lanes_);
    if (in && lanes_.z[lane] >= ray.zEnd) {
      lanes_.state[lane] = kEnded;
      return false;
    }
    lanes_.state[lane] = in ? kRunning : kDoubtful;
    return in;
  }

  void finish(std::size_t lane) {
    MarchResult& result = results_[rayOf_[lane]];
    result.depth = lanes_.sum[lane];
    for (int c = 0; c < 3; ++c) result.rgb[c] = lanes_.light[c][lane];
    result.doubtful = lanes_.state[lane] == kDoubtful;
  }

  HWY_INLINE Corner load(int i) const {
    Corner corner;
    corner.x = hn::Load(df, lanes_.corner[i][0]);
    corner.y = hn::Load(df, lanes_.corner[i][1]);
    corner.z = hn::Load(df, lanes_.corner[i][2]);
    corner.tau = hn::Load(df, lanes_.corner[i][3]);
    if constexpr (kLit) {
      corner.r = hn::Load(df, lanes_.corner[i][4]);
      corner.g = hn::Load(df, lanes_.corner[i][5]);
      corner.b = hn::Load(df, lanes_.corner[i][6]);
    }
    corner.place = hn::Load(di, lanes_.place[i]);
    return corner;
  }

  HWY_INLINE void store(int i, const Corner& corner) {
    hn::Store(corner.x, df, lanes_.corner[i][0]);
    hn::Store(corner.y, df, lanes_.corner[i][1]);
    hn::Store(corner.z, df, lanes_.corner[i][2]);
    hn::Store(corner.tau, df, lanes_.corner[i][3]);
    if constexpr (kLit) {
      hn::Store(corner.r, df, lanes_.corner[i][4]);
      hn::Store(corner.g, df, lanes_.corner[i][5]);
      hn::Store(corner.b, df, lanes_.corner[i][6]);
    }
    hn::Store(corner.place, di, lanes_.place[i]);
  }

  /// All running lanes from face to face, until some of them are done.
  void step() {
    Corner a = load(0), b = load(1), c = load(2);
    VF wa = hn::Load(df, lanes_.weight[0]), wb = hn::Load(df, lanes_.weight[1]),
       wc = hn::Load(df, lanes_.weight[2]);
    VF z = hn::Load(df, lanes_.z), tau = hn::Load(df, lanes_.tau);
    VF rgb[3] = {hn::Load(df, lanes_.rgb[0]), hn::Load(df, lanes_.rgb[1]),
                 hn::Load(df, lanes_.rgb[2])};
    VF sum = hn::Load(df, lanes_.sum), passed = hn::Load(df, lanes_.passed);
    VF light[3] = {hn::Load(df, lanes_.light[0]), hn::Load(df, lanes_.light[1]),
                   hn::Load(df, lanes_.light[2])};
    VI half = hn::Load(di, lanes_.half), steps = hn::Load(di, lanes_.steps),
       state = hn::Load(di, lanes_.state);
    const VF px = hn::Load(df, lanes_.px), py = hn::Load(df, lanes_.py);
    const VF scale = hn::Load(df, lanes_.scale), zEnd = hn::Load(df, lanes_.zEnd);
    const auto* vertices = reinterpret_cast<const float*>(mesh_.vertices);
    const auto* rests = reinterpret_cast<const float*>(mesh_.rests);
    // Lanes that are done wait until a quarter of them are: refilling has its price.
    const std::size_t enough = std::min(running_, std::max<std::size_t>(1, running_ / 4));
    const std::size_t least = running_ - enough;
    Mask active = hn::RebindMask(df, hn::Eq(state, hn::Set(di, kRunning)));
    do {
      const VI at = hn::ShiftLeft<3>(
          hn::GatherIndex(di, mesh_.tets, hn::IfThenElseZero(hn::RebindMask(di, active), half)));
      alignas(64) std::int32_t records[kWidest];
      hn::Store(at, di, records);
      VF place[4], rest[4], glow[4];
      LoadFour(vertices, records, place);
      alignas(64) std::int32_t restRecords[kWidest];
      hn::Store(hn::ShiftRight<1>(at), di, restRecords);
      LoadFour(rests, restRecords, rest);
      if (kLit || mesh_.orthographic)
        LoadFour(vertices + 4, records, glow);
      Corner d;
      d.x = Seen(df, px, place[0], place[2], rest[0], rest[2]);
      d.y = Seen(df, py, place[1], place[2], rest[1], rest[2]);
      d.z = mesh_.orthographic ? glow[0] : place[2];
      d.tau = place[3];
      if constexpr (kLit)
        d.r = glow[1], d.g = glow[2], d.b = glow[3];
      d.place = hn::And(half, hn::Set(di, 3));
      const VF da = Edge(d.x, d.y, a.x, a.y), db = Edge(d.x, d.y, b.x, b.y),
               dc = Edge(d.x, d.y, c.x, c.y);
      const VF zero = hn::Zero(df);
      const Mask leftA = hn::Gt(da, zero), leftB = hn::Gt(db, zero), leftC = hn::Gt(dc, zero);
      const Mask dropC = hn::AndNot(leftB, leftA), dropA = hn::AndNot(leftC, leftB),
                 dropB = hn::AndNot(leftA, leftC);
      const VI dropped = Choose(dropA, a.place, Choose(dropB, b.place, c.place));
      // The face kept its third edge; the new corner brings the other two.
      const VF newA = Choose(dropC, hn::Neg(db), Choose(dropB, dc, wa));
      const VF newB = Choose(dropA, hn::Neg(dc), Choose(dropC, da, wb));
      const VF newC = Choose(dropB, hn::Neg(da), Choose(dropA, db, wc));
      Replace<kLit>(a, d, dropA);
      Replace<kLit>(b, d, dropB);
      Replace<kLit>(c, d, dropC);
      wa = newA, wb = newB, wc = newC;
      const Mask way =
          hn::And(hn::Or(dropA, hn::Or(dropB, dropC)), hn::Gt(hn::Min(wa, hn::Min(wb, wc)), zero));
      const VF per = hn::Div(Constant(1), hn::Add(wa, hn::Add(wb, wc)));
      const auto here = [&](VF va, VF vb, VF vc) {
        return hn::Mul(hn::MulAdd(wa, va, hn::MulAdd(wb, vb, hn::Mul(wc, vc))), per);
      };
      // From one corner on: far from the eye the depths themselves are coarse.
      const VF rise = hn::MulAdd(wb, hn::Sub(b.z, a.z), hn::Mul(wc, hn::Sub(c.z, a.z)));
      VF z1 = hn::Max(hn::MulAdd(rise, per, a.z), z);
      VF tau1 = here(a.tau, b.tau, c.tau);
      const Mask past = hn::Ge(z1, zEnd);
      const VF share = Choose(past, hn::Div(hn::Sub(zEnd, z), hn::Sub(z1, z)), Constant(1));
      tau1 = Choose(past, hn::MulAdd(share, hn::Sub(tau1, tau), tau), tau1);
      z1 = hn::Min(z1, zEnd);
      const VF length = hn::Mul(hn::Sub(z1, z), scale);
      const Mask goes = hn::And(active, way);
      if constexpr (kLit) {
        VF w0, w1;
        // Not a number in a lane that waits would call for the finest rule.
        const VF d0 = hn::IfThenElseZero(goes, hn::Mul(tau, length)),
                 d1 = hn::IfThenElseZero(goes, hn::Mul(tau1, length));
        const VF lost = Weights(d0, d1, w0, w1);
        const VF corners[3][3] = {{a.r, b.r, c.r}, {a.g, b.g, c.g}, {a.b, b.b, c.b}};
        for (int i = 0; i < 3; ++i) {
          const VF end = here(corners[i][0], corners[i][1], corners[i][2]);
          const VF cut = Choose(past, hn::MulAdd(share, hn::Sub(end, rgb[i]), rgb[i]), end);
          const VF sent = hn::MulAdd(w0, rgb[i], hn::Mul(w1, cut));
          light[i] = Choose(goes, hn::MulAdd(passed, sent, light[i]), light[i]);
          rgb[i] = cut;
        }
        passed = Choose(goes, hn::NegMulAdd(passed, lost, passed), passed);
      }
      const VF part = hn::Mul(hn::Mul(Constant(0.5F), length), hn::Add(tau, tau1));
      sum = hn::Add(sum, hn::IfThenElseZero(goes, part));
      z = z1, tau = tau1;
      // On to the neighbour: both tets name their vertices in ascending order, so that what the
      // face keeps keeps its order.
      const VI out = hn::IfThenElseZero(hn::RebindMask(di, goes),
                                        hn::Add(hn::AndNot(hn::Set(di, 3), half), dropped));
      const VI next = hn::GatherIndex(di, mesh_.opposite, out);
      const VI across = hn::And(next, hn::Set(di, 3));
      const auto renamed = [&](VI place) {
        const VI rank = hn::Add(place, hn::VecFromMask(di, hn::Gt(place, dropped)));
        return hn::Sub(rank, hn::VecFromMask(di, hn::Not(hn::Lt(rank, across))));
      };
      a.place = renamed(a.place);
      b.place = renamed(b.place);
      c.place = renamed(c.place);
      half = hn::IfThenElse(hn::RebindMask(di, active), next, half);
      steps = hn::Sub(steps, hn::VecFromMask(di, hn::RebindMask(di, active)));
      Mask ended = past;
      if constexpr (kLit)
        ended = hn::Or(ended, hn::Gt(sum, Constant(kLightLost)));
      const Mask lost =
          hn::Or(hn::Not(way), hn::RebindMask(df, hn::Gt(steps, hn::Set(di, kMaxSteps))));
      const VI now = Choose(
          lost, hn::Set(di, kDoubtful),
          Choose(ended, hn::Set(di, kEnded),
                 hn::IfThenElse(hn::Lt(next, hn::Zero(di)), hn::Set(di, kLeft), hn::Zero(di))));
      state = Choose(active, now, state);
      active = hn::RebindMask(df, hn::Eq(state, hn::Set(di, kRunning)));
    } while (hn::CountTrue(df, active) > least);
    store(0, a), store(1, b), store(2, c);
    hn::Store(wa, df, lanes_.weight[0]), hn::Store(wb, df, lanes_.weight[1]);
    hn::Store(wc, df, lanes_.weight[2]);
    hn::Store(z, df, lanes_.z), hn::Store(tau, df, lanes_.tau), hn::Store(sum, df, lanes_.sum);
    hn::Store(passed, df, lanes_.passed);
    for (int i = 0; i < 3; ++i) {
      hn::Store(rgb[i], df, lanes_.rgb[i]);
      hn::Store(light[i], df, lanes_.light[i]);
    }
    hn::Store(half, di, lanes_.half), hn::Store(steps, di, lanes_.steps);
    hn::Store(state, di, lanes_.state);
  }

  const MarchMesh& mesh_;
  std::span<const MarchRay> rays_;
  std::span<const MarchEntry> entries_;
  std::span<MarchResult> results_;
  Lanes lanes_{};
  std::size_t rayOf_[kWidest] = {};
  std::int32_t entryOf_[kWidest] = {};
  std::size_t next_ = 0, running_ = 0;
  std::uint64_t steps_ = 0;
};

std::uint64_t MarchRays(const MarchMesh& mesh, std::span<const MarchRay> rays,
                        std::span<const MarchEntry> entries, std::span<MarchResult> results) {
  return mesh.lit ? Pack<true>(mesh, rays, entries, results).run()
                  : Pack<false>(mesh, rays, entries, results).run();
}

void RasterEntries(const ScreenView& view, const ScreenVertex* vertices, const ScreenRest* rests,
                   const EntryFace& face, const PixelBox& tile, std::vector<MarchEntry>& entries,
                   std::span<char> doubtful) {
  const PixelBox box{std::max(face.box.x0, tile.x0), std::max(face.box.y0, tile.y0),
                     std::min(face.box.x1, tile.x1), std::min(face.box.y1, tile.y1)};
  const int width = tile.x1 - tile.x0 + 1;
  const VF sign = Constant(face.positive ? 1.0F : -1.0F);
  const VF zero = hn::Zero(df);
  const ScreenVertex* v[3];
  const ScreenRest* rest[3];
  for (int i = 0; i < 3; ++i) {
    v[i] = &vertices[face.vertices[i]];
    rest[i] = &rests[face.vertices[i]];
  }
  alignas(64) float depths[kWidest];
  alignas(64) float kinds[kWidest];
  for (int y = box.y0; y <= box.y1; ++y) {
    const VF py = Constant(static_cast<float>(view.pixelY(y)));
    for (int x = box.x0; x <= box.x1; x += static_cast<int>(hn::Lanes(df))) {
      const VF px =
          hn::Add(Constant(static_cast<float>(view.pixelX(x))), hn::ConvertTo(df, hn::Iota(di, 0)));
      VF rx[3], ry[3], e[3];
      for (int i = 0; i < 3; ++i) {
        const VF w = Constant(v[i]->w), restW = Constant(rest[i]->w);
        rx[i] = Seen(df, px, Constant(v[i]->x), w, Constant(rest[i]->x), restW);
        ry[i] = Seen(df, py, Constant(v[i]->y), w, Constant(rest[i]->y), restW);
      }
      for (int i = 0; i < 3; ++i) {
        const int p = (i + 1) % 3, q = (i + 2) % 3;
        e[i] = hn::Mul(sign, Edge(rx[p], ry[p], rx[q], ry[q]));
      }
      const VF least = hn::Min(e[0], hn::Min(e[1], e[2]));
      if (hn::AllTrue(df, hn::Lt(least, zero)))
        continue;
      VF z = hn::Zero(df), total = hn::Zero(df);
      for (int i = 0; i < 3; ++i) {
        z = hn::MulAdd(e[i], Constant(v[i]->z), z);
        total = hn::Add(total, e[i]);
      }
      hn::Store(hn::Div(z, total), df, depths);
      hn::Store(least, df, kinds);
      const int count = std::min(static_cast<int>(hn::Lanes(df)), box.x1 - x + 1);
      for (int i = 0; i < count; ++i) {
        const int pixel = (y - tile.y0) * width + x + i - tile.x0;
        if (kinds[i] == 0)
          doubtful[static_cast<std::size_t>(pixel)] = 1;
        else if (kinds[i] > 0 && (view.orthographic || depths[i] > 0))
          entries.push_back({pixel, face.halfFace, depths[i]});
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

HWY_EXPORT(MarchRays);
HWY_EXPORT(MarchWeights);
HWY_EXPORT(RasterEntries);

}  // namespace

void rasterEntries(const ScreenView& view, const ScreenVertex* vertices, const ScreenRest* rests,
                   const EntryFace& face, const PixelBox& tile, std::vector<MarchEntry>& entries,
                   std::span<char> doubtful) {
  HWY_DYNAMIC_DISPATCH(RasterEntries)(view, vertices, rests, face, tile, entries, doubtful);
}

std::uint64_t marchRays(const MarchMesh& mesh, std::span<const MarchRay> rays,
                        std::span<const MarchEntry> entries, std::span<MarchResult> results) {
  return HWY_DYNAMIC_DISPATCH(MarchRays)(mesh, rays, entries, results);
}

void marchWeights(std::span<const float> d0, std::span<const float> d1, std::span<float> w0,
                  std::span<float> w1) {
  for (std::size_t i = 0; i < d0.size(); i += 16) {
    float in[2][16] = {}, out[2][16];
    const std::size_t count = std::min<std::size_t>(16, d0.size() - i);
    std::copy_n(&d0[i], count, in[0]);
    std::copy_n(&d1[i], count, in[1]);
    HWY_DYNAMIC_DISPATCH(MarchWeights)(in[0], in[1], out[0], out[1]);
    std::copy_n(out[0], count, &w0[i]);
    std::copy_n(out[1], count, &w1[i]);
  }
}

}  // namespace volute
#endif  // HWY_ONCE
