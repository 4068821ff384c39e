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
  float negligible = 0;  // jumps of the gradient whose square is less count as none
  std::vector<std::array<Eigen::Vector3f, 3>> slopes;  // TetMesh::slopes but the first
  std::vector<Eigen::Vector3f> gradient;               // of each tet
  std::vector<LiveFace> faces;                         // all, in the mesh's order
  std::vector<Eigen::Vector3f> across;                 // half of each face's normal over its size
  std::vector<std::int32_t> boundaryTets;              // of BoundaryLine
  std::vector<float> boundaryPositive;                 // +1 where rays enter with positive edges
  std::vector<ScreenVertex> vertices;
  std::vector<PixelPlace> places;

  const TetMesh& mesh() const { return locator->mesh(); }

  void prepare();
  float bendOf(std::size_t face) const;
  std::vector<BoundaryLine> boundaryLines(const ScreenView& view) const;
  std::vector<std::vector<std::int32_t>> bin(const ScreenView& view) const;
  void setEnds(const ScreenView& view, OpaqueDepth opaque, float farthest,
               std::span<const std::int32_t> list,
               SplatTile& tile) const;  // opaque depths beyond `farthest` do not count
  void beginAtEye(const ScreenView& view, SplatTile& tile) const;
};

void FaceSplat::State::prepare() {
  slopes.resize(mesh().tets().size());
  parallelRanges(slopes.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto exact = mesh().slopes(static_cast<std::int32_t>(t));
      for (int k = 0; k < 3; ++k) slopes[t][k] = exact[k + 1].cast<float>();
    }
  });
  gradient.resize(slopes.size());
  faces.resize(mesh().faces().size());
  across.resize(faces.size());
  parallelRanges(faces.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const TetFace& face = mesh().faces()[f];
      std::ranges::copy(face.vertices, faces[f].vertices);
      const Vec3& a = mesh().vertices()[face.vertices[0]];
      const Vec3 normal =
          (mesh().vertices()[face.vertices[1]] - a).cross(mesh().vertices()[face.vertices[2]] - a);
      // From the first tet to the second.
      const std::int32_t apex = mesh().tets()[face.first / 4][face.first % 4];
      const double outwards = normal.dot(a - mesh().vertices()[apex]) > 0 ? 1 : -1;
      across[f] = (0.5 * outwards / normal.squaredNorm() * normal).cast<float>();
    }
  });
  for (std::size_t i = 0; i < mesh().boundary().size(); ++i) {
    const std::int32_t f = mesh().boundary()[i];
    faces[f].boundary = static_cast<std::int32_t>(i);
    boundaryTets.push_back(mesh().faces()[f].first / 4);
    // Rays that see positive edges' functions run along the cross product of the edges.
    const Vec3& a = mesh().vertices()[faces[f].vertices[0]];
    const Vec3 normal = (mesh().vertices()[faces[f].vertices[1]] - a)
                            .cross(mesh().vertices()[faces[f].vertices[2]] - a);
    boundaryPositive.push_back(normal.dot(across[f].cast<double>()) < 0 ? 1.0F : -1.0F);
  }
}

float FaceSplat::State::bendOf(std::size_t f) const {
  const TetFace& face = mesh().faces()[f];
  if (face.second == TetMesh::kBoundary) {
    const Tet& tet = mesh().tets()[face.first / 4];
    return std::ranges::any_of(tet, [&](std::int32_t v) { return extinction[v] > 0; });
  }
  const Eigen::Vector3f jump = gradient[face.second / 4] - gradient[face.first / 4];
  return jump.squaredNorm() > negligible ? jump.dot(across[f]) : 0.0F;
}

std::vector<BoundaryLine> FaceSplat::State::boundaryLines(const ScreenView& view) const {
  std::vector<BoundaryLine> lines(boundaryTets.size());
  const double perPixel = view.orthographic ? 0 : 1 / view.perPixel;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Vec3 g = gradient[boundaryTets[i]].cast<double>();
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
      if (faces[i].bend == 0)
        continue;
      const PixelPlace &a = places[v[0]], &b = places[v[1]], &c = places[v[2]];
      const PixelBox box = a.ahead && b.ahead && c.ahead
                               ? pixelBox(view, a, b, c)
                               : pixelBox(view, vertices[v[0]], vertices[v[1]], vertices[v[2]]);
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
    if (faces[i].boundary >= 0)
      continue;
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
  const Vec3 g = gradient[view.eyeTet].cast<double>();
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
  // A jump that cannot reach kNegligible across the whole mesh.
  const double jump = 2 * kNegligible / state_->mesh().bounds().size().squaredNorm();
  state_->negligible = static_cast<float>(jump * jump);
  state_->extinction.assign(state_->mesh().vertices().size(), 0);
  state_->prepare();
}

FaceSplat::~FaceSplat() = default;
FaceSplat::FaceSplat(FaceSplat&&) noexcept = default;
FaceSplat& FaceSplat::operator=(FaceSplat&&) noexcept = default;

void FaceSplat::setExtinction(std::span<const float> extinction) {
  State& state = *state_;
  const TetMesh& mesh = state.mesh();
  VOLUTE_ASSERT(extinction.size() == mesh.vertices().size());
  state.extinction.assign(extinction.begin(), extinction.end());
  parallelRanges(mesh.tets().size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Tet& tet = mesh.tets()[t];
      const auto& slope = state.slopes[t];
      const float first = extinction[tet[0]];
      state.gradient[t] = (extinction[tet[1]] - first) * slope[0] +
                          (extinction[tet[2]] - first) * slope[1] +
                          (extinction[tet[3]] - first) * slope[2];
    }
  });
  parallelRanges(state.faces.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) state.faces[f].bend = state.bendOf(f);
  });
}

void FaceSplat::opticalDepth(const Camera& camera, OpaqueDepth opaque, std::span<float> depth) {
  State& state = *state_;
  const ScreenView view(camera, *state.locator);
  state.vertices.resize(state.mesh().vertices().size());
  state.places.resize(state.vertices.size());
  parallelRanges(state.vertices.size(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      state.vertices[i] = view.project(state.mesh().vertices()[i]);
      state.vertices[i].tau = state.extinction[i];
      state.places[i] = pixelPlace(state.vertices[i]);
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
    splatFaces(view, state.vertices.data(), state.places.data(), state.faces, lines, bins[i], tile);
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
