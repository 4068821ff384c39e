// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/vdb_facts.hpp"

#include <algorithm>
#include <limits>
#include <map>

#include "volute/io/vdb_place.hpp"

namespace volute {
namespace {

/// What grids of numbers are called by: a function for each kind.
template <class Function>
void withNumbers(const openvdb::GridBase& base, const Function& function) {
  using namespace openvdb;
  const auto take = [&]<class Grid>() {
    if (base.isType<Grid>())
      function(static_cast<const Grid&>(base));
  };
  take.template operator()<FloatGrid>();
  take.template operator()<DoubleGrid>();
  take.template operator()<Vec3SGrid>();
  take.template operator()<Vec3DGrid>();
  take.template operator()<BoolGrid>();
  take.template operator()<Int32Grid>();
  take.template operator()<Int64Grid>();
  take.template operator()<Vec3IGrid>();
}

/// Extremes over active values; NaN where they are no numbers.
class Extremes {
 public:
  /// @param withLeaves  else tiles alone
  void add(const openvdb::GridBase& base, bool withLeaves) {
    withNumbers(base, [&]<class Grid>(const Grid& grid) {
      numbers_ = true;
      auto it = grid.cbeginValueOn();
      if (!withLeaves)
        it.setMaxDepth(Grid::ValueOnCIter::LEAF_DEPTH - 1);
      for (; it; ++it) {
        if constexpr (openvdb::VecTraits<typename Grid::ValueType>::IsVec)
          for (int c = 0; c < 3; ++c) take(static_cast<double>((*it)[c]));
        else
          take(static_cast<double>(*it));
      }
    });
  }

  void put(GridFacts& facts) const {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    facts.least = !numbers_ ? kNone : least_ <= most_ ? least_ : 0;
    facts.most = !numbers_ ? kNone : least_ <= most_ ? most_ : 0;
  }

 private:
  void take(double value) { least_ = std::min(least_, value), most_ = std::max(most_, value); }

  double least_ = std::numeric_limits<double>::infinity(), most_ = -least_;
  bool numbers_ = false;
};

/// Layers of leaves, from below, with what the values in each take [bytes]; empty where a leaf
/// holds its values without memory of their own.
std::map<int, std::uint64_t> leafLayers(const openvdb::GridBase& topology) {
  std::map<int, std::uint64_t> layers;
  withNumbers(topology, [&]<class Grid>(const Grid& grid) {
    using Leaf = typename Grid::TreeType::LeafNodeType;
    if constexpr (!std::is_same_v<typename Grid::ValueType, bool>)
      for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
        layers[leaf->origin().z()] += Leaf::SIZE * sizeof(typename Grid::ValueType);
  });
  return layers;
}

/// All but the range.
/// @param grid  values may be missing, and count as `missing` bytes
GridFacts factsOf(const std::string& name, const openvdb::GridBase& grid, std::uint64_t missing) {
  GridFacts facts;
  name.copy(facts.name, GridFacts::kMaxName);
  grid.valueType().copy(facts.type, GridFacts::kMaxType);
  if (grid.getGridClass() != openvdb::GRID_UNKNOWN)
    openvdb::GridBase::gridClassToString(grid.getGridClass())
        .copy(facts.gridClass, GridFacts::kMaxType);
  facts.box = toIndexBox(grid.evalActiveVoxelBoundingBox());
  LatticeFrame place;
  facts.readable = describeGrid(name, grid).usable;
  const Status placed = readTransform(grid, name, place);
  if (placed)
    facts.voxelSize = place.voxelSize;
  else if (placed.error().code == ErrorCode::kInvalidData)
    putText("its matrix is not finite, or makes it flat", facts.problem, GridFacts::kMaxProblem);
  facts.readable = facts.readable && placed;
  facts.frustum = isFrustum(grid);
  facts.voxels = grid.activeVoxelCount();
  facts.memory = grid.memUsage() + missing;
  return facts;
}

}  // namespace

GridEntry describeGrid(const std::string& name, const openvdb::GridBase& grid) {
  const bool scalar = grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>();
  const bool colour = grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>();
  const bool levelSet = scalar && grid.getGridClass() == openvdb::GRID_LEVEL_SET;
  return {name, levelSet ? std::string(kLevelSet) : std::string(grid.valueType()),
          scalar || colour};
}

void putText(std::string_view text, char* to, std::size_t most) {
  text.substr(0, most).copy(to, most);
}

GridFacts unknownOf(const std::string& name, const std::string& type, std::string_view problem) {
  GridFacts facts;
  name.copy(facts.name, GridFacts::kMaxName);
  type.copy(facts.type, GridFacts::kMaxType);
  facts.least = facts.most = std::numeric_limits<double>::quiet_NaN();
  problem.substr(0, GridFacts::kMaxProblem).copy(facts.problem, GridFacts::kMaxProblem);
  return facts;
}

GridFacts factsIn(VdbFile& file, std::size_t index, std::uint64_t limit) {
  constexpr std::uint64_t kMaxParts = 64;
  Extremes extremes;
  GridFacts facts;
  std::map<int, std::uint64_t> layers;
  openvdb::CoordBBox box;
  std::uint64_t missing = 0;
  if (file.hasTopology(index)) {
    const auto topology = file.readTopology(index);
    layers = leafLayers(*topology);
    for (const auto& [z, bytes] : layers) missing += bytes;
    if (missing > limit) {
      facts = factsOf(file.name(index), *topology, missing);
      extremes.add(*topology, /*withLeaves=*/false);
      box = topology->evalActiveVoxelBoundingBox();
    }
  }
  if (missing <= limit) {
    const auto grid = file.readTree(index);
    facts = factsOf(file.name(index), *grid, 0);
    extremes.add(*grid, /*withLeaves=*/true);
  } else {
    const std::uint64_t most = std::max(limit, missing / kMaxParts);
    for (auto begin = layers.begin(); begin != layers.end() && !box.empty();) {
      auto end = begin;
      std::uint64_t bytes = 0;
      while (end != layers.end() && (end == begin || bytes + end->second <= most))
        bytes += (end++)->second;
      constexpr int kLastInLeaf = 7;
      box.min().z() = begin->first, box.max().z() = std::prev(end)->first + kLastInLeaf;
      extremes.add(*file.readTree(index, &box), /*withLeaves=*/true);
      begin = end;
    }
  }
  extremes.put(facts);
  facts.half = file.grid(index).saveFloatAsHalf();
  return facts;
}

}  // namespace volute
