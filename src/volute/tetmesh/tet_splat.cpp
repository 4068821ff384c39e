// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_splat.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <optional>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/medium/integrate.hpp"
#include "volute/tetmesh/tet_bins.hpp"
#include "volute/tetmesh/tet_lit_raster.hpp"
#include "volute/tetmesh/tet_raster.hpp"
#include "volute/tetmesh/tet_reference.hpp"
#include "volute/tetmesh/visibility_order.hpp"

namespace volute {
namespace {

constexpr std::size_t kSplatGrain = 4096;

/// Smoke that cannot reach this optical depth across the whole mesh is left out.
constexpr float kNegligible = 1e-8F;

/// [m]; what is opaque beyond is not seen.
constexpr float kFarAway = 1e30F;

/// Calls use(place in the tile, x, y) for the pixels of the tile's blocks that are asked for.
template <class Tile, class Use>
void forEachPixel(const ScreenView& view, const Tile& tile, const Use& use) {
  for (int y = tile.y0; y < std::min(tile.y0 + Tile::kSide, view.height); ++y) {
    for (int x = tile.x0; x < std::min(tile.x0 + Tile::kSide, view.width); ++x) {
      const int column = x - tile.x0, row = y - tile.y0;
      if (tile.asked.has(column / TetTile::kBlock, row / TetTile::kBlock))
        use(Tile::index(column, row), x, y);
      else
        x += TetTile::kBlock - 1;  // the rest of the block
    }
  }
}

/// What of a tile is asked for, and whether a ray of it ends at something opaque. Parallel rays
/// have smoke before a depth of 0.
template <class Tile>
void setAsked(const ScreenView& view, OpaqueDepth opaque, Tile& tile) {
  constexpr int kBlock = TetTile::kBlock;
  tile.bounded = false;
  tile.asked.rows.fill(opaque.empty() || view.orthographic ? AskedBlocks::kWhole : 0);
  if (opaque.empty())
    return;
  const int columns = std::min(Tile::kSide, view.width - tile.x0);
  for (int y = tile.y0; y < std::min(tile.y0 + Tile::kSide, view.height); ++y) {
    const float* row = &opaque[static_cast<std::size_t>(y) * view.width + tile.x0];
    std::uint32_t bits = 0;  // in long runs of what is not asked for nothing is
    for (int x = 0; x < columns; ++x) bits |= std::bit_cast<std::uint32_t>(row[x]);
    tile.bounded |= std::any_of(row, row + columns, [](float end) { return end < kFarAway; });
    if (bits == 0)
      continue;
    unsigned blocks = 0;
    for (int x = 0; x < columns; ++x) blocks |= (row[x] > 0 ? 1U : 0U) << (x / kBlock);
    tile.asked.rows[static_cast<std::size_t>((y - tile.y0) / kBlock)] |=
        static_cast<std::uint16_t>(blocks);
  }
}

/// Calls add(tets) for those of a tile that may meet what is asked for.
template <class Tile, class Add>
void forTets(const TetBins& bins, std::size_t place, const Tile& tile, const Add& add) {
  if (tile.asked.all())
    return bins.forEach(place, add);
  std::vector<BinnedTet> met;
  bins.forEach(place, [&](std::span<const BinnedTet> tets) {
    std::ranges::copy_if(tets, std::back_inserter(met),
                         [&](const BinnedTet& tet) { return tile.asked.meet(tet); });
  });
  add(met);
}

/// The inverse depth (orthographic: minus the depth) where a pixel's ray ends.
float inverseEnd(const ScreenView& view, OpaqueDepth opaque, double rayScale, int x, int y) {
  const float end = opaque[static_cast<std::size_t>(y) * view.width + x];
  const double z = std::min(end / rayScale, double{kFarAway});
  return static_cast<float>(view.orthographic ? -z : 1 / std::max(z, 1e-30));
}

/// Whether two views see every vertex in the same place.
bool areAlike(const ScreenView& a, const ScreenView& b) {
  return a.eye == b.eye && a.right == b.right && a.down == b.down && a.forward == b.forward &&
         a.perPixel == b.perPixel && a.orthographic == b.orthographic && a.width == b.width &&
         a.height == b.height;
}

/// The tets in each tile serve as long as nothing moves and the same tets have smoke.
class KeptBins {
 public:
  /// `order` belongs to the eye.
  const TetBins& of(const TetMesh& mesh, const ScreenView& view, int side,
                    std::span<const char> dark, std::span<const std::int32_t> order = {}) {
    if (kept_ && areAlike(kept_->view, view) && std::ranges::equal(kept_->dark, dark))
      return kept_->bins;
    kept_.reset();  // before the next ones take their memory
    kept_.emplace(view, std::vector<char>(dark.begin(), dark.end()),
                  TetBins(mesh, view, side, dark, order));
    return kept_->bins;
  }

 private:
  struct Kept {
    Kept(const ScreenView& view, std::vector<char> dark, TetBins bins)
        : view(view), dark(std::move(dark)), bins(std::move(bins)) {}

    ScreenView view;
    std::vector<char> dark;
    TetBins bins;
  };

  std::optional<Kept> kept_;
};

}  // namespace

struct TetSplat::State {
  explicit State(std::shared_ptr<const TetLocator> mesh)
      : locator(std::move(mesh)), faces(locator->mesh()) {}

  std::shared_ptr<const TetLocator> locator;
  FacePlanes faces;
  std::vector<std::array<VecN<float, 3>, 3>> slopes;  // TetMesh::slopes but the first
  std::vector<float> extinction, source;
  std::vector<LinearField> smoke;  // the extinction in each tet
  std::vector<TetSource> sources;  // of each tet, when there is a source
  std::vector<char> dark;          // tets without smoke
  ViewOrigin sortedFor;
  std::vector<std::int32_t> order;  // of the tets, front to back
  std::size_t leftOut = 0;
  std::optional<Vec3> lastEye;  // of the picture before; nothing: orthographic, or none
  std::vector<EyeTet> eyeTets;  // of it; empty: not found yet
  std::vector<std::uint8_t> lows;
  KeptBins depthBins, litBins;

  const TetMesh& mesh() const { return locator->mesh(); }

  void lookFrom(const ScreenView& view);

  void sortFor(const ScreenView& view);
  void lightLeftOut(const Camera& camera, OpaqueDepth opaque, std::span<const std::size_t> pixels,
                    std::span<float> rgbt);

  SplatMesh splatMesh() const {
    return {faces.sides.data()->data(), faces.planes.data(), smoke.data(),
            eyeTets.empty() ? nullptr : eyeTets.data(), lows.data()};
  }
};

TetSplat::TetSplat(std::shared_ptr<const TetLocator> locator)
    : state_(std::make_unique<State>(std::move(locator))) {
  State& state = *state_;
  const std::size_t tets = state.mesh().tets().size();
  state.extinction.assign(state.mesh().vertices().size(), 0);
  state.slopes.resize(tets);
  state.smoke.assign(tets, {Vec3::Zero(), 0});
  state.dark.assign(tets, 1);
  parallelRanges(tets, kSplatGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto exact = state.mesh().slopes(static_cast<std::int32_t>(t));
      for (int k = 0; k < 3; ++k) state.slopes[t][k] = exact[k + 1].cast<float>();
    }
  });
}

TetSplat::~TetSplat() = default;
TetSplat::TetSplat(TetSplat&&) noexcept = default;
TetSplat& TetSplat::operator=(TetSplat&&) noexcept = default;

void TetSplat::setExtinction(std::span<const float> extinction) {
  State& state = *state_;
  const TetMesh& mesh = state.mesh();
  VOLUTE_ASSERT(extinction.size() == mesh.vertices().size());
  state.extinction.assign(extinction.begin(), extinction.end());
  const auto negligible = static_cast<float>(kNegligible / mesh.bounds().size().norm());
  parallelRanges(mesh.tets().size(), kSplatGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Tet& tet = mesh.tets()[t];
      const float tau[4] = {extinction[tet[0]], extinction[tet[1]], extinction[tet[2]],
                            extinction[tet[3]]};
      state.dark[t] = std::max(std::max(tau[0], tau[1]), std::max(tau[2], tau[3])) <= negligible;
      const auto& slope = state.slopes[t];
      const VecN<float, 3> gradient = (tau[1] - tau[0]) * slope[0] + (tau[2] - tau[0]) * slope[1] +
                                      (tau[3] - tau[0]) * slope[2];
      LinearField& smoke = state.smoke[t];
      smoke.gradient = gradient.cast<double>();
      smoke.offset = tau[0] - smoke.gradient.dot(mesh.vertices()[tet[0]]);
    }
  });
}

void TetSplat::setSource(std::span<const float> source) {
  State& state = *state_;
  const TetMesh& mesh = state.mesh();
  VOLUTE_ASSERT(source.empty() || source.size() == 3 * mesh.vertices().size());
  state.source.assign(source.begin(), source.end());
  state.sources.assign(mesh.tets().size(), {});
  if (source.empty())
    return;
  parallelRanges(mesh.tets().size(), kSplatGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Tet& tet = mesh.tets()[t];
      TetSource& out = state.sources[t];
      for (int c = 0; c < 3; ++c) {
        const auto at = [&](int k) { return source[3 * static_cast<std::size_t>(tet[k]) + c]; };
        VecN<float, 3> gradient = VecN<float, 3>::Zero();
        for (int k = 0; k < 3; ++k) gradient += (at(k + 1) - at(0)) * state.slopes[t][k];
        std::copy_n(gradient.data(), 3, out.gradient[c]);
        out.value[c] = at(0);
      }
    }
  });
}

/// An eye that stays is worth it: one that moves pays nothing for what it would not use again.
void TetSplat::State::lookFrom(const ScreenView& view) {
  if (view.orthographic || lastEye != view.eye) {
    lastEye = view.orthographic ? std::nullopt : std::optional(view.eye);
    eyeTets.clear();
    return;
  }
  if (!eyeTets.empty())
    return;
  const SplatMesh all = splatMesh();
  eyeTets.resize(mesh().tets().size());
  lows.resize(eyeTets.size());
  parallelRanges(eyeTets.size(), kSplatGrain, [&](std::size_t begin, std::size_t end) {
    findEyeTets(view, all, begin, std::span(eyeTets).subspan(begin, end - begin),
                std::span(lows).subspan(begin, end - begin));
  });
}

void TetSplat::opticalDepth(const Camera& camera, OpaqueDepth opaque, std::span<float> depth) {
  State& state = *state_;
  const ScreenView view(camera, *state.locator);
  state.lookFrom(view);
  const TetBins& bins = state.depthBins.of(state.mesh(), view, TetTile::kSide, state.dark);
  const SplatMesh mesh = state.splatMesh();
  parallelFor(static_cast<std::size_t>(bins.across()) * bins.down(), [&](std::size_t i) {
    TetTile tile;
    tile.x0 = static_cast<int>(i) % bins.across() * TetTile::kSide;
    tile.y0 = static_cast<int>(i) / bins.across() * TetTile::kSide;
    setAsked(view, opaque, tile);
    if (tile.asked.none())
      return;
    std::ranges::fill(tile.sum, 0.0F);
    if (tile.bounded) {
      std::ranges::fill(tile.end, 0.0F);
      forEachPixel(view, tile, [&](int at, int x, int y) {
        tile.end[at] = inverseEnd(view, opaque, view.rayScale(x, y), x, y);
      });
    }
    forTets(bins, i, tile,
            [&](std::span<const BinnedTet> tets) { splatTets(view, mesh, tets, tile); });
    readTile(view, tile, depth.data());
  });
}

void TetSplat::State::sortFor(const ScreenView& view) {
  // What does not matter does not count: an eye may turn.
  const ViewOrigin origin{view.orthographic ? Vec3(Vec3::Zero()) : view.eye,
                          view.orthographic ? view.forward : Vec3(Vec3::UnitX()),
                          view.orthographic};
  if (!order.empty() && origin == sortedFor)
    return;
  order = visibilityOrder(mesh(), faces, origin);
  sortedFor = origin;
}

void TetSplat::State::lightLeftOut(const Camera& camera, OpaqueDepth opaque,
                                   std::span<const std::size_t> pixels, std::span<float> rgbt) {
  constexpr std::size_t kTogether = 16;
  leftOut = pixels.size();
  if (pixels.empty())
    return;
  const TetMedium smoke(locator, extinction, source);
  const auto width = static_cast<std::size_t>(camera.width());
  parallelRanges(pixels.size(), kTogether, [&](std::size_t begin, std::size_t end) {
    std::vector<Segment> rays;
    for (std::size_t i = begin; i < end; ++i)
      rays.push_back(pixelRay(camera, static_cast<int>(pixels[i] % width),
                              static_cast<int>(pixels[i] / width), opaque));
    std::vector<Radiance> light(rays.size());
    radianceByPieces(smoke, rays, light);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      float* out = &rgbt[4 * pixels[begin + i]];
      for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(light[i].emitted[c]);
      out[3] = static_cast<float>(light[i].transmittance);
    }
  });
}

void TetSplat::litColor(const Camera& camera, OpaqueDepth opaque, std::span<float> rgbt) {
  State& state = *state_;
  if (state.sources.empty())
    setSource({});
  const ScreenView view(camera, *state.locator);
  state.lookFrom(view);
  state.sortFor(view);
  const TetBins& bins =
      state.litBins.of(state.mesh(), view, LitTile::kSide, state.dark, state.order);
  const LitMesh mesh{state.splatMesh(), state.sources.data(), state.mesh().vertices().data(),
                     state.mesh().tets().data()};
  const auto size = static_cast<float>(state.mesh().bounds().size().norm());
  const std::size_t tiles = static_cast<std::size_t>(bins.across()) * bins.down();
  std::vector<std::vector<std::size_t>> wrong(tiles);  // pixels of each
  parallelFor(tiles, [&](std::size_t i) {
    LitTile tile;
    tile.x0 = static_cast<int>(i) % bins.across() * LitTile::kSide;
    tile.y0 = static_cast<int>(i) / bins.across() * LitTile::kSide;
    setAsked(view, opaque, tile);
    if (tile.asked.none())
      return;
    for (int y = 0; y < LitTile::kBlocks; ++y) {
      for (int x = 0; x < LitTile::kBlocks; ++x) {
        if (tile.asked.has(x, y))
          tile.clear(x, y);
      }
    }
    forEachPixel(view, tile, [&](int at, int x, int y) {
      const double scale = view.rayScale(x, y);
      *tile.at(LitTile::kScale, at) = static_cast<float>(scale);
      if (tile.bounded)
        *tile.at(LitTile::kEnd, at) = inverseEnd(view, opaque, scale, x, y);
    });
    forTets(bins, i, tile,
            [&](std::span<const BinnedTet> tets) { lightTets(view, mesh, tets, size, tile); });
    forEachPixel(view, tile, [&](int at, int x, int y) {
      const std::size_t pixel = static_cast<std::size_t>(y) * view.width + x;
      for (int c = 0; c < 3; ++c) rgbt[4 * pixel + c] = *tile.at(LitTile::kLight + c, at);
      rgbt[4 * pixel + 3] = *tile.at(LitTile::kPassed, at);
      if (*tile.at(LitTile::kWrong, at) != 0)
        wrong[i].push_back(pixel);
    });
  });
  std::vector<std::size_t> pixels;
  for (const auto& some : wrong) pixels.insert(pixels.end(), some.begin(), some.end());
  state.lightLeftOut(camera, opaque, pixels, rgbt);
}

std::size_t TetSplat::leftOut() const {
  return state_->leftOut;
}

}  // namespace volute
