// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_bins.hpp"

#include <algorithm>
#include <numeric>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr std::size_t kChunk = 16384;  // tets that one task bins
constexpr std::size_t kBatch = 512;

BinnedTet inTile(BinnedTet tet, const PixelBox& box, int x, int y, int side) {
  const auto block = [side](int pixel, int tile) {
    return static_cast<std::uint8_t>(std::clamp(pixel - tile * side, 0, side - 1) /
                                     TetTile::kBlock);
  };
  tet.x0 = block(box.x0, x), tet.y0 = block(box.y0, y);
  tet.x1 = block(box.x1, x), tet.y1 = block(box.y1, y);
  return tet;
}

PixelBox unite(const PixelBox& a, const PixelBox& b) {
  if (a.empty() || b.empty())
    return a.empty() ? b : a;
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

std::vector<SplatVertex> project(const TetMesh& mesh, const ScreenView& view) {
  std::vector<SplatVertex> vertices(mesh.vertices().size());
  parallelRanges(vertices.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const ScreenVertex vertex = view.project(mesh.vertices()[i]);
      const PixelPlace place = pixelPlace(vertex);
      vertices[i] = {
          place.x, place.y, -place.x, -place.y, vertex.z, -vertex.z, place.ahead ? 0.0F : 1.0F, 0};
    }
  });
  return vertices;
}

/// Of a tet that is partly behind the eye.
PixelBox boxAtEye(const TetMesh& mesh, const ScreenView& view, const Tet& tet) {
  ScreenVertex corners[4];
  for (int k = 0; k < 4; ++k) corners[k] = view.project(mesh.vertices()[tet[k]]);
  PixelBox box;
  for (int k = 0; k < 4; ++k) {
    box = unite(box,
                pixelBox(view, corners[(k + 1) % 4], corners[(k + 2) % 4], corners[(k + 3) % 4]));
  }
  return box;
}

}  // namespace

TetBins::TetBins(const TetMesh& mesh, const ScreenView& view, int side, std::span<const char> dark,
                 std::span<const std::int32_t> order)
    : mesh_(mesh),
      side_(side),
      across_((view.width + side - 1) / side),
      down_((view.height + side - 1) / side),
      vertices_(project(mesh, view)),
      chunks_((mesh.tets().size() + kChunk - 1) / kChunk) {
  parallelFor(chunks_.size(), [&](std::size_t i) {
    const std::size_t begin = i * kChunk, end = std::min(mesh.tets().size(), begin + kChunk);
    std::vector<std::int32_t> own;
    if (order.empty()) {
      own.resize(end - begin);
      std::iota(own.begin(), own.end(), static_cast<std::int32_t>(begin));
    }
    bin(view, dark, order.empty() ? own : order.subspan(begin, end - begin), chunks_[i]);
  });
}

void TetBins::bin(const ScreenView& view, std::span<const char> dark,
                  std::span<const std::int32_t> tets, Chunk& chunk) const {
  std::vector<std::pair<std::int32_t, BinnedTet>> found;
  found.reserve(2 * kChunk);
  chunk.begin.assign(static_cast<std::size_t>(across_) * down_ + 1, 0);
  std::vector<TetSpan> spans(kBatch);
  std::vector<Tet> corners(kBatch);
  for (std::size_t i = 0; i < tets.size(); ++i) {
    const std::size_t at = i % kBatch;
    if (at == 0) {
      const std::size_t count = std::min(kBatch, tets.size() - i);
      for (std::size_t k = 0; k < count; ++k) corners[k] = mesh_.tets()[tets[i + k]];
      spanTets(view, vertices_.data(), std::span(corners).first(count), spans.data());
    }
    if (dark[tets[i]])
      continue;
    const TetSpan& span = spans[at];
    const PixelBox box = span.behind > 0 ? boxAtEye(mesh_, view, corners[at])
                                         : PixelBox{-span.minusX0, -span.minusY0, span.x1, span.y1};
    if (box.empty())
      continue;
    const BinnedTet tet{tets[i], 0, 0, 0, 0, -span.minusNearest, span.farthest};
    for (int y = box.y0 / side_; y <= box.y1 / side_; ++y) {
      for (int x = box.x0 / side_; x <= box.x1 / side_; ++x) {
        const int tile = y * across_ + x;
        ++chunk.begin[static_cast<std::size_t>(tile) + 1];
        found.emplace_back(tile, inTile(tet, box, x, y, side_));
      }
    }
  }
  for (std::size_t i = 1; i < chunk.begin.size(); ++i) chunk.begin[i] += chunk.begin[i - 1];
  chunk.tets.resize(found.size());
  std::vector<std::int32_t> next(chunk.begin.begin(), chunk.begin.end() - 1);
  for (const auto& [tile, tet] : found) chunk.tets[next[tile]++] = tet;
}

}  // namespace volute
