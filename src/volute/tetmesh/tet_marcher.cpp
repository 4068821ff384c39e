// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_marcher.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/medium/integrate.hpp"
#include "volute/tetmesh/tet_march.hpp"

namespace volute {
namespace {

constexpr int kTile = 32;   // pixels
constexpr int kSector = 8;  // tiles whose vertices are projected together, near their own origin
constexpr int kBlock = 4;   // rays side by side come from blocks of kBlock x kBlock pixels

/// A tile's pixels, entries and results.
struct TileWork {
  std::vector<MarchEntry> entries;
  std::vector<MarchRay> rays;
  std::vector<MarchResult> results;
  std::vector<std::int32_t> pixels;  // of each ray, in the picture
  std::vector<char> doubtful;        // of each pixel of the tile
};

/// Sorts by pixel, then by depth; returns where each pixel's entries begin, and the end.
std::vector<std::int32_t> sortByPixel(std::vector<MarchEntry>& entries, std::size_t pixels) {
  std::vector<std::int32_t> begin(pixels + 1, 0);
  for (const MarchEntry& entry : entries) ++begin[static_cast<std::size_t>(entry.pixel) + 1];
  for (std::size_t i = 0; i < pixels; ++i) begin[i + 1] += begin[i];
  std::vector<MarchEntry> sorted(entries.size());
  std::vector<std::int32_t> end(begin.begin(), begin.end() - 1);
  for (const MarchEntry& entry : entries) {
    const auto pixel = static_cast<std::size_t>(entry.pixel);
    std::int32_t at = end[pixel]++;
    const auto before = [](const MarchEntry& a, const MarchEntry& b) {
      return a.z != b.z ? a.z < b.z : a.halfFace < b.halfFace;
    };
    for (; at > begin[pixel] && before(entry, sorted[at - 1]); --at) sorted[at] = sorted[at - 1];
    sorted[at] = entry;
  }
  entries.swap(sorted);
  return begin;
}

/// False when rays surely leave the mesh through the face, or pass it edge on: by the sign of the
/// determinant of its vertices.
bool mayEnter(const EntryFace& face, std::span<const ScreenVertex> vertices) {
  Vec3 v[3];
  for (int i = 0; i < 3; ++i) {
    const ScreenVertex& s = vertices[face.vertices[i]];
    v[i] = Vec3(s.x, s.y, s.w);
  }
  const double determinant = v[0].cross(v[1]).dot(v[2]);
  const double rounding = 1e-5 * v[0].norm() * v[1].norm() * v[2].norm();
  return face.positive ? determinant > -rounding : determinant < rounding;
}

}  // namespace

struct TetMarcher::State {
  std::shared_ptr<const TetLocator> locator;
  std::vector<float> extinction, source;
  std::vector<EntryFace> faces;  // of the boundary; boxes are those of the last view
  std::vector<ScreenVertex> vertices;
  std::vector<ScreenRest> rests;
  std::vector<std::vector<std::int32_t>> tiles;  // faces
  std::span<const std::uint8_t> only;            // pixels to draw; empty: all
  std::atomic<std::uint64_t> steps{0}, entered{0}, doubtful{0};

  const TetMesh& mesh() const { return locator->mesh(); }

  bool drawn(int width, const PixelBox& part) const;
  void project(const ScreenView& view, bool lit);
  void bin(const ScreenView& view);
  MarchMesh marchMesh(const ScreenView& view, bool lit) const;
  void gather(const ScreenView& view, OpaqueDepth opaque, const PixelBox& tile,
              std::span<const std::int32_t> faces, TileWork& work) const;

  template <class Store, class Doubt>
  void sector(const Camera& camera, const ScreenView& view, const PixelBox& part,
              OpaqueDepth opaque, bool lit, const Store& store, const Doubt& doubt);

  /// Calls store(pixel, result) for each pixel of the picture; doubtful(pixel, ray) where the twin
  /// must do it.
  template <class Store, class Doubt>
  void picture(const Camera& camera, OpaqueDepth opaque, bool lit, const Store& store,
               const Doubt& doubt);
};

/// Whether any of the pixels of a part are to be drawn.
bool TetMarcher::State::drawn(int width, const PixelBox& part) const {
  if (only.empty())
    return true;
  for (int y = part.y0; y <= part.y1; ++y) {
    const auto row = only.subspan(static_cast<std::size_t>(y) * width + part.x0,
                                  static_cast<std::size_t>(part.x1 - part.x0) + 1);
    if (std::ranges::any_of(row, [](std::uint8_t pixel) { return pixel != 0; }))
      return true;
  }
  return false;
}

void TetMarcher::State::project(const ScreenView& view, bool lit) {
  vertices.resize(mesh().vertices().size());
  rests.resize(vertices.size());
  parallelRanges(vertices.size(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      ScreenVertex& v = vertices[i];
      v = view.project(mesh().vertices()[i], rests[i]);
      v.tau = extinction[i];
      if (lit)
        v.r = source[3 * i], v.g = source[3 * i + 1], v.b = source[3 * i + 2];
    }
  });
}

void TetMarcher::State::bin(const ScreenView& view) {
  parallelRanges(faces.size(), 2048, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      EntryFace& face = faces[i];
      face.box = {};
      if (mayEnter(face, vertices))
        face.box = pixelBox(view, vertices[face.vertices[0]], vertices[face.vertices[1]],
                            vertices[face.vertices[2]]);
    }
  });
  const int across = (view.width + kTile - 1) / kTile, down = (view.height + kTile - 1) / kTile;
  tiles.resize(static_cast<std::size_t>(across) * down);
  for (auto& tile : tiles) tile.clear();
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const PixelBox& box = faces[i].box;
    if (box.empty())
      continue;
    for (int y = box.y0 / kTile; y <= box.y1 / kTile; ++y) {
      for (int x = box.x0 / kTile; x <= box.x1 / kTile; ++x)
        tiles[static_cast<std::size_t>(y) * across + x].push_back(static_cast<std::int32_t>(i));
    }
  }
}

MarchMesh TetMarcher::State::marchMesh(const ScreenView& view, bool lit) const {
  MarchMesh march;
  march.vertices = vertices.data();
  march.rests = rests.data();
  march.tets = mesh().tets().data()->data();
  march.opposite = mesh().opposites().data();
  march.orthographic = view.orthographic;
  march.lit = lit;
  march.eyeInside = view.eyeTet >= 0;
  if (march.eyeInside) {
    const auto shares = mesh().shares(view.eyeTet, view.eye);
    double tau = 0, rgb[3] = {};
    for (int k = 0; k < 4; ++k) {
      const ScreenVertex& v = vertices[mesh().tets()[view.eyeTet][k]];
      const float source3[3] = {v.r, v.g, v.b};
      tau += shares[k] * v.tau;
      for (int c = 0; c < 3; ++c) rgb[c] += shares[k] * source3[c];
    }
    march.eyeTau = static_cast<float>(tau);
    for (int c = 0; c < 3; ++c) march.eyeRgb[c] = static_cast<float>(rgb[c]);
  }
  return march;
}

void TetMarcher::State::gather(const ScreenView& view, OpaqueDepth opaque, const PixelBox& tile,
                               std::span<const std::int32_t> faceList, TileWork& work) const {
  const int width = tile.x1 - tile.x0 + 1, height = tile.y1 - tile.y0 + 1;
  const auto count = static_cast<std::size_t>(width) * height;
  work.entries.clear(), work.rays.clear(), work.pixels.clear();
  work.doubtful.assign(count, 0);
  if (view.eyeTet >= 0) {
    for (std::size_t i = 0; i < count; ++i)
      work.entries.push_back({static_cast<std::int32_t>(i), 4 * view.eyeTet, 0});
  }
  for (const std::int32_t face : faceList)
    rasterEntries(view, vertices.data(), rests.data(), faces[face], tile, work.entries,
                  work.doubtful);
  const std::vector<std::int32_t> begin = sortByPixel(work.entries, count);
  work.results.assign(count, {});
  for (int by = 0; by < height; by += kBlock) {
    for (int bx = 0; bx < width; bx += kBlock) {
      for (int y = by; y < std::min(by + kBlock, height); ++y) {
        for (int x = bx; x < std::min(bx + kBlock, width); ++x) {
          const std::size_t local = static_cast<std::size_t>(y) * width + x;
          const std::int32_t pixel = (y + tile.y0) * view.width + x + tile.x0;
          if (!only.empty() && only[static_cast<std::size_t>(pixel)] == 0)
            continue;
          const double px = view.pixelX(x + tile.x0), py = view.pixelY(y + tile.y0);
          const double scale = view.rayScale(x + tile.x0, y + tile.y0);
          const double end = opaque.empty() ? std::numeric_limits<double>::max()
                                            : std::min<double>(opaque[pixel] / scale, 1e30);
          work.results[work.rays.size()].doubtful = work.doubtful[local] != 0;
          work.rays.push_back({static_cast<float>(px), static_cast<float>(py),
                               static_cast<float>(scale), static_cast<float>(std::min(end, 1e30)),
                               begin[local], begin[local + 1]});
          work.pixels.push_back(pixel);
        }
      }
    }
  }
}

template <class Store, class Doubt>
void TetMarcher::State::picture(const Camera& camera, OpaqueDepth opaque, bool lit,
                                const Store& store, const Doubt& doubt) {
  ScreenView view(camera, *locator);
  project(view, lit);
  bin(view);
  constexpr int kSide = kTile * kSector;
  for (int y = 0; y < view.height; y += kSide) {
    for (int x = 0; x < view.width; x += kSide) {
      const PixelBox part{x, y, std::min(x + kSide, view.width) - 1,
                          std::min(y + kSide, view.height) - 1};
      if (!drawn(view.width, part))
        continue;
      view.originX = x + 0.5 * std::min(kSide, view.width - x);
      view.originY = y + 0.5 * std::min(kSide, view.height - y);
      project(view, lit);
      sector(camera, view, part, opaque, lit, store, doubt);
    }
  }
}

template <class Store, class Doubt>
void TetMarcher::State::sector(const Camera& camera, const ScreenView& view, const PixelBox& part,
                               OpaqueDepth opaque, bool lit, const Store& store,
                               const Doubt& doubt) {
  const MarchMesh march = marchMesh(view, lit);
  const int across = (part.x1 - part.x0) / kTile + 1, down = (part.y1 - part.y0) / kTile + 1;
  const int all = (view.width + kTile - 1) / kTile;
  parallelFor(static_cast<std::size_t>(across) * down, [&](std::size_t at) {
    const int x0 = part.x0 + static_cast<int>(at) % across * kTile;
    const int y0 = part.y0 + static_cast<int>(at) / across * kTile;
    const std::size_t i = static_cast<std::size_t>(y0 / kTile) * all + x0 / kTile;
    const PixelBox tile{x0, y0, std::min(x0 + kTile, view.width) - 1,
                        std::min(y0 + kTile, view.height) - 1};
    if (!drawn(view.width, tile))
      return;
    TileWork work;
    gather(view, opaque, tile, tiles[i], work);
    steps += marchRays(march, work.rays, work.entries, work.results);
    entered += work.entries.size();
    for (std::size_t r = 0; r < work.rays.size(); ++r) {
      const std::int32_t pixel = work.pixels[r];
      if (!work.results[r].doubtful) {
        store(pixel, work.results[r]);
        continue;
      }
      ++doubtful;
      doubt(pixel, pixelRay(camera, pixel % view.width, pixel / view.width, opaque));
    }
  });
}

TetMarcher::TetMarcher(std::shared_ptr<const TetLocator> locator)
    : state_(std::make_unique<State>()) {
  state_->locator = std::move(locator);
  const TetMesh& mesh = state_->mesh();
  state_->extinction.assign(mesh.vertices().size(), 0);
  for (const std::int32_t f : mesh.boundary()) {
    const TetFace& face = mesh.faces()[f];
    EntryFace entry;
    std::ranges::copy(face.vertices, entry.vertices);
    entry.halfFace = face.first;
    // Seen from outside, the vertices of a tet's face in ascending order run clockwise or not by
    // the sign of its volume and the place of the vertex across.
    const Tet& tet = mesh.tets()[face.first / 4];
    const Vec3& o = mesh.vertices()[tet[0]];
    const bool right = (mesh.vertices()[tet[1]] - o)
                           .cross(mesh.vertices()[tet[2]] - o)
                           .dot(mesh.vertices()[tet[3]] - o) > 0;
    entry.positive = right == ((face.first & 1) != 0);
    state_->faces.push_back(entry);
  }
}

TetMarcher::~TetMarcher() = default;
TetMarcher::TetMarcher(TetMarcher&&) noexcept = default;
TetMarcher& TetMarcher::operator=(TetMarcher&&) noexcept = default;

void TetMarcher::setExtinction(std::span<const float> extinction) {
  VOLUTE_ASSERT(extinction.size() == state_->mesh().vertices().size());
  state_->extinction.assign(extinction.begin(), extinction.end());
}

void TetMarcher::setSource(std::span<const float> source) {
  VOLUTE_ASSERT(source.empty() || source.size() == 3 * state_->mesh().vertices().size());
  state_->source.assign(source.begin(), source.end());
}

void TetMarcher::opticalDepth(const Camera& camera, OpaqueDepth opaque, std::span<float> depth) {
  const TetMedium twin(state_->locator, state_->extinction);
  // Where something is in the eye there is nothing to march, and whole tiles are left out. Parallel
  // rays begin far behind a depth of 0.
  std::vector<std::uint8_t> far;
  if (!camera.isOrthographic() && std::ranges::find(opaque, 0.0F) != opaque.end()) {
    far.resize(opaque.size());
    std::ranges::transform(opaque, far.begin(), [](float end) { return end > 0 ? 1 : 0; });
    std::ranges::fill(depth, 0.0F);
  }
  state_->only = far;
  state_->picture(
      camera, opaque, false,
      [&](std::int32_t pixel, const MarchResult& result) { depth[pixel] = result.depth; },
      [&](std::int32_t pixel, const Segment& ray) {
        double exact = 0;
        twin.opticalDepth({&ray, 1}, {&exact, 1});
        depth[pixel] = static_cast<float>(exact);
      });
  state_->only = {};
}

void TetMarcher::litColor(const Camera& camera, OpaqueDepth opaque, std::span<float> rgbt,
                          std::span<const std::uint8_t> only) {
  VOLUTE_ASSERT(only.empty() || 4 * only.size() == rgbt.size());
  state_->only = only;
  const TetMedium twin(state_->locator, state_->extinction, state_->source);
  state_->picture(
      camera, opaque, !state_->source.empty(),
      [&](std::int32_t pixel, const MarchResult& result) {
        float* out = &rgbt[4 * static_cast<std::size_t>(pixel)];
        std::copy_n(result.rgb, 3, out);
        out[3] = std::exp(-result.depth);
      },
      [&](std::int32_t pixel, const Segment& ray) {
        Radiance exact;
        radianceByPieces(twin, {&ray, 1}, {&exact, 1});
        float* out = &rgbt[4 * static_cast<std::size_t>(pixel)];
        for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(exact.emitted[c]);
        out[3] = static_cast<float>(exact.transmittance);
      });
  state_->only = {};
}

TetMarchCounts TetMarcher::counts() const {
  return {state_->steps, state_->entered, state_->doubtful};
}

}  // namespace volute
