// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/face_splat.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/tetmesh/face_raster.hpp"
#include "volute/tetmesh/tet_field.hpp"

namespace volute {
namespace {

constexpr int kSide = SplatTile::kSide;
constexpr std::size_t kChunk = 16384;  // faces that one task bins

/// A bend that cannot reach this optical depth across the whole mesh is left out; a ray crosses
/// a thousand faces or so.
constexpr double kNegligible = 1e-9;

int tilesOver(int pixels) {
  return (pixels + kSide - 1) / kSide;
}

}  // namespace

struct FaceSplat::State {
  std::shared_ptr<const TetLocator> locator;
  std::vector<float> extinction;
  std::vector<Vec3> gradient;              // of each tet
  std::vector<LiveFace> faces;             // those that bend
  std::vector<std::int32_t> boundaryTets;  // of BoundaryLine
  std::vector<float> boundaryPositive;     // +1 where rays enter with positive edges
  std::vector<ScreenVertex> vertices;

  const TetMesh& mesh() const { return locator->mesh(); }

  LiveFace liveFace(const TetFace& face) const;
  std::vector<BoundaryLine> boundaryLines(const ScreenView& view) const;
  std::vector<std::vector<std::int32_t>> bin(const ScreenView& view) const;
  void setEnds(const ScreenView& view, OpaqueDepth opaque, float farthest,
               std::span<const std::int32_t> list,
               SplatTile& tile) const;  // opaque depths beyond `farthest` do not count
  void beginAtEye(const ScreenView& view, SplatTile& tile) const;
};

LiveFace FaceSplat::State::liveFace(const TetFace& face) const {
  LiveFace live;
  std::ranges::copy(face.vertices, live.vertices);
  const Vec3& a = mesh().vertices()[face.vertices[0]];
  const Vec3 normal =
      (mesh().vertices()[face.vertices[1]] - a).cross(mesh().vertices()[face.vertices[2]] - a);
  // From the first tet to the second.
  const std::int32_t across = mesh().tets()[face.first / 4][face.first % 4];
  const double outwards = normal.dot(a - mesh().vertices()[across]) > 0 ? 1 : -1;
  const Vec3 jump = gradient[face.second / 4] - gradient[face.first / 4];
  const double longest = mesh().bounds().size().squaredNorm();
  if (0.5 * jump.norm() * longest > kNegligible)
    live.bend = static_cast<float>(0.5 * outwards * jump.dot(normal) / normal.squaredNorm());
  return live;
}

std::vector<BoundaryLine> FaceSplat::State::boundaryLines(const ScreenView& view) const {
  std::vector<BoundaryLine> lines(boundaryTets.size());
  const double perPixel = view.orthographic ? 0 : 1 / view.perPixel;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Vec3& g = gradient[boundaryTets[i]];
    lines[i] = {static_cast<float>(g.dot(view.right) * perPixel),
                static_cast<float>(g.dot(view.down) * perPixel),
                static_cast<float>(g.dot(view.forward)), boundaryPositive[i]};
  }
  return lines;
}

/// For each chunk of faces, for each tile: chunks side by side keep the order, whatever the
/// threads.
std::vector<std::vector<std::int32_t>> FaceSplat::State::bin(const ScreenView& view) const {
  const int across = tilesOver(view.width), down = tilesOver(view.height);
  const std::size_t tiles = static_cast<std::size_t>(across) * down;
  const std::size_t chunks = (faces.size() + kChunk - 1) / kChunk;
  std::vector<std::vector<std::pair<std::int32_t, std::int32_t>>> found(chunks);
  parallelFor(chunks, [&](std::size_t chunk) {
    const std::size_t end = std::min(faces.size(), (chunk + 1) * kChunk);
    for (std::size_t i = chunk * kChunk; i < end; ++i) {
      const auto& v = faces[i].vertices;
      const PixelBox box = pixelBox(view, vertices[v[0]], vertices[v[1]], vertices[v[2]]);
      if (box.empty())
        continue;
      for (int y = box.y0 / kSide; y <= box.y1 / kSide; ++y) {
        for (int x = box.x0 / kSide; x <= box.x1 / kSide; ++x)
          found[chunk].emplace_back(y * across + x, static_cast<std::int32_t>(i));
      }
    }
  });
  std::vector<std::vector<std::int32_t>> bins(tiles);
  for (const auto& chunk : found) {
    for (const auto& [tile, face] : chunk) bins[tile].push_back(face);
  }
  return bins;
}

void FaceSplat::State::setEnds(const ScreenView& view, OpaqueDepth opaque, float farthest,
                               std::span<const std::int32_t> list, SplatTile& tile) const {
  // Without a surface any depth will do, since all that came in has gone out behind the mesh; the
  // sums are least, and so is their rounding, where the field bends most.
  double sum = 0, weight = 1e-30;
  for (const std::int32_t i : list) {
    const double bend = std::abs(static_cast<double>(faces[i].bend));
    sum += bend * vertices[faces[i].vertices[0]].z;
    weight += bend;
  }
  std::ranges::fill(tile.end, static_cast<float>(sum / weight));
  std::ranges::fill(tile.limit, std::numeric_limits<float>::max());
  tile.bounded = !opaque.empty();
  if (!tile.bounded)
    return;
  for (int y = tile.y0; y < std::min(tile.y0 + kSide, view.height); ++y) {
    for (int x = tile.x0; x < std::min(tile.x0 + kSide, view.width); ++x) {
      const double depth = opaque[static_cast<std::size_t>(y) * view.width + x];
      const auto z = static_cast<float>(depth / view.rayScale(x, y));
      const int at = SplatTile::index(x - tile.x0, y - tile.y0);
      if (z < farthest)
        tile.end[at] = tile.limit[at] = z;
    }
  }
}

void FaceSplat::State::beginAtEye(const ScreenView& view, SplatTile& tile) const {
  std::ranges::fill(tile.sum, 0.0F);
  std::ranges::fill(tile.doubt, 0.0F);
  if (view.eyeTet < 0)
    return;
  const auto shares = mesh().shares(view.eyeTet, view.eye);
  double tau = 0;
  for (int k = 0; k < 4; ++k) tau += shares[k] * extinction[mesh().tets()[view.eyeTet][k]];
  const Vec3& g = gradient[view.eyeTet];
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double px = view.pixelX(x + tile.x0), py = view.pixelY(y + tile.y0);
      const double slope = g.dot(view.forward + (px * view.right + py * view.down) / view.perPixel);
      const int at = SplatTile::index(x, y);
      const double end = tile.end[at];
      tile.sum[at] = static_cast<float>(end * (tau + 0.5 * slope * end));
    }
  }
}

FaceSplat::FaceSplat(std::shared_ptr<const TetLocator> locator)
    : state_(std::make_unique<State>()) {
  state_->locator = std::move(locator);
  const TetMesh& mesh = state_->mesh();
  for (const std::int32_t f : mesh.boundary()) {
    const TetFace& face = mesh.faces()[f];
    const Vec3& a = mesh.vertices()[face.vertices[0]];
    const Vec3 normal =
        (mesh.vertices()[face.vertices[1]] - a).cross(mesh.vertices()[face.vertices[2]] - a);
    const std::int32_t across = mesh.tets()[face.first / 4][face.first % 4];
    // Rays that see positive edges' functions run along the normal.
    state_->boundaryPositive.push_back(normal.dot(mesh.vertices()[across] - a) > 0 ? 1.0F : -1.0F);
    state_->boundaryTets.push_back(face.first / 4);
  }
  setExtinction(std::vector<float>(mesh.vertices().size(), 0));
}

FaceSplat::~FaceSplat() = default;
FaceSplat::FaceSplat(FaceSplat&&) noexcept = default;
FaceSplat& FaceSplat::operator=(FaceSplat&&) noexcept = default;

void FaceSplat::setExtinction(std::span<const float> extinction) {
  State& state = *state_;
  const TetMesh& mesh = state.mesh();
  VOLUTE_ASSERT(extinction.size() == mesh.vertices().size());
  state.extinction.assign(extinction.begin(), extinction.end());
  state.gradient = gradients(mesh, extinction);
  const std::size_t chunks = (mesh.faces().size() + kChunk - 1) / kChunk;
  std::vector<std::vector<LiveFace>> live(chunks);
  parallelFor(chunks, [&](std::size_t chunk) {
    const std::size_t end = std::min(mesh.faces().size(), (chunk + 1) * kChunk);
    for (std::size_t f = chunk * kChunk; f < end; ++f) {
      if (mesh.faces()[f].second == TetMesh::kBoundary)
        continue;
      const LiveFace face = state.liveFace(mesh.faces()[f]);
      if (face.bend != 0)
        live[chunk].push_back(face);
    }
  });
  state.faces.clear();
  for (const auto& chunk : live) state.faces.insert(state.faces.end(), chunk.begin(), chunk.end());
  for (std::size_t i = 0; i < mesh.boundary().size(); ++i) {
    const TetFace& face = mesh.faces()[mesh.boundary()[i]];
    const Tet& tet = mesh.tets()[face.first / 4];
    if (std::ranges::all_of(tet, [&](std::int32_t v) { return extinction[v] == 0; }))
      continue;
    LiveFace& entry = state.faces.emplace_back();
    std::ranges::copy(face.vertices, entry.vertices);
    entry.boundary = static_cast<std::int32_t>(i);
  }
}

void FaceSplat::opticalDepth(const Camera& camera, OpaqueDepth opaque, std::span<float> depth) {
  State& state = *state_;
  const ScreenView view(camera, *state.locator);
  state.vertices.resize(state.mesh().vertices().size());
  parallelRanges(state.vertices.size(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      state.vertices[i] = view.project(state.mesh().vertices()[i]);
      state.vertices[i].tau = state.extinction[i];
    }
  });
  const auto lines = state.boundaryLines(view);
  const auto bins = state.bin(view);
  const TetMedium twin(state.locator, state.extinction);
  float farthest = 0;
  for (const ScreenVertex& v : state.vertices) farthest = std::max(farthest, v.z);
  const int across = tilesOver(view.width);
  parallelFor(bins.size(), [&](std::size_t i) {
    SplatTile tile;
    tile.x0 = static_cast<int>(i) % across * kSide;
    tile.y0 = static_cast<int>(i) / across * kSide;
    state.setEnds(view, opaque, farthest, bins[i], tile);
    state.beginAtEye(view, tile);
    splatFaces(view, state.vertices.data(), state.faces, lines, bins[i], tile);
    for (int y = tile.y0; y < std::min(tile.y0 + kSide, view.height); ++y) {
      for (int x = tile.x0; x < std::min(tile.x0 + kSide, view.width); ++x) {
        const int at = SplatTile::index(x - tile.x0, y - tile.y0);
        float& out = depth[static_cast<std::size_t>(y) * view.width + x];
        out = std::max(0.0F, tile.sum[at] * static_cast<float>(view.rayScale(x, y)));
        if (tile.doubt[at] > 0) {
          const Segment ray = pixelRay(camera, x, y, opaque);
          double exact = 0;
          twin.opticalDepth({&ray, 1}, {&exact, 1});
          out = static_cast<float>(exact);
        }
      }
    }
  });
}

}  // namespace volute
