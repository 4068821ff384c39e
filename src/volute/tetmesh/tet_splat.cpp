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

BinnedTet inTile(BinnedTet tet, const PixelBox& box, int x, int y) {
  const auto block = [](int pixel, int tile) {
    return static_cast<std::uint8_t>(std::clamp(pixel - tile * kSide, 0, kSide - 1) /
                                     TetTile::kBlock);
  };
  tet.x0 = block(box.x0, x), tet.y0 = block(box.y0, y);
  tet.x1 = block(box.x1, x), tet.y1 = block(box.y1, y);
  return tet;
}

/// A chunk's tets, tile by tile.
struct ChunkBins {
  std::vector<BinnedTet> tets;
  std::vector<std::int32_t> begin;  // of each tile, and the end

  std::span<const BinnedTet> of(std::size_t tile) const {
    return {tets.data() + begin[tile], tets.data() + begin[tile + 1]};
  }
};

/// Where the tile's rays end.
void bound(const ScreenView& view, OpaqueDepth opaque, TetTile& tile) {
  tile.bounded = true;
  std::ranges::fill(tile.end, 0.0F);
  for (int y = tile.y0; y < std::min(tile.y0 + kSide, view.height); ++y) {
    for (int x = tile.x0; x < std::min(tile.x0 + kSide, view.width); ++x) {
      const float end = opaque[static_cast<std::size_t>(y) * view.width + x];
      const double z = std::min(end / view.rayScale(x, y), 1e30);
      tile.end[TetTile::index(x - tile.x0, y - tile.y0)] =
          static_cast<float>(view.orthographic ? -z : 1 / std::max(z, 1e-30));
    }
  }
}

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
  std::vector<TetSmoke> smoke;                         // of each tet
  std::vector<char> dark;                              // tets without smoke
  std::vector<SplatVertex> vertices;

  const TetMesh& mesh() const { return locator->mesh(); }

  void prepare();
  void project(const ScreenView& view);
  PixelBox boxAtEye(const ScreenView& view, const Tet& tet) const;
  ChunkBins binChunk(const ScreenView& view, std::size_t chunk) const;
  SplatMesh splatMesh() const;
};

void TetSplat::State::prepare() {
  const std::size_t tets = mesh().tets().size();
  slopes.resize(tets);
  smoke.assign(tets, {Vec3::Zero(), 0});
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
  parallelRanges(vertices.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const ScreenVertex vertex = view.project(mesh().vertices()[i]);
      const PixelPlace place = pixelPlace(vertex);
      vertices[i] = {
          place.x, place.y, -place.x, -place.y, vertex.z, -vertex.z, place.ahead ? 0.0F : 1.0F, 0};
    }
  });
}

/// Of a tet that is partly behind the eye.
PixelBox TetSplat::State::boxAtEye(const ScreenView& view, const Tet& tet) const {
  ScreenVertex corners[4];
  for (int k = 0; k < 4; ++k) corners[k] = view.project(mesh().vertices()[tet[k]]);
  PixelBox box;
  for (int k = 0; k < 4; ++k) {
    box = unite(box,
                pixelBox(view, corners[(k + 1) % 4], corners[(k + 2) % 4], corners[(k + 3) % 4]));
  }
  return box;
}

ChunkBins TetSplat::State::binChunk(const ScreenView& view, std::size_t chunk) const {
  constexpr std::size_t kBatch = 512;
  const int across = tilesOver(view.width), down = tilesOver(view.height);
  const std::size_t end = std::min(faces.size(), (chunk + 1) * kChunk);
  std::vector<std::pair<std::int32_t, BinnedTet>> found;
  found.reserve(2 * kChunk);
  ChunkBins bins;
  bins.begin.assign(static_cast<std::size_t>(across) * down + 1, 0);
  std::vector<TetSpan> spans(kBatch);
  for (std::size_t t = chunk * kChunk; t < end; ++t) {
    const std::size_t at = t % kBatch;
    if (at == 0) {
      spanTets(view, vertices.data(), mesh().tets().subspan(t, std::min(kBatch, end - t)),
               spans.data());
    }
    if (dark[t])
      continue;
    const TetSpan& span = spans[at];
    const PixelBox box = span.behind > 0 ? boxAtEye(view, mesh().tets()[t])
                                         : PixelBox{-span.minusX0, -span.minusY0, span.x1, span.y1};
    if (box.empty())
      continue;
    const BinnedTet tet{
        static_cast<std::int32_t>(t), 0, 0, 0, 0, -span.minusNearest, span.farthest};
    for (int y = box.y0 / kSide; y <= box.y1 / kSide; ++y) {
      for (int x = box.x0 / kSide; x <= box.x1 / kSide; ++x) {
        const int tile = y * across + x;
        ++bins.begin[static_cast<std::size_t>(tile) + 1];
        found.emplace_back(tile, inTile(tet, box, x, y));
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
  splat.faces = faces.data()->data();
  splat.planes = planes.data();
  splat.smoke = smoke.data();
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
      const Eigen::Vector3f gradient = (tau[1] - tau[0]) * slope[0] + (tau[2] - tau[0]) * slope[1] +
                                       (tau[3] - tau[0]) * slope[2];
      TetSmoke& smoke = state.smoke[t];
      smoke.gradient = gradient.cast<double>();
      smoke.offset = tau[0] - smoke.gradient.dot(mesh.vertices()[tet[0]]);
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
    std::ranges::fill(tile.sum, 0.0F);
    if (!opaque.empty())
      bound(view, opaque, tile);
    for (const ChunkBins& chunk : bins) splatTets(view, mesh, chunk.of(i), tile);
    readTile(view, tile, depth.data());
  });
}

}  // namespace volute
