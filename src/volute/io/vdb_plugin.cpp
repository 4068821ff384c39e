// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "volute/grid/bricks.hpp"
#include "volute/grid/resample.hpp"
#include "volute/io/grid_choice.hpp"
#include "volute/io/lattice.hpp"
#include "volute/io/vdb_facts.hpp"
#include "volute/io/vdb_file.hpp"
#include "volute/io/vdb_grid.hpp"
#include "volute/io/vdb_metadata.hpp"
#include "volute/io/vdb_place.hpp"
#include "volute/io/vdb_writer.hpp"

namespace volute {
namespace {

/// OpenVDB's exceptions as sentences.
template <class Function>
auto guarded(const std::filesystem::path& file, Function&& function) -> decltype(function()) {
  try {
    return function();
  } catch (Refused& refused) {
    return tl::unexpected(std::move(refused.error));
  } catch (const std::ios_base::failure&) {
    return fail(ErrorCode::kTruncated,
                "{}: ends before its data do, or points outside itself; the file is damaged",
                file.string());
  } catch (const openvdb::Exception& error) {
    return fail(ErrorCode::kTruncated, "{}: not a whole OpenVDB file: {}", file.string(),
                error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    return fail(ErrorCode::kIo, "{}: cannot read: {}", file.string(), error.code().message());
  } catch (const std::runtime_error& error) {  // NanoVDB's
    return fail(ErrorCode::kTruncated, "{}: not a whole NanoVDB file: {}", file.string(),
                error.what());
  }
}

/// Of volumes and level sets, the former are meant unless one is named.
std::vector<GridEntry> entriesOf(const VdbFile& file, const std::string& wanted) {
  std::vector<GridEntry> entries;
  for (std::size_t i = 0; i < file.gridCount(); ++i)
    entries.push_back(file.foreignType(i).empty()
                          ? describeGrid(file.name(i), file.grid(i))
                          : GridEntry{file.name(i), file.foreignType(i), false});
  const bool volumes = std::ranges::any_of(
      entries, [](const GridEntry& entry) { return entry.usable && entry.type != kLevelSet; });
  for (GridEntry& entry : entries) {
    if (volumes && wanted.empty() && entry.type == kLevelSet)
      entry.usable = false;
  }
  return entries;
}

/// What is in the grid, as far as it reaches into `box`: voxels and tiles that are active or not
/// the background. Inactive voxels that are no numbers are background, and a background that is
/// none is 0. Values are differences from `offset`.
/// @param topology  the same without values; where only `box` was read, tiles across its border are
/// voxels in `grid`
/// @param counted  whether Bricks::leftOut() is
template <class Grid>
Bricks bricksOf(const Grid& grid, const Grid& topology, const openvdb::CoordBBox& box,
                double offset, bool counted, double& rounding) {
  using Traits = Channels<typename Grid::ValueType>;
  constexpr std::size_t kCount = Traits::kCount;
  using Colour = std::array<float, 3>;
  const auto colourOf = [offset](const typename Grid::ValueType& value) {
    Colour colour{};
    Traits::store(value, colour.data(), offset);
    return colour;
  };
  const auto finite = [](const Colour& colour) {
    return std::ranges::all_of(colour, [](float value) { return std::isfinite(value); });
  };
  Colour background = colourOf(grid.background());
  const bool sound = finite(background);
  for (float& value : background)
    value = std::isfinite(value) ? value : static_cast<float>(0 - offset);
  Bricks all(Traits::kCount, background);
  const auto holds = [&](const Colour& colour, bool active) {
    return active || (finite(colour) && colour != background);
  };
  // Of inactive voxels that are no numbers, beside a background that is one.
  const auto counts = [&](const Colour& colour) { return sound && colour != background; };
  std::uint64_t leftOut = 0;
  const auto originOf = [](const openvdb::Coord& at) -> VoxelIndex {
    return {at.x(), at.y(), at.z()};
  };
  auto tile = topology.cbeginValueAll();
  tile.setMaxDepth(openvdb::Index(decltype(tile)::LEAF_DEPTH - 1));
  for (; tile; ++tile) {
    const Colour colour = colourOf(*tile);
    openvdb::CoordBBox part;
    tile.getBoundingBox(part);
    const bool held = holds(colour, tile.isValueOn());
    openvdb::CoordBBox within = part;
    within.intersect(box);
    if (held)
      leftOut += tile.isValueOn() ? 0 : part.volume() - (within.empty() ? 0 : within.volume());
    else if (counts(colour))
      leftOut += part.volume();
    if (!held || !part.hasOverlap(box))
      continue;
    rounding = std::max(rounding, Traits::rounding(*tile, colour.data(), offset));
    all.addTile({originOf(part.min()), part.max().x() - std::int64_t{part.min().x()} + 1,
                 tile.isValueOn(), colour});
  }
  all.reserve(grid.tree().leafCount(), all.tiles().size());
  for (auto it = grid.tree().cbeginLeaf(); it; ++it) {
    if (&grid != &topology && topology.tree().probeConstLeaf(it->origin()) == nullptr)
      continue;
    const bool inside = it->getNodeBoundingBox().hasOverlap(box);
    if (!inside && !counted)
      continue;
    const auto& mask = it->getValueMask();
    const auto* values = it->buffer().data();
    Bricks::Leaf leaf{originOf(it->origin())};
    // OpenVDB counts voxels of a leaf with z fastest.
    const auto visit = [](const auto& body) {
      for (openvdb::Index n = 0; n < Bricks::kVoxels; ++n)
        body(n, n & 7, (n >> 3 & 7) * 8 + (n >> 6));
    };
    std::uint64_t any = 0;
    visit([&](openvdb::Index n, std::size_t z, openvdb::Index bit) {
      const bool active = mask.isOn(n);
      const Colour colour = colourOf(values[n]);
      const bool held = holds(colour, active);
      leftOut += held ? !active && !box.isInside(it->offsetToGlobalCoord(n)) : counts(colour);
      leaf.active[z] |= static_cast<std::uint64_t>(active) << bit;
      leaf.valued[z] |= static_cast<std::uint64_t>(held) << bit;
      any |= leaf.valued[z];
    });
    if (any == 0 || !inside)
      continue;
    const std::span<float> to = all.addLeaf(leaf);
    visit([&](openvdb::Index n, std::size_t z, openvdb::Index bit) {
      if ((leaf.valued[z] >> bit & 1) == 0)
        return;
      const Colour colour = colourOf(values[n]);
      rounding = std::max(rounding, Traits::rounding(values[n], colour.data(), offset));
      for (std::size_t c = 0; c < kCount; ++c) to[c * Bricks::kVoxels + 64 * z + bit] = colour[c];
    });
  }
  all.sort();
  all.setLeftOut(counted ? leftOut : 0);
  return all;
}

bool hasDoubles(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::DoubleGrid>() || grid.isType<openvdb::Vec3DGrid>();
}

/// Nothing where the grid is of a type that is no volume.
std::optional<Bricks> bricksOfGrid(const openvdb::GridBase& grid, const openvdb::GridBase& topology,
                                   const openvdb::CoordBBox& box, double offset, bool counted,
                                   double& rounding) {
  std::optional<Bricks> bricks;
  const auto take = [&]<class Grid>() {
    if (!bricks && grid.isType<Grid>() && topology.isType<Grid>())
      bricks = bricksOf(static_cast<const Grid&>(grid), static_cast<const Grid&>(topology), box,
                        offset, counted, rounding);
  };
  take.template operator()<openvdb::FloatGrid>();
  take.template operator()<openvdb::DoubleGrid>();
  take.template operator()<openvdb::Vec3SGrid>();
  take.template operator()<openvdb::Vec3DGrid>();
  return bricks;
}

/// Bytes of the bricks of so many leaves.
std::uint64_t brickBytes(std::uint64_t leaves, int channels) {
  return leaves * (sizeof(Bricks::Leaf) +
                   sizeof(float) * Bricks::kVoxels * static_cast<std::uint64_t>(channels));
}

/// The same of a tree as its writer noted its size; 0 where it did not.
std::uint64_t notedBrickBytes(const openvdb::GridBase& grid) {
  const auto noted =
      grid.getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_MEM_BYTES);
  return noted && noted->value() > 0 ? static_cast<std::uint64_t>(noted->value()) * 5 / 4 : 0;
}

/// Of each channel, as the file has it; zeros where the grid is of a type that is no volume.
std::array<double, 3> backgroundOf(const openvdb::GridBase& grid) {
  std::array<double, 3> background{};
  const auto take = [&]<class Grid>() {
    if (!grid.isType<Grid>())
      return;
    const auto& value = static_cast<const Grid&>(grid).background();
    if constexpr (Channels<typename Grid::ValueType>::kCount == 1)
      background[0] = value;
    else
      for (int c = 0; c < 3; ++c) background[static_cast<std::size_t>(c)] = value[c];
  };
  take.template operator()<openvdb::FloatGrid>();
  take.template operator()<openvdb::DoubleGrid>();
  take.template operator()<openvdb::Vec3SGrid>();
  take.template operator()<openvdb::Vec3DGrid>();
  return background;
}

/// What a file says of its up axis and, of the grid, of its values.
void putStatements(const VdbFile& file, std::size_t index, LatticeFrame& frame) {
  if (const auto unit = textEntry(file.grid(index), kUnitKey);
      unit.size() <= LatticeFrame::kMaxUnit)
    putText(unit, frame.unit, LatticeFrame::kMaxUnit);
  for (std::size_t i = 0; frame.up == 0 && i < file.gridCount(); ++i)
    frame.up = statedUp(file.grid(i));
  if (frame.up != 0)
    return;
  const VdbProgram* program = programOf(file.metadata());
  for (std::size_t i = 0; !program && i < file.gridCount(); ++i) program = programOf(file.grid(i));
  if (!program)
    return;
  frame.up = program->up;
  putText(program->name, frame.writer, LatticeFrame::kMaxWriter);
}

Result<LatticeGrid> describeForCache(VdbFile& file, std::size_t index) {
  const openvdb::GridBase& grid = file.grid(index);
  LatticeGrid result;
  GridTraits& traits = result.traits;
  putText(file.name(index), result.frame.grid, LatticeFrame::kMaxName);
  const std::string type =
      file.foreignType(index).empty() ? grid.valueType() : file.foreignType(index);
  putText(type, traits.type, GridTraits::kMaxText);
  if (grid.getGridClass() != openvdb::GRID_UNKNOWN)
    putText(openvdb::GridBase::gridClassToString(grid.getGridClass()), traits.gridClass,
            GridTraits::kMaxText);
  putText(grid.transform().mapType(), traits.map, GridTraits::kMaxText);
  traits.half = grid.saveFloatAsHalf();
  traits.memory = file.bytesOf(index);  // of what is kept as it is
  result.frame.channels =
      grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>() ? 3 : 1;
  if (const auto time = grid.getMetadata<openvdb::DoubleMetadata>(kTimeKey))
    result.frame.time = time->value();
  putStatements(file, index, result.frame);
  if (file.name(index).size() > LatticeFrame::kMaxName) {
    putText("with a name that is too long", traits.problem, GridTraits::kMaxProblem);
    return result;
  }
  if (!grid.isType<openvdb::FloatGrid>() && !grid.isType<openvdb::DoubleGrid>() &&
      !grid.isType<openvdb::Vec3SGrid>() && !grid.isType<openvdb::Vec3DGrid>()) {
    putText(fmt::format("of type {}", type), traits.problem, GridTraits::kMaxProblem);
    return result;
  }
  if (const Status status = readTransform(
          grid, fmt::format("{}, grid '{}'", file.path().string(), file.name(index)), result.frame);
      !status) {
    if (status.error().code != ErrorCode::kUnsupported)
      return tl::unexpected(status.error());
    putText("with a frustum", traits.problem, GridTraits::kMaxProblem);
    return result;
  }
  result.frame.vectors = vectorKindOf(listMetadata(grid));
  const auto tree = file.readTopology(index);
  result.frame.box = toIndexBox(tree->evalActiveVoxelBoundingBox());
  traits.background = backgroundOf(*tree);
  for (double& number : traits.background) number = std::isfinite(number) ? number : 0;
  traits.voxels = tree->activeVoxelCount();
  result.frame.bricks = true;
  result.frame.rounded = hasDoubles(grid);
  result.frame.memory = brickBytes(tree->baseTree().leafCount(), result.frame.channels);
  const auto memory =
      grid.getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_MEM_BYTES);
  traits.memory = memory && memory->value() > 0 ? static_cast<std::uint64_t>(memory->value())
                                                : tree->memUsage();
  result.metadata = listMetadata(grid);
  // That it has no class may be said, too.
  const auto stated = grid.getMetadata<openvdb::StringMetadata>(openvdb::GridBase::META_GRID_CLASS);
  if (stated && grid.getGridClass() == openvdb::GRID_UNKNOWN)
    result.metadata.push_back({openvdb::GridBase::META_GRID_CLASS, "string", stated->value()});
  // A name that reads as if OpenVDB had told it apart from another.
  if (grid.getName() != nameInFile(file.name(index)))
    result.metadata.push_back({openvdb::GridBase::META_GRID_NAME, "string", grid.getName()});
  return result;
}

class VdbReader final : public LatticeReader {
 public:
  VdbReader() { openvdb::initialize(); }

  Result<LatticeFrame> describe(const std::filesystem::path& path, const std::string& wanted,
                                const std::string& usual, bool needBox) override {
    return guarded(path, [&]() -> Result<LatticeFrame> {
      VdbFile file(path);
      const auto entries = entriesOf(file, wanted);
      VOLUTE_ASSIGN(const std::size_t index,
                    chooseGrid(entries, wanted, path.string(), {.usual = usual}));
      const openvdb::GridBase& grid = file.grid(index);
      LatticeFrame frame;
      const std::string name = file.name(index);
      name.copy(frame.grid, LatticeFrame::kMaxName);
      otherGrids(entries, index, LatticeFrame::kMaxName).copy(frame.others, LatticeFrame::kMaxName);
      std::string leftOut;
      for (const GridEntry& entry : entries) {
        if (wanted.empty() && entry.type == kLevelSet && !entry.usable)
          leftOut += fmt::format("{}'{}' (level set)", leftOut.empty() ? "" : ", ", entry.name);
      }
      leftOut.copy(frame.leftOut, LatticeFrame::kMaxName);
      frame.channels =
          grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>() ? 3 : 1;
      frame.vectors = vectorKindOf(listMetadata(grid));
      const std::string where = fmt::format("{}, grid '{}'", path.string(), name);
      const bool sampled = frusta_ && isFrustum(grid);
      if (sampled)
        VOLUTE_TRY(readSampledPlace(grid, *file.readTopology(index), *frusta_, where, frame));
      else
        VOLUTE_TRY(readTransform(grid, where, frame));
      if (const auto time = grid.getMetadata<openvdb::DoubleMetadata>(kTimeKey))
        frame.time = time->value();
      putStatements(file, index, frame);
      frame.levelSet = entries[index].type == kLevelSet;
      if (grid.getGridClass() != openvdb::GRID_UNKNOWN)
        putText(openvdb::GridBase::gridClassToString(grid.getGridClass()), frame.gridClass,
                LatticeFrame::kMaxWriter);
      frame.bricks = true;
      frame.rounded = hasDoubles(grid);
      if (sampled)
        return frame;
      frame.memory = notedBrickBytes(grid);
      const auto noted = notedBox(grid);
      if (noted)
        frame.box = *noted;
      if ((!noted && needBox) || frame.memory == 0) {
        const auto tree = file.readTopology(index);
        if (!noted)
          frame.box = toIndexBox(tree->evalActiveVoxelBoundingBox());
        frame.memory = brickBytes(tree->baseTree().leafCount(), frame.channels);
      }
      return frame;
    });
  }

  Result<std::vector<GridFacts>> list(const std::filesystem::path& path,
                                      std::uint64_t limit) override {
    return guarded(path, [&]() -> Result<std::vector<GridFacts>> {
      VdbFile file(path);
      std::vector<GridFacts> grids;
      for (std::size_t i = 0; i < file.gridCount(); ++i) {
        // What OpenVDB does not know in one grid is no damage of the others.
        try {
          grids.push_back(factsIn(file, i, limit));
        } catch (const openvdb::LookupError& error) {
          const std::string& type = file.foreignType(i);
          grids.push_back(unknownOf(file.name(i), type.empty() ? file.grid(i).valueType() : type,
                                    error.what()));
        }
      }
      return grids;
    });
  }

  Result<LatticeCache> describeAll(const std::filesystem::path& path) override {
    return guarded(path, [&]() -> Result<LatticeCache> {
      VdbFile file(path);
      LatticeCache cache;
      cache.metadata = listMetadata(file.metadata());
      for (std::size_t i = 0; i < file.gridCount(); ++i) {
        VOLUTE_ASSIGN(auto grid, describeForCache(file, i));
        cache.grids.push_back(std::move(grid));
      }
      return cache;
    });
  }

  Result<std::string> keep(const std::filesystem::path& path, std::size_t grid,
                           std::uint64_t limit) override {
    return guarded(path, [&]() -> Result<std::string> {
      VdbFile file(path);
      if (grid >= file.gridCount())
        return fail(ErrorCode::kInvalidData, "{}: has {} grids now", path.string(),
                    file.gridCount());
      const auto tooLarge = [&](std::uint64_t bytes) {
        return fail(ErrorCode::kTooLarge,
                    "{}: grid '{}' holds no volume and takes {} MiB as it is, more than the {} MiB "
                    "of memory allowed; allow more, or leave out what holds no volume",
                    path.string(), file.name(grid), bytes >> 20, limit >> 20);
      };
      if (file.bytesOf(grid) > limit)
        return tooLarge(file.bytesOf(grid));
      std::string bytes = file.copyOf(grid);
      if (bytes.size() > limit)
        return tooLarge(bytes.size());
      return bytes;
    });
  }

  Status read(const std::filesystem::path& path, const std::string& wanted, const IndexBox& whole,
              const IndexBox& box, bool crop, std::span<float> values, double& rounding) override {
    VOLUTE_ASSIGN(const Bricks bricks, readBricks(path, wanted, whole, box, crop, rounding));
    bricks.toDense(box, values);
    return {};
  }

  bool hasBricks() const override { return true; }

  Result<Bricks> readBricks(const std::filesystem::path& path, const std::string& wanted,
                            const IndexBox& whole, const IndexBox& box, bool crop,
                            double& rounding) override {
    return guarded(path, [&]() -> Result<Bricks> {
      VdbFile file(path);
      const auto entries = entriesOf(file, wanted);
      VOLUTE_ASSIGN(const std::size_t index, chooseGrid(entries, wanted, path.string()));
      const auto toCoord = [](const VoxelIndex& at, int less) {
        return openvdb::Coord(static_cast<int>(at[0] - less), static_cast<int>(at[1] - less),
                              static_cast<int>(at[2] - less));
      };
      if (frusta_ && isFrustum(file.grid(index))) {
        const auto grid = file.readTree(index);
        const auto bricks =
            bricksOfGrid(*grid, *grid, openvdb::CoordBBox::inf(), offset_, false, rounding);
        if (!bricks)
          return changedType(path, wanted);
        // The process has a limit of its own.
        return resampled(*bricks,
                         FrustumLattices(file.grid(index).transform(), frusta_->indexToWorld), box,
                         frusta_->basis, std::numeric_limits<std::uint64_t>::max());
      }
      const openvdb::CoordBBox part(toCoord(box.begin, 0), toCoord(box.end, 1));
      const bool all = box.begin == whole.begin && box.end == whole.end;
      const auto grid = file.readTree(index, all ? nullptr : &part);
      const auto topology = all ? grid : file.readTopology(index);
      if (!crop && box.begin == whole.begin &&
          !whole.contains(toIndexBox(topology->evalActiveVoxelBoundingBox()))) {
        return fail(
            ErrorCode::kInvalidData, Hint::set("bounds"),
            "{}: grid '{}' has voxels outside the box that its metadata state; the file may be "
            "damaged",
            path.string(), wanted);
      }
      // What is cropped is left out on purpose, and of a part the rest is in others.
      auto bricks = bricksOfGrid(*grid, *topology, part, offset_, all && !crop, rounding);
      if (!bricks)
        return changedType(path, wanted);
      lostBackground_ = 0;
      for (const double number : backgroundOf(*grid))
        lostBackground_ = std::isfinite(number) ? lostBackground_ : number;
      return *std::move(bricks);
    });
  }

  double lostBackground() const override { return lostBackground_; }

  void takeOffset(double offset) override { offset_ = offset; }

  void sampleFrusta(const FrustumSampling* how) override {
    frusta_ = how ? std::optional(*how) : std::nullopt;
  }

 private:
  static tl::unexpected<Error> changedType(const std::filesystem::path& path,
                                           const std::string& grid) {
    return fail(ErrorCode::kUnsupported, "{}: grid '{}' changed its type", path.string(), grid);
  }

  std::optional<FrustumSampling> frusta_;
  double offset_ = 0, lostBackground_ = 0;
};

}  // namespace
}  // namespace volute

extern "C" const volute::LatticePlugin* voluteVdbPlugin() {
  using namespace volute;
  static constexpr LatticePlugin kPlugin{
      []() -> std::unique_ptr<LatticeReader> { return std::make_unique<VdbReader>(); },
      makeVdbWriter, nullptr};
  return &kPlugin;
}
