// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_splat.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/tetmesh/tet_raster.hpp"

namespace volute {
namespace {

constexpr int kSide = TetTile::kSide;
constexpr std::size_t kChunk = 16384;  // tets that one task bins

/// Smoke that cannot reach this optical depth across the whole mesh is left out.
constexpr float kNegligible = 1e-8F;

int tilesOver(int pixels) {
  return (pixels + kSide - 1) / kSide;
}

BinnedTet inTile(std::int32_t tet, const PixelBox& box, int x, int y) {
  const auto block = [](int pixel, int tile) {
    return static_cast<std::uint8_t>(std::clamp(pixel - tile * kSide, 0, kSide - 1) /
                                     TetTile::kBlock);
  };
  return {tet, block(box.x0, x), block(box.y0, y), block(box.x1, x), block(box.y1, y)};
}

/// A chunk's tets, tile by tile.
struct ChunkBins {
  std::vector<BinnedTet> tets;
  std::vector<std::int32_t> begin;  // of each tile, and the end

  std::span<const BinnedTet> of(std::size_t tile) const {
    return {tets.data() + begin[tile], tets.data() + begin[tile + 1]};
  }
};

PixelBox unite(const PixelBox& a, const PixelBox& b) {
  if (a.empty() || b.empty())
    return a.empty() ? b : a;
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

}  // namespace

struct TetSplat::State {
  std::shared_ptr<const TetLocator> locator;
  std::vector<float> extinction;
  std::vector<FacePlane> planes;                       // of each face
  std::vector<std::array<std::int32_t, 4>> faces;      // SplatMesh::faces
  std::vector<std::array<Eigen::Vector3f, 3>> slopes;  // TetMesh::slopes but the first
  std::vector<Eigen::Vector3f> gradient;               // of each tet
  std::vector<char> dark;                              // tets without smoke
  std::vector<ScreenVertex> vertices;
  std::vector<PixelPlace> places;
  std::vector<float> depth;  // of each vertex along the view

  const TetMesh& mesh() const { return locator->mesh(); }

  void prepare();
  void project(const ScreenView& view);
  PixelBox boxOf(const ScreenView& view, const Tet& tet) const;
  ChunkBins binChunk(const ScreenView& view, std::size_t chunk) const;
  SplatMesh splatMesh() const;
};

void TetSplat::State::prepare() {
  const std::size_t tets = mesh().tets().size();
  slopes.resize(tets);
  gradient.assign(tets, Eigen::Vector3f::Zero());
  dark.assign(tets, 1);
  faces.resize(tets);
  parallelRanges(tets, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto exact = mesh().slopes(static_cast<std::int32_t>(t));
      for (int k = 0; k < 3; ++k) slopes[t][k] = exact[k + 1].cast<float>();
    }
  });
  planes.resize(mesh().faces().size());
  parallelRanges(planes.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const TetFace& face = mesh().faces()[f];
      const Vec3 v[3] = {mesh().vertices()[face.vertices[0]], mesh().vertices()[face.vertices[1]],
                         mesh().vertices()[face.vertices[2]]};
      Vec3 normal = (v[1] - v[0]).cross(v[2] - v[0]).normalized();
      const std::int32_t apex = mesh().tets()[face.first / 4][face.first % 4];
      if (normal.dot(v[0] - mesh().vertices()[apex]) < 0)
        normal = -normal;
      planes[f] = {normal, normal.dot(v[0])};
      faces[face.first / 4][face.first % 4] = static_cast<std::int32_t>(2 * f);
      if (face.second != TetMesh::kBoundary)
        faces[face.second / 4][face.second % 4] = static_cast<std::int32_t>(2 * f + 1);
    }
  });
}

void TetSplat::State::project(const ScreenView& view) {
  vertices.resize(mesh().vertices().size());
  places.resize(vertices.size());
  depth.resize(vertices.size());
  parallelRanges(vertices.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      vertices[i] = view.project(mesh().vertices()[i]);
      places[i] = pixelPlace(vertices[i]);
      depth[i] = vertices[i].z;
    }
  });
}

PixelBox TetSplat::State::boxOf(const ScreenView& view, const Tet& tet) const {
  const PixelPlace* place[4];
  bool ahead = true;
  for (int k = 0; k < 4; ++k) {
    place[k] = &places[tet[k]];
    ahead &= place[k]->ahead;
  }
  PixelBox box;
  if (ahead) {
    // As of two corners: what the four of them span.
    const auto [x0, x1] = std::minmax({place[0]->x, place[1]->x, place[2]->x, place[3]->x});
    const auto [y0, y1] = std::minmax({place[0]->y, place[1]->y, place[2]->y, place[3]->y});
    const PixelPlace low{x0, y0, true}, high{x1, y1, true};
    return pixelBox(view, low, high, high);
  }
  for (int k = 0; k < 4; ++k) {
    box = unite(box, pixelBox(view, vertices[tet[(k + 1) % 4]], vertices[tet[(k + 2) % 4]],
                              vertices[tet[(k + 3) % 4]]));
  }
  return box;
}

ChunkBins TetSplat::State::binChunk(const ScreenView& view, std::size_t chunk) const {
  const int across = tilesOver(view.width), down = tilesOver(view.height);
  const std::size_t end = std::min(faces.size(), (chunk + 1) * kChunk);
  std::vector<std::pair<std::int32_t, BinnedTet>> found;
  found.reserve(2 * kChunk);
  ChunkBins bins;
  bins.begin.assign(static_cast<std::size_t>(across) * down + 1, 0);
  for (std::size_t t = chunk * kChunk; t < end; ++t) {
    if (dark[t])
      continue;
    const PixelBox box = boxOf(view, mesh().tets()[t]);
    if (box.empty())
      continue;
    for (int y = box.y0 / kSide; y <= box.y1 / kSide; ++y) {
      for (int x = box.x0 / kSide; x <= box.x1 / kSide; ++x) {
        const int tile = y * across + x;
        ++bins.begin[static_cast<std::size_t>(tile) + 1];
        found.emplace_back(tile, inTile(static_cast<std::int32_t>(t), box, x, y));
      }
    }
  }
  for (std::size_t i = 1; i < bins.begin.size(); ++i) bins.begin[i] += bins.begin[i - 1];
  bins.tets.resize(found.size());
  std::vector<std::int32_t> next(bins.begin.begin(), bins.begin.end() - 1);
  for (const auto& [tile, tet] : found) bins.tets[next[tile]++] = tet;
  return bins;
}

SplatMesh TetSplat::State::splatMesh() const {
  SplatMesh splat;
  splat.vertices = mesh().vertices().data();
  splat.tets = mesh().tets().data()->data();
  splat.faces = faces.data()->data();
  splat.planes = planes.data();
  splat.extinction = extinction.data();
  splat.gradient = gradient.data()->data();
  splat.depth = depth.data();
  return splat;
}

TetSplat::TetSplat(std::shared_ptr<const TetLocator> locator) : state_(std::make_unique<State>()) {
  state_->locator = std::move(locator);
  state_->extinction.assign(state_->mesh().vertices().size(), 0);
  state_->prepare();
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
  parallelRanges(mesh.tets().size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Tet& tet = mesh.tets()[t];
      const float tau[4] = {extinction[tet[0]], extinction[tet[1]], extinction[tet[2]],
                            extinction[tet[3]]};
      state.dark[t] = std::max(std::max(tau[0], tau[1]), std::max(tau[2], tau[3])) <= negligible;
      const auto& slope = state.slopes[t];
      state.gradient[t] = (tau[1] - tau[0]) * slope[0] + (tau[2] - tau[0]) * slope[1] +
                          (tau[3] - tau[0]) * slope[2];
    }
  });
}

void TetSplat::opticalDepth(const Camera& camera, OpaqueDepth opaque, std::span<float> depth) {
  State& state = *state_;
  const ScreenView view(camera, *state.locator);
  state.project(view);
  std::vector<ChunkBins> bins((state.faces.size() + kChunk - 1) / kChunk);
  parallelFor(bins.size(), [&](std::size_t chunk) { bins[chunk] = state.binChunk(view, chunk); });
  const SplatMesh mesh = state.splatMesh();
  const int across = tilesOver(view.width);
  const auto tiles = static_cast<std::size_t>(across) * tilesOver(view.height);
  parallelFor(tiles, [&](std::size_t i) {
    TetTile tile;
    tile.x0 = static_cast<int>(i) % across * kSide;
    tile.y0 = static_cast<int>(i) / across * kSide;
    const int width = std::min(kSide, view.width - tile.x0);
    const int height = std::min(kSide, view.height - tile.y0);
    std::ranges::fill(tile.sum, 0.0F);
    tile.bounded = !opaque.empty();
    const auto forEachPixel = [&](auto&& f) {
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          f(TetTile::index(x, y), static_cast<std::size_t>(y + tile.y0) * view.width + x + tile.x0,
            view.rayScale(x + tile.x0, y + tile.y0));
        }
      }
    };
    if (tile.bounded) {
      std::ranges::fill(tile.end, 0.0F);
      forEachPixel([&](int at, std::size_t pixel, double scale) {
        const double z = std::min(opaque[pixel] / scale, 1e30);
        tile.end[at] = static_cast<float>(view.orthographic ? -z : 1 / std::max(z, 1e-30));
      });
    }
    for (const ChunkBins& chunk : bins) splatTets(view, mesh, chunk.of(i), tile);
    forEachPixel([&](int at, std::size_t pixel, double scale) {
      depth[pixel] = std::max(0.0F, tile.sum[at] * static_cast<float>(scale));
    });
  });
}

}  // namespace volute
