// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// The one translation unit that includes OpenVDB (it takes minutes to compile).
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>

#include "volute/base/checksum.hpp"
#include "volute/io/grid_choice.hpp"
#include "volute/io/lattice.hpp"

namespace volute {
namespace {

constexpr const char* kTimeKey = "volute:time";

/// An OpenVDB file over a stream that throws at every short read, which OpenVDB's own File does not
/// notice.
class VdbFile final : public openvdb::io::Archive {
 public:
  explicit VdbFile(const std::filesystem::path& path) {
    stream_.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
    stream_.open(path, std::ios::binary);
    const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path));
    openvdb::io::setStreamMetadataPtr(stream_, metadata_, /*transfer=*/false);
    readHeader(stream_);
    setFormatVersion(stream_);
    setLibraryVersion(stream_);
    setDataCompression(stream_);
    openvdb::MetaMap().readMeta(stream_);
    if (!inputHasGridOffsets()) {
      OPENVDB_THROW(openvdb::IoError, "it has no table of its grids (it was written as a stream)");
    }
    const std::int32_t count = readGridCount(stream_);
    for (std::int32_t i = 0; i < count; ++i) {
      auto& entry = grids_.emplace_back();
      entry.grid = entry.descriptor.read(stream_);
      if (entry.descriptor.getEndPos() > size || entry.descriptor.getGridPos() < 0) {
        OPENVDB_THROW(openvdb::IoError, "it ends before its grids do");
      }
      entry.descriptor.seekToEnd(stream_);
    }
    for (auto& entry : grids_) readDescription(entry);
  }

  std::size_t gridCount() const { return grids_.size(); }

  std::string name(std::size_t index) const {
    return openvdb::io::GridDescriptor::nameAsString(grids_[index].descriptor.uniqueName());
  }

  /// Metadata and transform are read, the tree is empty.
  const openvdb::GridBase& grid(std::size_t index) const { return *grids_[index].grid; }

  openvdb::GridBase::Ptr readTree(std::size_t index) {
    const auto& entry = grids_[index];
    if (entry.descriptor.isInstance()) {
      const auto parent = std::ranges::find(grids_, entry.descriptor.instanceParentName(),
                                            [](auto& e) { return e.descriptor.uniqueName(); });
      if (parent == grids_.end() || parent->descriptor.isInstance()) {
        OPENVDB_THROW(openvdb::IoError, "the grid that shares its voxels is missing");
      }
      auto grid = entry.grid->copyGrid();
      grid->setTree(readTree(parent - grids_.begin())->baseTreePtr());
      return grid;
    }
    auto grid = openvdb::GridBase::createGrid(entry.descriptor.gridType());
    entry.descriptor.seekToGrid(stream_);
    readGrid(grid, entry.descriptor, stream_);
    if (stream_.tellg() != entry.descriptor.getEndPos()) {
      OPENVDB_THROW(openvdb::IoError, "a grid does not end where the file says");
    }
    return grid;
  }

 private:
  struct Entry {
    openvdb::io::GridDescriptor descriptor;
    openvdb::GridBase::Ptr grid;
  };

  void readDescription(Entry& entry) {
    entry.descriptor.seekToGrid(stream_);
    readGridCompression(stream_);
    entry.grid->readMeta(stream_);
    entry.grid->readTransform(stream_);
  }

  // The stream keeps the address of this pointer.
  openvdb::io::StreamMetadata::Ptr metadata_ = std::make_shared<openvdb::io::StreamMetadata>();
  std::ifstream stream_;
  std::vector<Entry> grids_;
};

/// Writes to a stream of ours, so that a full disk shows.
class VdbOutput final : public openvdb::io::Archive {
 public:
  explicit VdbOutput(bool zip) {
    if (zip)
      setCompression(openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
  }

  void writeTo(std::ostream& stream, const openvdb::GridBase::Ptr& grid) const {
    write(stream, openvdb::GridPtrVec{grid}, /*seekable=*/true);
  }
};

/// OpenVDB's exceptions as sentences.
template <class Function>
auto guarded(const std::filesystem::path& file, Function&& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::ios_base::failure&) {
    return fail(ErrorCode::kTruncated,
                "{}: ends before its data do, or points outside itself; the file is damaged",
                file.string());
  } catch (const openvdb::Exception& error) {
    return fail(ErrorCode::kInvalidData, "{}: not a whole OpenVDB file: {}", file.string(),
                error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    return fail(ErrorCode::kIo, "{}: cannot read: {}", file.string(), error.code().message());
  }
}

GridEntry describeGrid(const std::string& name, const openvdb::GridBase& grid) {
  const bool scalar = grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>();
  const bool colour = grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>();
  const bool levelSet = scalar && grid.getGridClass() == openvdb::GRID_LEVEL_SET;
  return {name, levelSet ? std::string("level set") : std::string(grid.valueType()),
          (scalar || colour) && !levelSet};
}

std::vector<GridEntry> entriesOf(const VdbFile& file) {
  std::vector<GridEntry> entries;
  for (std::size_t i = 0; i < file.gridCount(); ++i)
    entries.push_back(describeGrid(file.name(i), file.grid(i)));
  return entries;
}

/// Fills voxelSize and origin; only scaling and translation along the axes will do.
Status readTransform(const openvdb::GridBase& grid, const std::string& where, LatticeFrame& frame) {
  const auto& transform = grid.transform();
  if (!transform.isLinear()) {
    return fail(ErrorCode::kUnsupported,
                "{}: the grid has a frustum transform; resample it to a regular grid", where);
  }
  // OpenVDB multiplies row vectors: (i, j, k, 1) * matrix.
  const openvdb::Mat4R matrix = transform.baseMap()->getAffineMap()->getMat4();
  for (int row = 0; row < 3; ++row) {
    frame.voxelSize[row] = matrix(row, row);
    frame.origin[row] = matrix(3, row);
    if (!(matrix(row, row) > 0) || !std::isfinite(matrix(row, row)) ||
        !std::isfinite(matrix(3, row))) {
      return fail(ErrorCode::kUnsupported,
                  "{}: the grid's transform turns or mirrors axis {}; expected voxels along the "
                  "axes with a positive size",
                  where, "xyz"[row]);
    }
    for (int column = 0; column < 3; ++column) {
      if (row != column && !(std::abs(matrix(row, column)) <= 1e-6 * matrix(row, row))) {
        return fail(
            ErrorCode::kUnsupported,
            "{}: the grid's transform rotates or shears; resample it to a grid along the axes",
            where);
      }
    }
  }
  return {};
}

IndexBox toIndexBox(const openvdb::CoordBBox& box) {
  IndexBox result;
  if (box.empty())
    return result;
  for (int axis = 0; axis < 3; ++axis) {
    result.begin[axis] = box.min()[axis];
    result.end[axis] = std::int64_t{box.max()[axis]} + 1;
  }
  return result;
}

/// The box of active voxels as the writer noted it. Believed when it can hold the noted number of
/// voxels; whatever lies outside it is found when the values are read.
std::optional<IndexBox> notedBox(const openvdb::GridBase& grid) {
  const auto min = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
  const auto max = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
  const auto count =
      grid.getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_VOXEL_COUNT);
  if (!min || !max || !count)
    return std::nullopt;
  const IndexBox box = toIndexBox({openvdb::Coord(min->value()), openvdb::Coord(max->value())});
  const double voxels = box.empty() ? 0 : 1.0 * box.size(0) * box.size(1) * box.size(2);
  const auto active = static_cast<double>(count->value());
  if (active < 0 || active > voxels || (active == 0) != box.empty())
    return std::nullopt;
  return box;
}

template <class Value>
struct Channels {
  static constexpr int kCount = 1;

  static void store(const Value& value, float* to) { *to = static_cast<float>(value); }
};

template <class Scalar>
struct Channels<openvdb::math::Vec3<Scalar>> {
  static constexpr int kCount = 3;

  static void store(const openvdb::math::Vec3<Scalar>& value, float* to) {
    for (int c = 0; c < 3; ++c) to[c] = static_cast<float>(value[c]);
  }
};

/// Active voxels and tiles of the grid into the dense array over `box`; the background everywhere
/// else.
template <class Grid>
void fillDense(const Grid& grid, const openvdb::CoordBBox& box, std::span<float> values) {
  using Traits = Channels<typename Grid::ValueType>;
  constexpr int kCount = Traits::kCount;
  float background[kCount];
  Traits::store(grid.background(), background);
  for (float& value : background) value = std::isfinite(value) ? value : 0.0f;
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = background[i % kCount];

  const auto size = box.dim();
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    openvdb::CoordBBox part;
    it.getBoundingBox(part);
    part.intersect(box);
    if (part.empty())
      continue;
    float value[kCount];
    Traits::store(*it, value);
    for (int z = part.min().z(); z <= part.max().z(); ++z) {
      for (int y = part.min().y(); y <= part.max().y(); ++y) {
        const std::size_t row = std::size_t(z - box.min().z()) * size.y() + (y - box.min().y());
        float* to = &values[(row * size.x() + (part.min().x() - box.min().x())) * kCount];
        for (int x = part.min().x(); x <= part.max().x(); ++x) to = std::copy_n(value, kCount, to);
      }
    }
  }
}

template <class Grid>
bool fillIfType(const openvdb::GridBase& grid, const openvdb::CoordBBox& box,
                std::span<float> values) {
  if (!grid.isType<Grid>())
    return false;
  fillDense(static_cast<const Grid&>(grid), box, values);
  return true;
}

/// Extremes over the active values of what has numbers.
template <class Grid>
bool addRange(const openvdb::GridBase& base, GridFacts& facts) {
  if (!base.isType<Grid>())
    return false;
  using Traits = Channels<typename Grid::ValueType>;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (auto it = static_cast<const Grid&>(base).cbeginValueOn(); it; ++it) {
    float values[Traits::kCount];
    Traits::store(*it, values);
    for (const float value : values)
      least = std::min<double>(least, value), most = std::max<double>(most, value);
  }
  facts.least = least <= most ? least : 0, facts.most = least <= most ? most : 0;
  return true;
}

GridFacts factsOf(const std::string& name, const openvdb::GridBase& grid) {
  GridFacts facts;
  name.copy(facts.name, GridFacts::kMaxName);
  grid.valueType().copy(facts.type, GridFacts::kMaxType);
  if (grid.getGridClass() != openvdb::GRID_UNKNOWN)
    openvdb::GridBase::gridClassToString(grid.getGridClass()).copy(facts.gridClass, GridFacts::kMaxType);
  facts.box = toIndexBox(grid.evalActiveVoxelBoundingBox());
  LatticeFrame place;
  if (readTransform(grid, name, place))
    facts.voxelSize = place.voxelSize;
  facts.voxels = grid.activeVoxelCount();
  facts.memory = grid.memUsage();
  facts.half = grid.saveFloatAsHalf();
  facts.readable = describeGrid(name, grid).usable;
  if (!addRange<openvdb::FloatGrid>(grid, facts) && !addRange<openvdb::DoubleGrid>(grid, facts) &&
      !addRange<openvdb::Vec3SGrid>(grid, facts) && !addRange<openvdb::Vec3DGrid>(grid, facts))
    facts.least = facts.most = std::numeric_limits<double>::quiet_NaN();
  return facts;
}

class VdbReader final : public LatticeReader {
 public:
  VdbReader() { openvdb::initialize(); }

  Result<LatticeFrame> describe(const std::filesystem::path& path, const std::string& wanted,
                                const std::string& usual, bool needBox) override {
    return guarded(path, [&]() -> Result<LatticeFrame> {
      VdbFile file(path);
      const auto entries = entriesOf(file);
      VOLUTE_ASSIGN(const std::size_t index,
                    chooseGrid(entries, wanted, path.string(), {.usual = usual}));
      const openvdb::GridBase& grid = file.grid(index);
      LatticeFrame frame;
      const std::string name = file.name(index);
      name.copy(frame.grid, LatticeFrame::kMaxName);
      otherGrids(entries, index, LatticeFrame::kMaxName).copy(frame.others, LatticeFrame::kMaxName);
      frame.channels =
          grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>() ? 3 : 1;
      VOLUTE_TRY(readTransform(grid, fmt::format("{}, grid '{}'", path.string(), name), frame));
      if (const auto time = grid.getMetadata<openvdb::DoubleMetadata>(kTimeKey))
        frame.time = time->value();
      if (const auto noted = notedBox(grid)) {
        frame.box = *noted;
      } else if (needBox) {
        frame.box = toIndexBox(file.readTree(index)->evalActiveVoxelBoundingBox());
      }
      return frame;
    });
  }

  Result<std::vector<GridFacts>> list(const std::filesystem::path& path) override {
    return guarded(path, [&]() -> Result<std::vector<GridFacts>> {
      VdbFile file(path);
      std::vector<GridFacts> grids;
      for (std::size_t i = 0; i < file.gridCount(); ++i) {
        const auto grid = file.readTree(i);
        grid->setSaveFloatAsHalf(file.grid(i).saveFloatAsHalf());
        grids.push_back(factsOf(file.name(i), *grid));
      }
      return grids;
    });
  }

  Status read(const std::filesystem::path& path, const std::string& wanted, const IndexBox& box,
              bool crop, std::span<float> values) override {
    return guarded(path, [&]() -> Status {
      VdbFile file(path);
      VOLUTE_ASSIGN(const std::size_t index, chooseGrid(entriesOf(file), wanted, path.string()));
      const auto grid = file.readTree(index);
      if (!crop && !box.contains(toIndexBox(grid->evalActiveVoxelBoundingBox()))) {
        return fail(ErrorCode::kInvalidData,
                    "{}: grid '{}' has voxels outside the box that its metadata state; the file is "
                    "damaged, or give --bounds",
                    path.string(), wanted);
      }
      const auto toCoord = [](const std::array<std::int64_t, 3>& at, int less) {
        return openvdb::Coord(static_cast<int>(at[0] - less), static_cast<int>(at[1] - less),
                              static_cast<int>(at[2] - less));
      };
      const openvdb::CoordBBox dense(toCoord(box.begin, 0), toCoord(box.end, 1));
      const bool filled = fillIfType<openvdb::FloatGrid>(*grid, dense, values) ||
                          fillIfType<openvdb::DoubleGrid>(*grid, dense, values) ||
                          fillIfType<openvdb::Vec3SGrid>(*grid, dense, values) ||
                          fillIfType<openvdb::Vec3DGrid>(*grid, dense, values);
      if (!filled)
        return fail(ErrorCode::kUnsupported, "{}: grid '{}' changed its type", path.string(),
                    wanted);
      return {};
    });
  }
};

/// Zero voxels stay inactive.
template <class Grid>
openvdb::GridBase::Ptr makeGrid(const VolumeInfo& info, std::span<const float> values) {
  using Value = typename Grid::ValueType;
  auto grid = Grid::create();
  auto accessor = grid->getAccessor();
  const float* from = values.data();
  for (int z = 0; z < info.z; ++z) {
    for (int y = 0; y < info.y; ++y) {
      for (int x = 0; x < info.x; ++x, from += info.channels) {
        if (std::all_of(from, from + info.channels, [](float value) { return value == 0; }))
          continue;
        if constexpr (Channels<Value>::kCount == 3) {
          accessor.setValue({x, y, z}, Value(from[0], from[1], from[2]));
        } else {
          accessor.setValue({x, y, z}, *from);
        }
      }
    }
  }
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

/// OpenVDB writes a random identifier into each file; one that follows from the content keeps equal
/// inputs equal.
void overwriteIdentifier(std::ostream& stream, int number, std::span<const float> values) {
  constexpr std::streamoff kPlace =
      21;  // after magic number, versions and the flag for grid offsets
  const std::uint32_t content = crc32(std::as_bytes(values));
  stream.seekp(kPlace);
  stream << fmt::format("{:08x}-0000-4000-8000-{:012x}", content,
                        static_cast<std::uint32_t>(number));
}

class VdbWriter final : public LatticeWriter {
 public:
  explicit VdbWriter(const LatticeWriterOptions& options) : options_(options) {
    openvdb::initialize();
  }

  Status write(const std::filesystem::path& temporary, const std::filesystem::path& target,
               const VolumeInfo& info, int frame, std::span<const float> values) override {
    try {
      const auto grid = info.channels == 3 ? makeGrid<openvdb::Vec3SGrid>(info, values)
                                           : makeGrid<openvdb::FloatGrid>(info, values);
      grid->setName(info.name);
      // OpenVDB does not zip fog volumes.
      grid->setGridClass(options_.zip ? openvdb::GRID_UNKNOWN : openvdb::GRID_FOG_VOLUME);
      grid->setTransform(makeTransform(info));
      grid->setSaveFloatAsHalf(options_.half);
      grid->insertMeta(kTimeKey, openvdb::DoubleMetadata(info.times[frame]));
      std::ofstream stream;
      stream.exceptions(std::ios::badbit | std::ios::failbit);
      stream.open(temporary, std::ios::binary);
      VdbOutput(options_.zip).writeTo(stream, grid);
      overwriteIdentifier(stream, info.frameNumbers[frame], values);
      stream.close();
    } catch (const std::ios_base::failure&) {
      return fail(ErrorCode::kIo, "{}: cannot write: {}", target.string(), std::strerror(errno));
    } catch (const std::exception& error) {
      return fail(ErrorCode::kIo, "{}: cannot write: {}", target.string(), error.what());
    }
    return {};
  }

 private:
  LatticeWriterOptions options_;
};

}  // namespace
}  // namespace volute

extern "C" const volute::LatticePlugin* voluteVdbPlugin() {
  using namespace volute;
  static constexpr LatticePlugin kPlugin{
      []() -> std::unique_ptr<LatticeReader> { return std::make_unique<VdbReader>(); },
      [](const LatticeWriterOptions& options) -> std::unique_ptr<LatticeWriter> {
        return std::make_unique<VdbWriter>(options);
      },
      nullptr};
  return &kPlugin;
}
