// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/vdb_writer.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>

#include "volute/base/file_name.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/io/nano_grids.hpp"
#include "volute/io/vdb_file.hpp"
#include "volute/io/vdb_grid.hpp"
#include "volute/io/vdb_metadata.hpp"

namespace volute {
namespace {

/// Puts what is in a frame into an empty grid, as it was.
/// @param begin  index of the volume's first voxel
/// @param offset  what values are differences from
template <class Grid>
void putBricks(const Bricks& bricks, const std::array<int, 3>& begin, double offset, Grid& grid) {
  using Value = typename Grid::ValueType;
  using Leaf = typename Grid::TreeType::LeafNodeType;
  const auto valueOf = [offset](const float* from, std::size_t stride) {
    const auto number = [offset](float value) {
      return static_cast<typename openvdb::VecTraits<Value>::ElementType>(offset + value);
    };
    if constexpr (Channels<Value>::kCount == 3) {
      return Value(number(from[0]), number(from[stride]), number(from[2 * stride]));
    } else {
      return number(*from);
    }
  };
  const auto coordOf = [&](const VoxelIndex& at) {
    return openvdb::Coord(static_cast<int>(at[0]) + begin[0], static_cast<int>(at[1]) + begin[1],
                          static_cast<int>(at[2]) + begin[2]);
  };
  auto& tree = grid.tree();
  for (const Bricks::Tile& tile : bricks.tiles()) {
    const openvdb::Coord at = coordOf(tile.origin);
    const Value value = valueOf(tile.value.data(), 1);
    // Nodes of the tree, from the smallest.
    constexpr std::array<std::int64_t, 3> kSides{8, 128, 4096};
    const auto level = std::ranges::find(kSides, tile.side) - kSides.begin();
    const int mask = static_cast<int>(tile.side - 1);
    const bool aligned = ((at.x() | at.y() | at.z()) & mask) == 0;
    if (level < static_cast<std::ptrdiff_t>(kSides.size()) && aligned)
      tree.addTile(static_cast<openvdb::Index>(level + 1), at, value, tile.active);
    else
      tree.fill(openvdb::CoordBBox(at, at.offsetBy(mask)), value, tile.active);
  }
  auto accessor = grid.getAccessor();
  for (std::size_t i = 0; i < bricks.leaves().size(); ++i) {
    const Bricks::Leaf& leaf = bricks.leaves()[i];
    const std::span<const float> values = bricks.values(i);
    const openvdb::Coord first = coordOf(leaf.origin);
    Leaf* to = nullptr;
    openvdb::Coord toOrigin;
    for (std::size_t z = 0; z < leaf.valued.size(); ++z) {
      for (std::uint64_t left = leaf.valued[z]; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        const openvdb::Coord at = first.offsetBy(bit % 8, bit / 8, static_cast<int>(z));
        if (to == nullptr || (at & ~(Bricks::kSide - 1)) != toOrigin) {
          to = accessor.touchLeaf(at);
          toOrigin = at & ~(Bricks::kSide - 1);
        }
        const openvdb::Index offset = Leaf::coordToOffset(at);
        to->setValueOnly(offset,
                         valueOf(&values[64 * z + static_cast<std::size_t>(bit)], Bricks::kVoxels));
        to->setActiveState(offset, (leaf.active[z] >> bit & 1) != 0);
      }
    }
  }
}

/// A grid that is empty but for its background.
template <class Grid>
typename Grid::Ptr gridOver(const GridDescription& description) {
  using Value = typename Grid::ValueType;
  const auto& b = description.background;
  if constexpr (Channels<Value>::kCount == 3) {
    using Scalar = typename Value::ValueType;
    return emptyGrid<Grid>(
        Value(static_cast<Scalar>(b[0]), static_cast<Scalar>(b[1]), static_cast<Scalar>(b[2])));
  } else {
    return emptyGrid<Grid>(static_cast<Value>(b[0]));
  }
}

template <class Grid>
openvdb::GridBase::Ptr makeGrid(const Bricks& bricks, double offset) {
  GridDescription description;
  for (std::size_t c = 0; c < 3; ++c) description.background[c] = offset + bricks.background()[c];
  const auto grid = gridOver<Grid>(description);
  putBricks(bricks, {0, 0, 0}, offset, *grid);
  return grid;
}

openvdb::math::Transform::Ptr makeTransform(const VolumeInfo& info) {
  const Vec3 size = info.voxelSize();
  const Vec3 origin = info.bounds.min + 0.5 * size;
  const openvdb::Vec3d scale(size.x(), size.y(), size.z());
  const openvdb::Vec3d shift(origin.x(), origin.y(), origin.z());
  const bool uniform = std::abs(size.x() - size.y()) <= 1e-12 * size.x() &&
                       std::abs(size.x() - size.z()) <= 1e-12 * size.x();
  using openvdb::math::MapBase;
  const MapBase::Ptr map =
      uniform ? MapBase::Ptr(new openvdb::math::UniformScaleTranslateMap(size.x(), shift))
              : MapBase::Ptr(new openvdb::math::ScaleTranslateMap(scale, shift));
  return std::make_shared<openvdb::math::Transform>(map);
}

using Index3 = std::array<int, 3>;

template <class Grid>
openvdb::GridBase::Ptr makeCacheGrid(const GridFrame& frame, const Index3& begin) {
  const auto grid = gridOver<Grid>(*frame.description);
  putBricks(*frame.bricks, begin, frame.offset, *grid);
  return grid;
}

/// As a cache has it in this frame; where its bounds say it where the cache says nothing.
openvdb::math::Transform::Ptr makeCacheTransform(const GridFrame& frame) {
  using namespace openvdb::math;
  const GridDescription& grid = *frame.description;
  auto size = grid.voxelSize;
  auto place = grid.origin;
  if (!grid.matrices.empty() && !grid.map.empty()) {
    const GridMatrix& m = grid.matrices[static_cast<std::size_t>(frame.frame)];
    const Mat4d matrix(m[0], m[4], m[8], 0., m[1], m[5], m[9], 0., m[2], m[6], m[10], 0., m[3],
                       m[7], m[11], 1.);
    size = {m[0], m[5], m[10]}, place = {m[3], m[7], m[11]};
    if (m != alongAxes(size, place) || std::ranges::min(size) <= 0) {
      MapBase::Ptr map = std::make_shared<AffineMap>(matrix);
      if (grid.map == UnitaryMap::mapType() && isUnitary(matrix.getMat3()))
        map = std::make_shared<UnitaryMap>(matrix.getMat3());
      return std::make_shared<Transform>(map);
    }
  }
  bool sound = true;
  for (int axis = 0; axis < 3; ++axis)
    sound = sound && size[axis] > 0 && std::isfinite(size[axis]) && std::isfinite(place[axis]);
  if (!sound || grid.map.empty())
    return makeTransform(*frame.info);
  openvdb::Vec3d scale(size[0], size[1], size[2]), origin(place[0], place[1], place[2]);
  if (!grid.shifts.empty()) {
    const auto& shift = grid.shifts[static_cast<std::size_t>(frame.frame)];
    for (int axis = 0; axis < 3; ++axis)
      origin[axis] += static_cast<double>(shift[axis]) * scale[axis];
  }
  const bool even = scale[0] == scale[1] && scale[0] == scale[2];
  MapBase::Ptr map;
  // Of a domain that moves, the first frame alone may lie at the origin.
  const bool cubes = grid.map == UniformScaleMap::mapType();
  const bool boxes = grid.map == ScaleMap::mapType();
  if (cubes && even && origin.isZero())
    map = std::make_shared<UniformScaleMap>(scale[0]);
  else if (boxes && origin.isZero())
    map = std::make_shared<ScaleMap>(scale);
  else if ((cubes || grid.map == UniformScaleTranslateMap::mapType()) && even)
    map = std::make_shared<UniformScaleTranslateMap>(scale[0], origin);
  else if (boxes || grid.map == ScaleTranslateMap::mapType())
    map = std::make_shared<ScaleTranslateMap>(scale, origin);
  else if (grid.map == TranslationMap::mapType() && scale == openvdb::Vec3d(1, 1, 1))
    map = std::make_shared<TranslationMap>(origin);
  else
    map = std::make_shared<AffineMap>(Mat4d(scale[0], 0., 0., 0., 0., scale[1], 0., 0., 0., 0.,
                                            scale[2], 0., origin[0], origin[1], origin[2], 1.));
  const auto transform = std::make_shared<Transform>(map);
  // OpenVDB leaves out a translation by nothing when it makes one, but not when it reads one.
  if (origin.isZero() && grid.map.ends_with("ScaleTranslateMap"))
    transform->postTranslate(origin);
  return transform;
}

/// The index of the first voxel in this frame; an error where OpenVDB cannot count so far.
Result<Index3> beginOf(const GridFrame& frame, const std::string& target) {
  constexpr std::int64_t kFarthest = 1'000'000'000;
  const GridDescription& grid = *frame.description;
  Index3 begin{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t shift =
        grid.shifts.empty() ? 0 : grid.shifts[static_cast<std::size_t>(frame.frame)][axis];
    const std::int64_t first = grid.map.empty() ? 0 : grid.begin[axis] - shift;
    if (first < -kFarthest || first > kFarthest) {
      return fail(ErrorCode::kInvalidData,
                  "{}: grid '{}' begins at voxel {}, too far to be written", target,
                  frame.info->name, first);
    }
    begin[axis] = static_cast<int>(first);
  }
  return begin;
}

/// Where frame numbers alone would give other times to any frame, or the file stated one: files of
/// which some say no time have none.
void putTime(const VolumeInfo& info, int frame, openvdb::GridBase& grid) {
  VolumeInfo numbered = info;
  numbered.times.clear();
  numbered.fillDefaults();
  const bool stated = grid.getMetadata<openvdb::DoubleMetadata>(kTimeKey) != nullptr;
  if (!stated && info.times == numbered.times)
    return;
  grid.removeMeta(kTimeKey);
  grid.insertMeta(kTimeKey, openvdb::DoubleMetadata(info.times[static_cast<std::size_t>(frame)]));
}

/// The unit of the values, and the up axis where it is not that of the program that the file names.
void putStatements(const VolumeInfo& info, const VdbProgram* program, openvdb::GridBase& grid) {
  if (!info.unit.empty() && info.unit.size() <= LatticeFrame::kMaxUnit)
    grid.insertMeta(kUnitKey, openvdb::StringMetadata(info.unit));
  const char stated = statedUp(grid);
  if (info.up != 0 && info.up != (stated ? stated : program ? program->up : 0))
    grid.insertMeta(kUpKey, openvdb::StringMetadata(std::string(1, info.up)));
}

/// That which metadata of a file and of its grids name.
const VdbProgram* programOf(const openvdb::MetaMap& ofFile, std::span<const GridFrame> frames) {
  const VdbProgram* program = volute::programOf(ofFile);
  for (const GridFrame& frame : frames) {
    const MetadataList* const own =
        frame.description ? frame.description->metadata.at(frame.frame) : nullptr;
    openvdb::MetaMap ofGrid;
    if (own && !program)
      putMetadata(*own, ofGrid);
    program = program ? program : volute::programOf(ofGrid);
  }
  return program;
}

/// A grid of a frame of a cache.
/// @param program  that the file names; null: none
Result<openvdb::GridBase::Ptr> cacheGrid(const GridFrame& frame, const std::string& target,
                                         const VdbProgram* program) {
  const GridDescription& description = *frame.description;
  VOLUTE_ASSIGN(const Index3 begin, beginOf(frame, target));
  const MetadataList* const own = description.metadata.at(frame.frame);
  const auto said = [own](const char* name, const std::string& otherwise) {
    const GridMetadata* const entry = own ? findEntry(*own, name) : nullptr;
    return entry ? entry->value : otherwise;
  };
  const bool vectors = frame.info->channels == 3;
  const bool doubles = said(kTypeEntry, description.type) == (vectors ? "vec3d" : "double");
  const auto grid = vectors   ? doubles ? makeCacheGrid<openvdb::Vec3DGrid>(frame, begin)
                                        : makeCacheGrid<openvdb::Vec3SGrid>(frame, begin)
                      : doubles ? makeCacheGrid<openvdb::DoubleGrid>(frame, begin)
                              : makeCacheGrid<openvdb::FloatGrid>(frame, begin);
  if (own)
    putMetadata(*own, *grid);
  putTime(*frame.info, frame.frame, *grid);
  putStatements(*frame.info, program, *grid);
  const std::string plainName = nameInFile(frame.info->name);
  const std::string name = said(openvdb::GridBase::META_GRID_NAME, plainName);
  grid->setName(frame.info->name.starts_with(name) ? name : plainName);
  const std::string kind = said(openvdb::GridBase::META_GRID_CLASS, description.gridClass);
  if (!kind.empty())
    grid->setGridClass(openvdb::GridBase::stringToGridClass(kind));
  const std::string half =
      said(openvdb::GridBase::META_SAVE_HALF_FLOAT, std::string(1, description.half ? 1 : 0));
  if (grid->saveFloatAsHalf() != (half == std::string(1, 1)))
    grid->setSaveFloatAsHalf(half == std::string(1, 1));
  grid->setTransform(makeCacheTransform(frame));
  return grid;
}

class VdbWriter final : public LatticeWriter {
 public:
  explicit VdbWriter(const LatticeWriterOptions& options) : options_(options) {
    openvdb::initialize();
  }

  Status write(const std::filesystem::path& temporary, const std::filesystem::path& target,
               const VolumeInfo& info, int frame, std::span<const float> values) override {
    std::array<float, 3> zero{};
    zero.fill(static_cast<float>(-options_.offset));
    return writeBricks(temporary, target, info, frame, Bricks::fromDense(info, values, zero));
  }

  bool takesBricks() const override { return true; }

  Status writeBricks(const std::filesystem::path& temporary, const std::filesystem::path& target,
                     const VolumeInfo& info, int frame, const Bricks& bricks) override {
    return written(temporary, target, [&](std::ofstream& stream) -> Status {
      const double offset = options_.offset;
      const bool doubles = offset != 0, vectors = info.channels == 3;
      const auto grid = vectors   ? doubles ? makeGrid<openvdb::Vec3DGrid>(bricks, offset)
                                            : makeGrid<openvdb::Vec3SGrid>(bricks, offset)
                          : doubles ? makeGrid<openvdb::DoubleGrid>(bricks, offset)
                                  : makeGrid<openvdb::FloatGrid>(bricks, offset);
      grid->setName(info.name);
      // OpenVDB does not zip fog volumes.
      grid->setGridClass(options_.zip ? openvdb::GRID_UNKNOWN : openvdb::GRID_FOG_VOLUME);
      grid->setTransform(makeTransform(info));
      grid->setSaveFloatAsHalf(options_.half);
      grid->insertMeta(kTimeKey, openvdb::DoubleMetadata(info.times[frame]));
      putStatements(info, nullptr, *grid);
      if (extensionOf(target) == ".nvdb") {
        writeNanoGrids(stream, {grid});
        return {};
      }
      VdbOutput(packing()).writeTo(stream, grid);
      overwriteIdentifier(stream, bricks.checksum(), info.frameNumbers[frame]);
      return {};
    });
  }

  Status writeGrids(const std::filesystem::path& temporary, const std::filesystem::path& target,
                    std::span<const GridFrame> frames, const MetadataList* metadata) override {
    return written(temporary, target, [&](std::ofstream& stream) -> Status {
      openvdb::MetaMap ofFile;
      if (metadata)
        putMetadata(*metadata, ofFile);
      const VdbProgram* const program = programOf(ofFile, frames);
      if (extensionOf(target) == ".nvdb") {
        std::vector<openvdb::GridBase::Ptr> grids;
        for (const GridFrame& frame : frames) {
          if (frame.kept)
            return fail(ErrorCode::kUnsupported, "{}: takes no grids as their bytes",
                        target.string());
          VOLUTE_ASSIGN(const auto grid, cacheGrid(frame, target.string(), program));
          grids.push_back(grid);
        }
        writeNanoGrids(stream, grids);
        return {};
      }
      const VdbOutput output(packing());
      output.begin(stream, ofFile, frames.size());
      std::uint32_t content = 0;
      int number = 0;
      for (const GridFrame& frame : frames) {
        if (frame.kept) {
          VOLUTE_TRY(VdbOutput::add(stream, *frame.kept, target.string(), content));
          continue;
        }
        VOLUTE_ASSIGN(const auto grid, cacheGrid(frame, target.string(), program));
        output.add(stream, uniqueNameOf(frame.info->name, grid->getName()), grid);
        content ^= frame.bricks->checksum();
        number = frame.info->frameNumbers[static_cast<std::size_t>(frame.frame)];
      }
      overwriteIdentifier(stream, content, number);
      return {};
    });
  }

 private:
  VdbOutput::Packing packing() const {
    return options_.zip ? VdbOutput::Packing::kZip : VdbOutput::Packing::kUsual;
  }

  /// Calls write(stream) with the file; what OpenVDB or the stream throws becomes an error.
  template <class Write>
  static Status written(const std::filesystem::path& temporary, const std::filesystem::path& target,
                        Write&& write) {
    try {
      std::ofstream stream;
      stream.exceptions(std::ios::badbit | std::ios::failbit);
      stream.open(temporary, std::ios::binary);
      VOLUTE_TRY(write(stream));
      stream.close();
    } catch (const std::ios_base::failure&) {
      return fail(ErrorCode::kIo, "{}: cannot write: {}", target.string(), std::strerror(errno));
    } catch (const std::exception& error) {
      return fail(ErrorCode::kIo, "{}: cannot write: {}", target.string(), error.what());
    }
    return {};
  }

  LatticeWriterOptions options_;
};

}  // namespace

std::unique_ptr<LatticeWriter> makeVdbWriter(const LatticeWriterOptions& options) {
  return std::make_unique<VdbWriter>(options);
}

}  // namespace volute
