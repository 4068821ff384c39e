// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/projector.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/tomography/beam.hpp"

namespace volute {
namespace {

constexpr std::size_t kChunkRows = 2048;
constexpr std::size_t kMaxChunks = 32;
constexpr std::size_t kTableParts = 32;
constexpr std::size_t kPartRows = 256;
constexpr std::size_t kMaxRays = 4;

using Colour = Eigen::Array4f;

/// Image points of a pixel's rays, from its upper left corner.
std::array<double, 2> rayOffset(int raysPerPixel, int ray) {
  if (raysPerPixel == 1)
    return {0.5, 0.5};
  return {ray & 1 ? 0.75 : 0.25, ray & 2 ? 0.75 : 0.25};
}

/// The pixels and rays of one image row.
struct ImageRow {
  std::vector<PixelRow> pixels;
  std::vector<std::uint8_t> isBeam;  ///< of each pixel
  std::vector<Beam> beams;
  std::vector<BeamRay> beamRays;
  std::vector<WalkRay> looseRays;
};

/// The rays of one pixel, if any meets an unknown.
void addPixel(const Support& support, std::span<const Segment> segments, PixelRow pixel,
              ImageRow& row) {
  std::array<TouchedPart, kMaxRays> touched;
  bool meets = false;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    touched[i] = touchedPart(support, segments[i]);
    meets = meets || !touched[i].empty();
  }
  if (!meets)
    return;
  row.pixels.push_back(pixel);
  Beam beam{};
  std::array<BeamRay, kMaxRays> rays{};
  const bool isBeam =
      support.basis() == Basis::kTrilinear && makeBeam(support, segments, touched, beam, rays);
  row.isBeam.push_back(isBeam ? 1 : 0);
  if (isBeam) {
    row.beams.push_back(beam);
    row.beamRays.insert(row.beamRays.end(), rays.begin(), rays.begin() + segments.size());
    return;
  }
  for (std::size_t i = 0; i < segments.size(); ++i)
    row.looseRays.push_back(walkRay(support, segments[i], touched[i]));
}

ImageRow makeImageRow(const Support& support, const Camera& camera,
                      std::span<const std::uint8_t> mask, int raysPerPixel, int view, int y) {
  ImageRow row;
  for (int x = 0; x < camera.width(); ++x) {
    const std::int32_t pixel = y * camera.width() + x;
    if (!mask.empty() && mask[pixel] == 0)
      continue;
    std::array<Segment, kMaxRays> segments;
    for (int i = 0; i < raysPerPixel; ++i) {
      const auto [dx, dy] = rayOffset(raysPerPixel, i);
      segments[i] = camera.ray(x + dx, y + dy);
    }
    addPixel(support, std::span(segments).first(raysPerPixel), {view, pixel}, row);
  }
  return row;
}

/// Bounds of lattice nodes.
struct NodeRange {
  std::int32_t first = std::numeric_limits<std::int32_t>::max(), last = 0;

  void add(std::int32_t low, std::int32_t high) {
    first = std::min(first, low);
    last = std::max(last, high + 1);
  }
};

/// The nodes between the corners of the windows that a beam has in its first and last plane.
void addReach(const Beam& beam, std::span<const BeamRay> rays, NodeRange& range) {
  std::array<std::int32_t, 3> most{0, 0, beam.slabs};
  for (int a = 0; a < 2; ++a) {
    float end = 0;
    for (const BeamRay& ray : rays)
      end = std::max(end, ray.place[a] + static_cast<float>(beam.slabs) * ray.slope[a]);
    // One node more, as rounding may have it.
    most[a] = static_cast<std::int32_t>(end) + kBeamNodes;
  }
  std::int32_t low = beam.node, high = beam.node;
  for (int a = 0; a < 3; ++a) {
    const std::int32_t way = most[a] * beam.stride[a];
    low += std::min(way, 0);
    high += std::max(way, 0);
  }
  range.add(low, high);
}

/// The nodes of the box around a ray.
void addReach(const WalkRay& ray, const WalkLattice& lattice, NodeRange& range) {
  if (!(ray.length > 0))
    return;
  std::int32_t from = ray.node, to = ray.node;
  for (int a = 0; a < 3; ++a) {
    const double ends = ray.position[a] + static_cast<double>(ray.length) * ray.velocity[a];
    // The upper corners, and two cells more at both ends: one as rounding may have it, one as
    // walks end with weights of 0 beside the last cell.
    from += static_cast<std::int32_t>(std::min(std::floor(ends) - 2, 0.0)) * lattice.stride[a];
    to += static_cast<std::int32_t>(std::max(std::floor(ends) + 3, 1.0)) * lattice.stride[a];
  }
  range.add(from, to);
}

/// How many cells a ray enters, about.
int cellsOf(const WalkRay& ray) {
  float speed = 0;
  for (const float v : ray.velocity) speed += std::abs(v);
  return static_cast<int>(ray.length * speed);
}

/// What stands at `from`, in groups of `size`.
template <class T>
std::vector<T> taken(std::span<const T> values, std::span<const std::uint32_t> from,
                     std::size_t size) {
  std::vector<T> out;
  out.reserve(from.size() * size);
  for (const std::uint32_t i : from)
    out.insert(out.end(), values.begin() + i * size, values.begin() + (i + 1) * size);
  return out;
}

/// 0 .. count - 1 by key(i); those of the same key in their own order.
template <class Key>
std::vector<std::uint32_t> sortedBy(std::size_t count, Key&& key) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, {}, key);
  return order;
}

}  // namespace

/// The projector's own working memory, or some for once when another product has it.
class Projector::ScratchUse {
 public:
  explicit ScratchUse(const Projector& projector)
      : lock_(projector.scratchMutex_, std::try_to_lock),
        scratch_(lock_ ? &projector.scratch_ : &own_) {}

  Scratch* operator->() const { return scratch_; }

  Scratch& operator*() const { return *scratch_; }

 private:
  std::unique_lock<std::mutex> lock_;
  Scratch own_;
  Scratch* scratch_;
};

WalkRay walkRay(const Support& support, const Segment& segment, const TouchedPart& touched) {
  WalkRay ray{};
  if (touched.empty())
    return ray;
  const CellGrid& cells = support.cells();
  ray.node = support.nodeOf(touched.firstCell);
  ray.length = static_cast<float>(touched.part.length());
  for (int a = 0; a < 3; ++a) {
    const double place =
        (segment.at(touched.part.begin)[a] - cells.plane(a, touched.firstCell[a])) / cells.cell[a];
    ray.position[a] = static_cast<float>(std::clamp(place, 0.0, 1.0));
    ray.velocity[a] = static_cast<float>(segment.direction[a] / cells.cell[a]);
  }
  return ray;
}

Projector::Projector(std::span<const ProjectorView> views, std::shared_ptr<const Support> support,
                     int raysPerPixel, std::uint64_t tableBytes)
    : support_(std::move(support)), raysPerPixel_(raysPerPixel) {
  lattice_.basis = support_->basis();
  std::ranges::copy(support_->stride(), lattice_.stride);
  for (std::size_t v = 0; v < views.size(); ++v) addView(static_cast<int>(v), views[v]);
  finish(tableBytes);
}

Projector::Projector(std::span<const Segment> lines, std::shared_ptr<const Support> support,
                     std::uint64_t tableBytes)
    : support_(std::move(support)), raysPerPixel_(1) {
  lattice_.basis = support_->basis();
  std::ranges::copy(support_->stride(), lattice_.stride);
  addLines(lines);
  finish(tableBytes);
}

/// Beams go from one side of the volume to the other; lines may end within it.
void Projector::addLines(std::span<const Segment> lines) {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const TouchedPart touched = touchedPart(*support_, lines[i]);
    if (touched.empty())
      continue;
    looseRows_.push_back(static_cast<std::uint32_t>(rows_.size()));
    rows_.push_back({0, static_cast<std::int32_t>(i)});
    looseRays_.push_back(walkRay(*support_, lines[i], touched));
  }
}

/// Writes tables, or cuts the rows into chunks.
void Projector::finish(std::uint64_t tableBytes) {
  if (tableBytes > 0)
    beamFields_ = BeamFields(beams_, beamRays_);
  const bool written = writeTables(tableBytes);
  beamFields_ = {};
  if (written) {
    beamRows_ = {}, looseRays_ = {}, looseRows_ = {};
  } else {
    cutChunks();
    beamFields_ = BeamFields(beams_, beamRays_);
  }
  beams_ = {}, beamRays_ = {};
}

void Projector::addView(int view, const ProjectorView& what) {
  std::vector<ImageRow> rows(what.camera->height());
  parallelFor(rows.size(), [&](std::size_t y) {
    rows[y] =
        makeImageRow(*support_, *what.camera, what.mask, raysPerPixel_, view, static_cast<int>(y));
  });
  for (const ImageRow& row : rows) {
    for (std::size_t i = 0; i < row.pixels.size(); ++i)
      (row.isBeam[i] != 0 ? beamRows_ : looseRows_)
          .push_back(static_cast<std::uint32_t>(rows_.size() + i));
    rows_.insert(rows_.end(), row.pixels.begin(), row.pixels.end());
    beams_.insert(beams_.end(), row.beams.begin(), row.beams.end());
    beamRays_.insert(beamRays_.end(), row.beamRays.begin(), row.beamRays.end());
    looseRays_.insert(looseRays_.end(), row.looseRays.begin(), row.looseRays.end());
  }
}

/// For each row, the lattice plane on the slowest axis which its rays pass half-way.
std::vector<std::int32_t> Projector::rowPlanes() const {
  std::vector<std::int32_t> plane(rows());
  const std::int32_t size = lattice_.stride[2];
  for (std::size_t i = 0; i < beams_.size(); ++i) {
    const Beam& beam = beams_[i];
    const BeamRay& ray = beamRays_[i * raysPerPixel_];
    const float half = 0.5F * static_cast<float>(beam.slabs);
    auto node = static_cast<double>(beam.node) + half * static_cast<float>(beam.stride[2]);
    for (int a = 0; a < 2; ++a) node += half * ray.slope[a] * static_cast<float>(beam.stride[a]);
    plane[beamRows_[i]] = static_cast<std::int32_t>(node / size);
  }
  for (std::size_t i = 0; i < looseRows_.size(); ++i) {
    const WalkRay& ray = looseRays_[i * raysPerPixel_];
    const double node = ray.node + 0.5 * ray.length * ray.velocity[2] * size;
    plane[looseRows_[i]] = static_cast<std::int32_t>(node / size);
  }
  return plane;
}

/// Cuts depend on the rows alone. Each chunk has a gradient of its own, so that there are fewer
/// where rows are few; rows that pass near to each other go together, so that each reaches few
/// nodes.
void Projector::cutChunks() {
  const std::vector<std::int32_t> plane = rowPlanes();
  std::vector<std::uint8_t> chunkOf(rows()), isTurned(rows());
  for (std::size_t i = 0; i < beams_.size(); ++i)
    isTurned[beamRows_[i]] = static_cast<std::uint8_t>(beams_[i].turned);
  for (const std::uint8_t turned : {0, 1}) {
    std::vector<std::uint32_t> order;
    for (std::size_t row = 0; row < rows(); ++row) {
      if (isTurned[row] == turned)
        order.push_back(static_cast<std::uint32_t>(row));
    }
    std::ranges::stable_sort(order, {}, [&](std::uint32_t row) { return plane[row]; });
    const std::size_t first = chunks_.size();
    const std::size_t most =
        std::max<std::size_t>(kMaxChunks * order.size() / std::max<std::size_t>(rows(), 1), 1);
    const std::size_t count =
        order.empty() ? 0 : std::clamp<std::size_t>(order.size() / kChunkRows, 1, most);
    for (std::size_t k = 0; k < order.size(); ++k)
      chunkOf[order[k]] = static_cast<std::uint8_t>(first + k * count / order.size());
    chunks_.resize(first + count, {.turned = turned != 0});
  }

  // Beams and rays walk in groups, until the last of a group has arrived: those that go equally far
  // go together.
  const auto beamOrder = sortedBy(beams_.size(), [&](std::uint32_t i) {
    return std::pair(chunkOf[beamRows_[i]], beams_[i].slabs);
  });
  beams_ = taken<Beam>(beams_, beamOrder, 1);
  beamRays_ = taken<BeamRay>(beamRays_, beamOrder, raysPerPixel_);
  beamRows_ = taken<std::uint32_t>(beamRows_, beamOrder, 1);
  const auto looseOrder = sortedBy(looseRows_.size(), [&](std::uint32_t i) {
    return std::pair(chunkOf[looseRows_[i]], cellsOf(looseRays_[i * raysPerPixel_]));
  });
  looseRays_ = taken<WalkRay>(looseRays_, looseOrder, raysPerPixel_);
  looseRows_ = taken<std::uint32_t>(looseRows_, looseOrder, 1);

  std::size_t beam = 0, loose = 0;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    Chunk& chunk = chunks_[i];
    chunk.firstBeam = beam;
    while (beam < beams_.size() && chunkOf[beamRows_[beam]] == i) ++beam;
    chunk.lastBeam = beam;
    chunk.firstLoose = loose;
    while (loose < looseRows_.size() && chunkOf[looseRows_[loose]] == i) ++loose;
    chunk.lastLoose = loose;
  }
  parallelFor(chunks_.size(), [&](std::size_t i) { reach(chunks_[i]); });
  if (std::ranges::any_of(chunks_, &Chunk::turned)) {
    for (const std::int32_t node : support_->nodes())
      turnedNodes_.push_back(support_->turned(node));
  }
}

/// Bounds of the nodes that the rays reach.
void Projector::reach(Chunk& chunk) const {
  const auto rays = static_cast<std::size_t>(raysPerPixel_);
  const auto size = static_cast<std::int32_t>(support_->latticeSize());
  NodeRange range;
  for (std::size_t i = chunk.firstBeam; i < chunk.lastBeam; ++i)
    addReach(beams_[i], std::span(beamRays_).subspan(i * rays, rays), range);
  for (std::size_t i = chunk.firstLoose * rays; i < chunk.lastLoose * rays; ++i)
    addReach(looseRays_[i], lattice_, range);
  if (range.first >= range.last)
    return;
  // Whole planes, which hold the same unknowns in both lattices.
  const std::int32_t begin = support_->nodeOf(support_->range().begin), plane = lattice_.stride[2];
  auto planeAt = [&](std::int32_t node, int more) {
    return begin + plane * (more + static_cast<std::int32_t>(
                                       std::floor(static_cast<double>(node - begin) / plane)));
  };
  const std::int32_t first = planeAt(range.first, 0), last = planeAt(range.last, 1);
  auto unknownAt = [&](std::int32_t node) {
    return static_cast<std::size_t>(std::ranges::lower_bound(support_->nodes(), node) -
                                    support_->nodes().begin());
  };
  chunk.firstUnknown = unknownAt(first);
  chunk.lastUnknown = unknownAt(last);
  chunk.firstNode = std::clamp(first, 0, size);
  chunk.lastNode = std::clamp(last, chunk.firstNode, size);
}

std::uint64_t Projector::productBytes() const {
  if (usesTable())
    return 0;
  constexpr std::uint64_t kColour = 4 * sizeof(float);
  std::uint64_t nodes = support_->latticeSize() * (turnedNodes_.empty() ? 1 : 2);
  for (const Chunk& chunk : chunks_)
    nodes += static_cast<std::uint64_t>(chunk.lastNode - chunk.firstNode);
  return nodes * kColour;
}

bool Projector::writeTables(std::uint64_t bytes) {
  if (bytes == 0)
    return false;
  std::vector<std::int32_t> unknownAt(support_->latticeSize(), -1);
  for (std::size_t i = 0; i < unknowns(); ++i)
    unknownAt[support_->nodes()[i]] = static_cast<std::int32_t>(i);
  const std::size_t count = std::clamp<std::size_t>(rows() / kPartRows, 1, kTableParts);
  std::vector<Table> tables(count);
  // Twice, by row and by unknown, and once more while the parts are put together.
  const std::uint64_t most = bytes / (3 * sizeof(NodeWeight));
  std::atomic<std::uint64_t> written = 0;
  parallelFor(count, [&](std::size_t i) {
    if (written > most)
      return;
    writeTable(rows() * i / count, rows() * (i + 1) / count, unknownAt, tables[i]);
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

/// The weights of `count` rows from `first` on, as they come.
void Projector::rawWeights(std::size_t first, std::size_t count,
                           std::span<std::vector<NodeWeight>> raw) const {
  const auto last = static_cast<std::uint32_t>(first + count);
  std::vector<std::vector<NodeWeight>> own(count);
  auto put = [&](std::span<const std::uint32_t> rowOf, std::size_t from, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) std::swap(raw[rowOf[from + i] - first], own[i]);
  };
  for (auto& row : raw) row.clear();
  auto begin = std::ranges::lower_bound(beamRows_, first) - beamRows_.begin();
  auto end = std::ranges::lower_bound(beamRows_, last) - beamRows_.begin();
  beamWeights({beamFields_, static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin)},
              own.data());
  for (auto i = begin; i < end; ++i) {
    if (beams_[i].turned != 0)
      for (NodeWeight& w : own[i - begin]) w.node = support_->turnedBack(w.node);
  }
  put(beamRows_, begin, end - begin);
  for (auto& row : own) row.clear();
  begin = std::ranges::lower_bound(looseRows_, first) - looseRows_.begin();
  end = std::ranges::lower_bound(looseRows_, last) - looseRows_.begin();
  walkWeights(lattice_, looseRays_.data() + begin * raysPerPixel_, end - begin, raysPerPixel_,
              own.data());
  put(looseRows_, begin, end - begin);
}

void Projector::writeTable(std::size_t firstRow, std::size_t lastRow,
                           std::span<const std::int32_t> unknownAt, Table& table) const {
  constexpr std::size_t kRowsAtOnce = 16;
  std::vector<std::uint32_t> place(unknowns(), 0);  // in the row, from 1; 0 = not there yet
  std::vector<std::vector<NodeWeight>> raw(kRowsAtOnce);
  table.begin.push_back(0);
  for (std::size_t first = firstRow; first < lastRow; first += kRowsAtOnce) {
    const std::size_t count = std::min(kRowsAtOnce, lastRow - first);
    rawWeights(first, count, raw);
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

void Projector::toLattices(std::span<const float> unknowns, Scratch& scratch) const {
  for (int turned = 0; turned < (turnedNodes_.empty() ? 1 : 2); ++turned) {
    const auto nodes = latticeNodes(turned != 0);
    std::vector<float>& lattice = scratch.lattice[turned];
    lattice.resize(4 * support_->latticeSize());  // what is no unknown stays 0
    parallelRanges(nodes.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        std::copy_n(&unknowns[4 * i], 4, &lattice[4 * static_cast<std::size_t>(nodes[i])]);
    });
  }
}

void Projector::forwardLoose(std::size_t first, std::size_t last, const float* lattice,
                             std::span<float> pixels) const {
  std::vector<float> sums(4 * (last - first));
  walkForward(lattice_, lattice, looseRays_.data() + first * raysPerPixel_, last - first,
              raysPerPixel_, sums.data());
  for (std::size_t i = first; i < last; ++i)
    std::copy_n(&sums[4 * (i - first)], 4, &pixels[4 * std::size_t{looseRows_[i]}]);
}

void Projector::forward(std::span<const float> unknowns, std::span<float> pixels) const {
  VOLUTE_ASSERT(unknowns.size() == 4 * this->unknowns() && pixels.size() == 4 * rows());
  if (usesTable()) {
    multiply(byRow_, unknowns, pixels);
    return;
  }
  const ScratchUse scratch(*this);
  toLattices(unknowns, *scratch);
  parallelFor(chunks_.size(), [&](std::size_t i) {
    const Chunk& chunk = chunks_[i];
    std::vector<float> sums(4 * chunk.beams());
    beamForward(beamsOf(chunk), scratch->lattice[chunk.turned].data(), sums.data());
    putRows(chunk, sums, pixels);
  });
  parallelRanges(looseRows_.size(), 64, [&](std::size_t begin, std::size_t end) {
    forwardLoose(begin, end, scratch->lattice[0].data(), pixels);
  });
}

/// Puts sums of beams where their rows are.
void Projector::putRows(const Chunk& chunk, std::span<const float> sums,
                        std::span<float> pixels) const {
  for (std::size_t i = 0; i < chunk.beams(); ++i)
    std::copy_n(&sums[4 * i], 4, &pixels[4 * std::size_t{beamRows_[chunk.firstBeam + i]}]);
}

/// Values of the rows `rowOf`, one after the other.
std::vector<float> Projector::valuesOf(std::span<const std::uint32_t> rowOf,
                                       std::span<const float> pixels) {
  std::vector<float> values(4 * rowOf.size());
  for (std::size_t i = 0; i < rowOf.size(); ++i)
    std::copy_n(&pixels[4 * std::size_t{rowOf[i]}], 4, &values[4 * i]);
  return values;
}

void Projector::adjointLoose(const Chunk& chunk, std::span<const float> pixels,
                             float* gradient) const {
  const std::size_t count = chunk.lastLoose - chunk.firstLoose;
  const auto values = valuesOf(std::span(looseRows_).subspan(chunk.firstLoose, count), pixels);
  walkAdjoint(lattice_, values.data(), looseRays_.data() + chunk.firstLoose * raysPerPixel_, count,
              raysPerPixel_, gradient);
}

/// work(chunk, its gradient) for all chunks; then their sum.
template <class Work>
void Projector::sumChunks(std::vector<std::vector<float>>& parts, std::span<float> unknowns,
                          Work&& work) const {
  parts.resize(chunks_.size());
  parallelFor(chunks_.size(), [&](std::size_t i) {
    const Chunk& chunk = chunks_[i];
    parts[i].resize(4 * static_cast<std::size_t>(chunk.lastNode - chunk.firstNode));
    float* gradient = parts[i].data() - 4 * static_cast<std::ptrdiff_t>(chunk.firstNode);
    // What is no unknown is never read.
    for (const std::int32_t node :
         latticeNodes(chunk.turned)
             .subspan(chunk.firstUnknown, chunk.lastUnknown - chunk.firstUnknown))
      std::fill_n(gradient + 4 * static_cast<std::ptrdiff_t>(node), 4, 0.0F);
    work(chunk, gradient);
  });
  addParts(parts, unknowns);
}

void Projector::adjoint(std::span<const float> pixels, std::span<float> unknowns) const {
  VOLUTE_ASSERT(unknowns.size() == 4 * this->unknowns() && pixels.size() == 4 * rows());
  if (usesTable()) {
    multiply(byUnknown_, pixels, unknowns);
    return;
  }
  const ScratchUse scratch(*this);
  sumChunks(scratch->parts, unknowns, [&](const Chunk& chunk, float* gradient) {
    const auto values =
        valuesOf(std::span(beamRows_).subspan(chunk.firstBeam, chunk.beams()), pixels);
    beamAdjoint(beamsOf(chunk), values.data(), gradient);
    adjointLoose(chunk, pixels, gradient);
  });
}

/// What the kernels need to turn sums of a chunk's beams into values.
struct Projector::TurnContext {
  const Turn& turn;
  std::span<const std::uint32_t> rows;

  static void call(const void* context, std::size_t first, std::size_t count, const float* sums,
                   float* values) {
    const auto& self = *static_cast<const TurnContext*>(context);
    for (std::size_t i = 0; i < count; ++i)
      self.turn(self.rows[first + i], sums + 4 * i, values + 4 * i);
  }
};

void Projector::thereAndBack(std::span<const float> unknowns, const Turn& turn,
                             std::span<float> pixels, std::span<float> result) const {
  VOLUTE_ASSERT(unknowns.size() == 4 * this->unknowns() && result.size() == unknowns.size() &&
                pixels.size() == 4 * rows());
  if (usesTable()) {
    multiply(byRow_, unknowns, pixels);
    std::vector<float> back(pixels.size());
    parallelRanges(rows(), 1024, [&](std::size_t begin, std::size_t end) {
      for (std::size_t row = begin; row < end; ++row) turn(row, &pixels[4 * row], &back[4 * row]);
    });
    multiply(byUnknown_, back, result);
    return;
  }
  const ScratchUse scratch(*this);
  toLattices(unknowns, *scratch);
  sumChunks(scratch->parts, result, [&](const Chunk& chunk, float* gradient) {
    const TurnContext context{turn, std::span(beamRows_).subspan(chunk.firstBeam, chunk.beams())};
    std::vector<float> sums(4 * chunk.beams());
    beamThereAndBack(beamsOf(chunk), scratch->lattice[chunk.turned].data(), TurnContext::call,
                     &context, sums.data(), gradient);
    putRows(chunk, sums, pixels);
    turnLoose(chunk, turn, scratch->lattice[0].data(), pixels, gradient);
  });
}

void Projector::turnLoose(const Chunk& chunk, const Turn& turn, const float* lattice,
                          std::span<float> pixels, float* gradient) const {
  forwardLoose(chunk.firstLoose, chunk.lastLoose, lattice, pixels);
  const std::size_t count = chunk.lastLoose - chunk.firstLoose;
  std::vector<float> values(4 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t row = looseRows_[chunk.firstLoose + i];
    turn(row, &pixels[4 * row], &values[4 * i]);
  }
  walkAdjoint(lattice_, values.data(), looseRays_.data() + chunk.firstLoose * raysPerPixel_, count,
              raysPerPixel_, gradient);
}

/// The unknowns' nodes in one of the lattices.
std::span<const std::int32_t> Projector::latticeNodes(bool turned) const {
  return turned ? std::span<const std::int32_t>(turnedNodes_) : support_->nodes();
}

/// In the order of the chunks.
void Projector::addParts(std::span<const std::vector<float>> parts,
                         std::span<float> unknowns) const {
  parallelRanges(this->unknowns(), 1024, [&](std::size_t begin, std::size_t end) {
    std::fill(unknowns.begin() + 4 * begin, unknowns.begin() + 4 * end, 0.0F);
    for (std::size_t c = 0; c < parts.size(); ++c) {
      const Chunk& chunk = chunks_[c];
      const auto nodes = latticeNodes(chunk.turned);
      const float* part = parts[c].data() - 4 * static_cast<std::ptrdiff_t>(chunk.firstNode);
      const std::size_t last = std::min(end, chunk.lastUnknown);
      for (std::size_t i = std::max(begin, chunk.firstUnknown); i < last; ++i)
        Colour::Map(&unknowns[4 * i]) +=
            Colour::Map(part + 4 * static_cast<std::ptrdiff_t>(nodes[i]));
    }
  });
}

}  // namespace volute
