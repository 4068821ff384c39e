// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/projector.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr std::size_t kChunks = 32;
constexpr std::size_t kLeastRows = 256;

/// Image points of a pixel's rays, from its upper left corner.
std::array<double, 2> rayOffset(int raysPerPixel, int ray) {
  if (raysPerPixel == 1)
    return {0.5, 0.5};
  return {ray & 1 ? 0.75 : 0.25, ray & 2 ? 0.75 : 0.25};
}

/// The pixels and rays of one image row.
struct ImageRow {
  std::vector<PixelRow> pixels;
  std::vector<WalkRay> rays;
};

ImageRow makeImageRow(const Support& support, const Camera& camera,
                      std::span<const std::uint8_t> mask, int raysPerPixel, int view, int y) {
  ImageRow row;
  for (int x = 0; x < camera.width(); ++x) {
    const std::int32_t pixel = y * camera.width() + x;
    if (!mask.empty() && mask[pixel] == 0)
      continue;
    const std::size_t before = row.rays.size();
    bool meets = false;
    for (int i = 0; i < raysPerPixel; ++i) {
      const auto [dx, dy] = rayOffset(raysPerPixel, i);
      row.rays.push_back(walkRay(support, camera.ray(x + dx, y + dy)));
      meets = meets || row.rays.back().length > 0;
    }
    if (meets)
      row.pixels.push_back({view, pixel});
    else
      row.rays.resize(before);
  }
  return row;
}

}  // namespace

/// The projector's own working memory, or some for once when another product has it.
class Projector::ScratchUse {
 public:
  explicit ScratchUse(const Projector& projector)
      : lock_(projector.scratchMutex_, std::try_to_lock),
        scratch_(lock_ ? &projector.scratch_ : &own_) {}

  Scratch* operator->() const { return scratch_; }

 private:
  std::unique_lock<std::mutex> lock_;
  Scratch own_;
  Scratch* scratch_;
};

WalkRay walkRay(const Support& support, const Segment& segment) {
  WalkRay ray{};
  double first = 0;
  bool found = false;
  const CellGrid& cells = support.cells();
  traverseCells(cells, support.range(), segment,
                [&](const std::array<int, 3>& cell, double begin, double end) {
                  if (!support.touches(cell))
                    return;
                  if (!found) {
                    found = true;
                    first = begin;
                    ray.node = support.nodeOf(cell);
                    for (int a = 0; a < 3; ++a) {
                      const double place = (segment.origin[a] + begin * segment.direction[a] -
                                            cells.plane(a, cell[a])) /
                                           cells.cell[a];
                      ray.position[a] = static_cast<float>(std::clamp(place, 0.0, 1.0));
                      ray.velocity[a] = static_cast<float>(segment.direction[a] / cells.cell[a]);
                    }
                  }
                  ray.length = static_cast<float>(end - first);
                });
  return ray;
}

Projector::Projector(std::span<const ProjectorView> views, std::shared_ptr<const Support> support,
                     int raysPerPixel, std::uint64_t tableBytes)
    : support_(std::move(support)), raysPerPixel_(raysPerPixel) {
  lattice_.basis = support_->basis();
  std::ranges::copy(support_->stride(), lattice_.stride);
  for (std::size_t v = 0; v < views.size(); ++v) addView(static_cast<int>(v), views[v]);
  cutChunks();
  if (writeTables(tableBytes)) {
    rays_ = {};
  } else {
    parallelFor(chunks_.size(), [&](std::size_t i) { reach(chunks_[i]); });
  }
}

void Projector::addView(int view, const ProjectorView& what) {
  std::vector<ImageRow> rows(what.camera->height());
  parallelFor(rows.size(), [&](std::size_t y) {
    rows[y] =
        makeImageRow(*support_, *what.camera, what.mask, raysPerPixel_, view, static_cast<int>(y));
  });
  for (const ImageRow& row : rows) {
    rows_.insert(rows_.end(), row.pixels.begin(), row.pixels.end());
    rays_.insert(rays_.end(), row.rays.begin(), row.rays.end());
  }
}

/// Cuts depend on the sizes alone. Each chunk has a gradient of its own, so that there are fewer
/// where the volume is large and the rows are few.
void Projector::cutChunks() {
  const std::size_t count = std::clamp<std::size_t>(rows() / kLeastRows, 1, kChunks);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t first = rows() * i / count, last = rows() * (i + 1) / count;
    chunks_.push_back({first, last, 0, 0});
  }
}

/// Bounds of the nodes that the rays reach, from the boxes around them.
void Projector::reach(Chunk& chunk) const {
  std::int32_t low = std::numeric_limits<std::int32_t>::max(), high = 0;
  const std::size_t first = chunk.firstRow * raysPerPixel_, last = chunk.lastRow * raysPerPixel_;
  for (std::size_t i = first; i < last; ++i) {
    const WalkRay& ray = rays_[i];
    if (!(ray.length > 0))
      continue;
    std::int32_t from = ray.node, to = ray.node;
    for (int a = 0; a < 3; ++a) {
      const double ends = ray.position[a] + static_cast<double>(ray.length) * ray.velocity[a];
      // The upper corners, and two cells more at both ends: one as rounding may have it, one as
      // walks end with weights of 0 beside the last cell.
      from += static_cast<std::int32_t>(std::min(std::floor(ends) - 2, 0.0)) * lattice_.stride[a];
      to += static_cast<std::int32_t>(std::max(std::floor(ends) + 3, 1.0)) * lattice_.stride[a];
    }
    low = std::min(low, from);
    high = std::max(high, to + 1);
  }
  chunk.firstNode =
      std::clamp<std::int32_t>(low, 0, static_cast<std::int32_t>(support_->latticeSize()));
  chunk.lastNode = std::clamp<std::int32_t>(high, chunk.firstNode,
                                            static_cast<std::int32_t>(support_->latticeSize()));
}

bool Projector::writeTables(std::uint64_t bytes) {
  std::vector<std::int32_t> unknownAt(support_->latticeSize(), -1);
  for (std::size_t i = 0; i < unknowns(); ++i)
    unknownAt[support_->nodes()[i]] = static_cast<std::int32_t>(i);
  std::vector<Table> tables(chunks_.size());
  // Twice, by row and by unknown, and once more while the parts are put together.
  const std::uint64_t most = bytes / (3 * sizeof(NodeWeight));
  std::atomic<std::uint64_t> written = 0;
  parallelFor(chunks_.size(), [&](std::size_t i) {
    if (written > most)
      return;
    writeTable(chunks_[i], unknownAt, tables[i]);
    written += tables[i].weights.size();
  });
  // The sum is the same whatever the order, unless it is too large in any.
  if (written > most)
    return false;
  byRow_.weights.reserve(written);
  byRow_.begin.push_back(0);
  for (Table& table : tables) {
    const std::uint64_t before = byRow_.weights.size();
    byRow_.weights.insert(byRow_.weights.end(), table.weights.begin(), table.weights.end());
    for (std::size_t i = 1; i < table.begin.size(); ++i)
      byRow_.begin.push_back(before + table.begin[i]);
    table = {};
  }
  transposeTable();
  return true;
}

void Projector::writeTable(const Chunk& chunk, std::span<const std::int32_t> unknownAt,
                           Table& table) const {
  constexpr std::size_t kRowsAtOnce = 16;
  std::vector<std::uint32_t> place(unknowns(), 0);  // in the row, from 1; 0 = not there yet
  std::vector<std::vector<NodeWeight>> raw(kRowsAtOnce);
  table.begin.push_back(0);
  for (std::size_t first = chunk.firstRow; first < chunk.lastRow; first += kRowsAtOnce) {
    const std::size_t count = std::min(kRowsAtOnce, chunk.lastRow - first);
    for (auto& row : raw) row.clear();
    walkWeights(lattice_, rays_.data() + first * raysPerPixel_, count, raysPerPixel_, raw.data());
    for (std::size_t row = 0; row < count; ++row) {
      const std::size_t begin = table.weights.size();
      for (const NodeWeight& w : raw[row]) {
        const std::int32_t unknown = unknownAt[w.node];
        if (unknown < 0)
          continue;
        if (place[unknown] == 0) {
          table.weights.push_back({unknown, 0});
          place[unknown] = static_cast<std::uint32_t>(table.weights.size() - begin);
        }
        table.weights[begin + place[unknown] - 1].weight += w.weight;
      }
      for (std::size_t i = begin; i < table.weights.size(); ++i) place[table.weights[i].node] = 0;
      table.begin.push_back(table.weights.size());
    }
  }
}

void Projector::transposeTable() {
  byUnknown_.begin.assign(unknowns() + 1, 0);
  for (const NodeWeight& w : byRow_.weights) ++byUnknown_.begin[w.node + 1];
  for (std::size_t i = 0; i < unknowns(); ++i) byUnknown_.begin[i + 1] += byUnknown_.begin[i];
  std::vector<std::uint64_t> next(byUnknown_.begin.begin(), byUnknown_.begin.end() - 1);
  byUnknown_.weights.resize(byRow_.weights.size());
  for (std::size_t row = 0; row < rows(); ++row) {
    for (std::uint64_t i = byRow_.begin[row]; i < byRow_.begin[row + 1]; ++i) {
      const NodeWeight& w = byRow_.weights[i];
      byUnknown_.weights[next[w.node]++] = {static_cast<std::int32_t>(row), w.weight};
    }
  }
}

/// sums = table * values, rows on all threads.
void Projector::multiply(const Table& table, std::span<const float> values,
                         std::span<float> sums) const {
  parallelRanges(table.begin.size() - 1, 64, [&](std::size_t begin, std::size_t end) {
    tableSums(table.weights.data(), table.begin.data() + begin, end - begin, values.data(),
              sums.data() + 4 * begin);
  });
}

void Projector::toLattice(std::span<const float> unknowns, std::vector<float>& lattice) const {
  lattice.resize(4 * support_->latticeSize());  // what is no unknown stays 0
  const auto nodes = support_->nodes();
  parallelRanges(nodes.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      std::copy_n(&unknowns[4 * i], 4, &lattice[4 * static_cast<std::size_t>(nodes[i])]);
  });
}

void Projector::forward(std::span<const float> unknowns, std::span<float> pixels) const {
  VOLUTE_ASSERT(unknowns.size() == 4 * this->unknowns() && pixels.size() == 4 * rows());
  if (usesTable()) {
    multiply(byRow_, unknowns, pixels);
    return;
  }
  const ScratchUse scratch(*this);
  std::vector<float>& lattice = scratch->lattice;
  toLattice(unknowns, lattice);
  parallelRanges(rows(), 64, [&](std::size_t begin, std::size_t end) {
    walkForward(lattice_, lattice.data(), rays_.data() + begin * raysPerPixel_, end - begin,
                raysPerPixel_, pixels.data() + 4 * begin);
  });
}

void Projector::adjoint(std::span<const float> pixels, std::span<float> unknowns) const {
  VOLUTE_ASSERT(unknowns.size() == 4 * this->unknowns() && pixels.size() == 4 * rows());
  if (usesTable()) {
    multiply(byUnknown_, pixels, unknowns);
    return;
  }
  const ScratchUse scratch(*this);
  std::vector<std::vector<float>>& parts = scratch->parts;
  parts.resize(chunks_.size());
  parallelFor(chunks_.size(), [&](std::size_t i) {
    const Chunk& chunk = chunks_[i];
    parts[i].assign(4 * static_cast<std::size_t>(chunk.lastNode - chunk.firstNode), 0.0F);
    float* origin = parts[i].data() - 4 * static_cast<std::ptrdiff_t>(chunk.firstNode);
    walkAdjoint(lattice_, pixels.data() + 4 * chunk.firstRow,
                rays_.data() + chunk.firstRow * raysPerPixel_, chunk.lastRow - chunk.firstRow,
                raysPerPixel_, origin);
  });
  addParts(parts, unknowns);
}

/// In the order of the chunks.
void Projector::addParts(std::span<const std::vector<float>> parts,
                         std::span<float> unknowns) const {
  const auto nodes = support_->nodes();
  parallelRanges(nodes.size(), 1024, [&](std::size_t begin, std::size_t end) {
    std::fill(unknowns.begin() + 4 * begin, unknowns.begin() + 4 * end, 0.0F);
    for (std::size_t c = 0; c < chunks_.size(); ++c) {
      // Nodes ascend with the unknowns.
      const auto from =
          std::lower_bound(nodes.begin() + begin, nodes.begin() + end, chunks_[c].firstNode);
      const auto to = std::lower_bound(from, nodes.begin() + end, chunks_[c].lastNode);
      const float* part = parts[c].data() - 4 * static_cast<std::ptrdiff_t>(chunks_[c].firstNode);
      for (auto i = static_cast<std::size_t>(from - nodes.begin()),
                last = static_cast<std::size_t>(to - nodes.begin());
           i < last; ++i)
        for (int k = 0; k < 4; ++k)
          unknowns[4 * i + k] += part[4 * static_cast<std::ptrdiff_t>(nodes[i]) + k];
    }
  });
}

}  // namespace volute
