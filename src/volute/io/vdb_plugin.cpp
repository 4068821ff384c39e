// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// The one translation unit that includes OpenVDB (it takes minutes to compile).
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>
#include <openvdb/util/Name.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <sstream>

#include "volute/base/checksum.hpp"
#include "volute/base/file_name.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/resample.hpp"
#include "volute/io/grid_choice.hpp"
#include "volute/io/lattice.hpp"
#include "volute/io/nano_grids.hpp"
#include "volute/io/vdb_grid.hpp"

namespace volute {
namespace {

constexpr const char* kTimeKey = "volute:time";
constexpr std::string_view kLevelSet = "level set";

/// An error that comes out where others are exceptions.
struct Refused {
  Error error;
};

constexpr std::string_view kBadMatrix =
    "the grid's matrix is not finite, or makes it flat; expected one that can be undone";

/// An OpenVDB file, or a NanoVDB one as if it were, over a stream that throws at every short read,
/// which OpenVDB's own File does not notice.
class VdbFile final : public openvdb::io::Archive {
 public:
  explicit VdbFile(const std::filesystem::path& path) : path_(path) {
    if (isNanoFile(path)) {
      takeNanoGrids();
      return;
    }
    stream_.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
    stream_.open(path, std::ios::binary);
    const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path));
    openvdb::io::setStreamMetadataPtr(stream_, metadata_, /*transfer=*/false);
    readHeader(stream_);
    setFormatVersion(stream_);
    setLibraryVersion(stream_);
    setDataCompression(stream_);
    fileMetadata_.readMeta(stream_);
    const std::int32_t count = readGridCount(stream_);
    whole_ = !inputHasGridOffsets();
    for (std::int32_t i = 0; i < count; ++i) {
      auto& entry = grids_.emplace_back();
      readDescriptor(entry);
      if (whole_) {
        readNext(entry);
        continue;
      }
      if (entry.descriptor.getEndPos() > size || entry.descriptor.getGridPos() < 0) {
        OPENVDB_THROW(openvdb::IoError, "it ends before its grids do");
      }
      entry.descriptor.seekToEnd(stream_);
    }
    for (auto& entry : grids_) {
      if (!whole_ && entry.foreignType.empty())
        readDescription(entry);
      else if (entry.descriptor.isInstance())
        entry.grid->setTree(parentOf(entry).grid->baseTreePtr());
    }
  }

  const std::filesystem::path& path() const { return path_; }

  std::size_t gridCount() const { return grids_.size(); }

  std::string name(std::size_t index) const {
    return openvdb::io::GridDescriptor::nameAsString(grids_[index].descriptor.uniqueName());
  }

  const openvdb::MetaMap& metadata() const { return fileMetadata_; }

  /// Metadata and transform are read, the tree is empty.
  const openvdb::GridBase& grid(std::size_t index) const { return *grids_[index].grid; }

  /// Of a grid that OpenVDB does not know, else empty; grid() is none of its kind then.
  const std::string& foreignType(std::size_t index) const { return grids_[index].foreignType; }

  /// Whether readTopology() leaves values in the file.
  bool hasTopology(std::size_t index) const {
    return !whole_ && !grids_[index].descriptor.isInstance() && foreignType(index).empty();
  }

  /// Where its voxels are, without their values.
  openvdb::GridBase::Ptr readTopology(std::size_t index) {
    const auto& entry = grids_[index];
    if (!hasTopology(index))
      return readTree(index);
    auto grid = openvdb::GridBase::createGrid(entry.descriptor.gridType());
    entry.descriptor.seekToGrid(stream_);
    readGridCompression(stream_);
    grid->readMeta(stream_);
    grid->readTransform(stream_);
    grid->readTopology(stream_);
    return grid;
  }

  /// @param box  [voxels] what lies outside of it is left in the file; null: nothing is
  openvdb::GridBase::Ptr readTree(std::size_t index, const openvdb::CoordBBox* box = nullptr) {
    const auto& entry = grids_[index];
    if (!entry.foreignType.empty())
      OPENVDB_THROW(openvdb::LookupError, "of a type that OpenVDB does not know");
    if (whole_)
      return entry.grid;
    if (entry.descriptor.isInstance()) {
      auto grid = entry.grid->copyGrid();
      grid->setTree(readTree(&parentOf(entry) - grids_.data(), box)->baseTreePtr());
      return grid;
    }
    auto grid = openvdb::GridBase::createGrid(entry.descriptor.gridType());
    entry.descriptor.seekToGrid(stream_);
    metadata_->setSeekable(box != nullptr);
    if (box)
      readGrid(grid, entry.descriptor, stream_, *box);
    else
      readGrid(grid, entry.descriptor, stream_);
    if (stream_.tellg() != entry.descriptor.getEndPos()) {
      OPENVDB_THROW(openvdb::IoError, "a grid does not end where the file says");
    }
    return grid;
  }

  /// The bytes that it has in the file; 0: not known.
  std::uint64_t bytesOf(std::size_t index) const {
    const auto& descriptor = grids_[index].descriptor;
    return whole_ ? 0
                  : static_cast<std::uint64_t>(descriptor.getEndPos() - descriptor.getGridPos());
  }

  /// The grid as a file of its own: as OpenVDB writes it, or, where OpenVDB cannot read it, byte
  /// for byte.
  std::string copyOf(std::size_t index);

 private:
  struct Entry {
    openvdb::io::GridDescriptor descriptor;
    openvdb::GridBase::Ptr grid;
    std::string foreignType{};
  };

  void takeNanoGrids() {
    auto grids = readNanoGrids(path_);
    if (!grids)
      throw Refused{std::move(grids.error())};
    whole_ = true;
    std::map<std::string, int> seen;
    for (const auto& grid : *grids) ++seen[grid->getName()];
    std::map<std::string, int> numbers;
    for (auto& grid : *grids) {
      const std::string own = grid->getName();
      const std::string name = own.empty() || seen[own] > 1
                                   ? openvdb::io::GridDescriptor::addSuffix(own, numbers[own]++)
                                   : own;
      grids_.push_back({{name, grid->type()}, std::move(grid)});
    }
  }

  /// As GridDescriptor::read(), which refuses types that are not registered.
  void readDescriptor(Entry& entry) {
    const auto at = stream_.tellg();
    const std::string name = openvdb::readString(stream_);
    const std::string type = openvdb::readString(stream_);
    constexpr std::string_view kHalf = "_HalfFloat";
    const bool half = type.ends_with(kHalf);
    if (whole_ ||
        openvdb::GridBase::isRegistered(half ? type.substr(0, type.size() - kHalf.size()) : type)) {
      stream_.seekg(at);
      entry.grid = entry.descriptor.read(stream_);
      return;
    }
    entry.descriptor = openvdb::io::GridDescriptor(name, type);
    entry.descriptor.setInstanceParentName(openvdb::readString(stream_));
    std::array<std::int64_t, 3> places{};
    stream_.read(reinterpret_cast<char*>(places.data()), sizeof places);
    entry.descriptor.setGridPos(places[0]);
    entry.descriptor.setBlockPos(places[1]);
    entry.descriptor.setEndPos(places[2]);
    if (places[0] > places[1] || places[1] > places[2] || entry.descriptor.isInstance())
      OPENVDB_THROW(openvdb::IoError,
                    "a grid of type " << type << " cannot be where the file says");
    entry.foreignType = type;
    entry.grid = emptyGrid<openvdb::MaskGrid>(false);
    entry.grid->setName(openvdb::io::GridDescriptor::stripSuffix(name));
  }

  /// The grid whose voxels an instance shares.
  const Entry& parentOf(const Entry& entry) const {
    const auto parent = std::ranges::find(grids_, entry.descriptor.instanceParentName(),
                                          [](auto& e) { return e.descriptor.uniqueName(); });
    if (parent == grids_.end() || parent->descriptor.isInstance()) {
      OPENVDB_THROW(openvdb::IoError, "the grid that shares its voxels is missing");
    }
    return *parent;
  }

  /// The grid that comes next in a file that does not say where its grids are.
  void readNext(Entry& entry) {
    metadata_->setSeekable(false);
    readGrid(entry.grid, entry.descriptor, stream_);
  }

  void readDescription(Entry& entry) {
    entry.descriptor.seekToGrid(stream_);
    readGridCompression(stream_);
    entry.grid->readMeta(stream_);
    try {
      entry.grid->readTransform(stream_);
    } catch (const openvdb::ArithmeticError&) {
      throw Refused{fail(ErrorCode::kInvalidData, "{}, grid '{}': {}", path_.string(),
                         openvdb::io::GridDescriptor::nameAsString(entry.descriptor.uniqueName()),
                         kBadMatrix)
                        .value()};
    }
  }

  std::filesystem::path path_;
  // The stream keeps the address of this pointer.
  openvdb::io::StreamMetadata::Ptr metadata_ = std::make_shared<openvdb::io::StreamMetadata>();
  std::ifstream stream_;
  openvdb::MetaMap fileMetadata_;
  std::vector<Entry> grids_;
  bool whole_ = false;  ///< grids_ hold their trees
};

/// Where a grid's data lie in a file that holds it alone, without metadata of its own.
struct KeptPlace {
  std::string name, type, parent;     ///< as in the file
  std::size_t begin = 0;              ///< of the data
  std::int64_t blocks = 0, size = 0;  ///< of the data: where the tree's begin, and all

  static constexpr std::size_t kHeader = 57;  ///< magic number, versions, flag and identifier

  /// Takes any bytes; nothing where they are no such file.
  static std::optional<KeptPlace> find(std::span<const std::byte> bytes) {
    KeptPlace place;
    std::size_t at = kHeader;
    const auto number = [&]<class Number>(Number& value) {
      if (at > bytes.size() || bytes.size() - at < sizeof value)
        return false;
      std::memcpy(&value, bytes.data() + at, sizeof value);
      at += sizeof value;
      return true;
    };
    std::int32_t entries = 0, grids = 0;
    if (!number(entries) || entries != 0 || !number(grids) || grids != 1)
      return std::nullopt;
    for (std::string* text : {&place.name, &place.type, &place.parent}) {
      std::uint32_t length = 0;
      if (!number(length) || length > bytes.size() - at)
        return std::nullopt;
      text->assign(reinterpret_cast<const char*>(bytes.data()) + at, length);
      at += length;
    }
    std::array<std::int64_t, 3> places{};
    if (!number(places) || places[0] != static_cast<std::int64_t>(at) || places[1] < places[0] ||
        places[2] < places[1])
      return std::nullopt;
    place.begin = at;
    place.blocks = places[1] - places[0];
    place.size = places[2] - places[0];
    return place;
  }

  void writeTo(std::ostream& stream) const {
    for (const std::string& text : {name, type, parent}) openvdb::writeString(stream, text);
    std::array<std::int64_t, 3> places{};
    places[0] =
        static_cast<std::int64_t>(stream.tellp()) + static_cast<std::int64_t>(sizeof places);
    places[1] = places[0] + blocks;
    places[2] = places[0] + size;
    stream.write(reinterpret_cast<const char*>(places.data()), sizeof places);
  }
};

/// OpenVDB writes a random identifier into each file; one that follows from the content keeps equal
/// inputs equal.
void overwriteIdentifier(std::ostream& stream, std::uint32_t content, int number) {
  constexpr std::streamoff kPlace =
      21;  // after magic number, versions and the flag for grid offsets
  stream.seekp(kPlace);
  stream << fmt::format("{:08x}-0000-4000-8000-{:012x}", content,
                        static_cast<std::uint32_t>(number));
}

/// Writes to a stream of ours, so that a full disk shows.
class VdbOutput final : public openvdb::io::Archive {
 public:
  enum class Packing { kUsual, kZip, kNone };

  explicit VdbOutput(Packing packing) {
    using namespace openvdb::io;
    if (packing == Packing::kZip)
      setCompression(COMPRESS_ZIP | COMPRESS_ACTIVE_MASK);
    if (packing == Packing::kNone)
      setCompression(COMPRESS_ACTIVE_MASK);
  }

  void writeTo(std::ostream& stream, const openvdb::GridBase::Ptr& grid) const {
    write(stream, openvdb::GridPtrVec{grid}, /*seekable=*/true);
  }

  /// Of a file with so many grids, which follow.
  void begin(std::ostream& stream, const openvdb::MetaMap& metadata, std::size_t grids) const {
    writeHeader(stream, /*seekable=*/true);
    metadata.writeMeta(stream);
    const auto count = static_cast<std::int32_t>(grids);
    stream.write(reinterpret_cast<const char*>(&count), sizeof count);
  }

  /// @param name  unlike all others in the file
  void add(std::ostream& stream, const std::string& name,
           const openvdb::GridBase::ConstPtr& grid) const {
    openvdb::io::GridDescriptor descriptor(name, grid->type(), grid->saveFloatAsHalf());
    writeGrid(descriptor, grid, stream, /*seekable=*/true);
  }

  /// @param content  gets a digest of the bytes
  static Status add(std::ostream& stream, KeptBytes& kept, const std::string& target,
                    std::uint32_t& content) {
    VOLUTE_ASSIGN(auto part, kept.next());
    const auto place = KeptPlace::find(part);
    if (!place || kept.size() != place->begin + static_cast<std::uint64_t>(place->size)) {
      return fail(ErrorCode::kInvalidData, "{}: a grid that was kept as bytes is no OpenVDB grid",
                  target);
    }
    place->writeTo(stream);
    for (part = part.subspan(place->begin); !part.empty();) {
      stream.write(reinterpret_cast<const char*>(part.data()),
                   static_cast<std::streamsize>(part.size()));
      content ^= crc32(part);
      VOLUTE_ASSIGN(part, kept.next());
    }
    return {};
  }
};

std::string VdbFile::copyOf(std::size_t index) {
  const Entry& entry = grids_[index];
  std::ostringstream out;
  out.exceptions(std::ios::badbit | std::ios::failbit);
  const VdbOutput output(VdbOutput::Packing::kNone);
  output.begin(out, {}, 1);
  try {
    const auto grid = readTree(index);
    if (grid->saveFloatAsHalf() != entry.grid->saveFloatAsHalf())
      grid->setSaveFloatAsHalf(entry.grid->saveFloatAsHalf());
    output.add(out, entry.descriptor.uniqueName(), grid);
  } catch (const openvdb::LookupError& error) {
    if (whole_ || entry.descriptor.isInstance() || fileVersion() != openvdb::OPENVDB_FILE_VERSION) {
      OPENVDB_THROW(openvdb::LookupError,
                    "grid '" << name(index) << "' cannot be kept: " << error.what());
    }
    const auto& from = entry.descriptor;
    const std::string type = entry.foreignType.empty()
                                 ? from.gridType() + (from.saveFloatAsHalf() ? "_HalfFloat" : "")
                                 : entry.foreignType;
    KeptPlace place{from.uniqueName(), type, {}};
    place.blocks = from.getBlockPos() - from.getGridPos();
    place.size = from.getEndPos() - from.getGridPos();
    place.writeTo(out);
    from.seekToGrid(stream_);
    std::vector<char> bytes(std::size_t{1} << 20);
    for (std::int64_t left = place.size; left > 0;) {
      const auto count = std::min<std::int64_t>(left, std::ssize(bytes));
      stream_.read(bytes.data(), count);
      out.write(bytes.data(), count);
      left -= count;
    }
  }
  overwriteIdentifier(out, 0, 0);
  return std::move(out).str();
}

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
    return fail(ErrorCode::kInvalidData, "{}: not a whole OpenVDB file: {}", file.string(),
                error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    return fail(ErrorCode::kIo, "{}: cannot read: {}", file.string(), error.code().message());
  } catch (const std::runtime_error& error) {  // NanoVDB's
    return fail(ErrorCode::kInvalidData, "{}: not a whole NanoVDB file: {}", file.string(),
                error.what());
  }
}

GridEntry describeGrid(const std::string& name, const openvdb::GridBase& grid) {
  const bool scalar = grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>();
  const bool colour = grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>();
  const bool levelSet = scalar && grid.getGridClass() == openvdb::GRID_LEVEL_SET;
  return {name, levelSet ? std::string(kLevelSet) : std::string(grid.valueType()),
          scalar || colour};
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

bool isFrustum(const openvdb::GridBase& grid) {
  return !grid.transform().isLinear();
}

/// Fills voxelSize and origin, and the matrix where voxels do not lie along the axes.
Status readTransform(const openvdb::GridBase& grid, const std::string& where, LatticeFrame& frame) {
  if (isFrustum(grid)) {
    return fail(ErrorCode::kUnsupported, Hint::set("resample").so("makes such voxels"),
                "{}: the grid has a frustum, which no matrix says; expected voxels of one shape",
                where);
  }
  // OpenVDB multiplies row vectors: (i, j, k, 1) * matrix.
  const openvdb::Mat4R matrix = grid.transform().baseMap()->getAffineMap()->getMat4();
  bool straight = true;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      frame.matrix[static_cast<std::size_t>(4 * row + column)] = matrix(column, row);
    frame.voxelSize[static_cast<std::size_t>(row)] = matrix(row, row);
    frame.origin[static_cast<std::size_t>(row)] = matrix(3, row);
    straight = straight && matrix(row, row) > 0;
    for (int column = 0; column < 3; ++column)
      straight = straight && (row == column ||
                              std::abs(matrix(row, column)) <= 1e-9 * std::abs(matrix(row, row)));
  }
  if (!isSound(frame.matrix)) {
    return fail(ErrorCode::kInvalidData, "{}: {}", where, kBadMatrix);
  }
  frame.turned = !straight;
  if (frame.turned) {
    const GridSpace space = spaceOf(frame.matrix);
    frame.voxelSize = space.voxelSize, frame.origin = space.origin;
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

/// From the indices of a lattice to those of a grid with a frustum.
class FrustumLattices final : public LatticeMap {
 public:
  FrustumLattices(const openvdb::math::Transform& transform, const GridMatrix& indexToWorld)
      : transform_(transform),
        linear_(linearOf(indexToWorld)),
        offset_(offsetOf(indexToWorld)),
        back_(linear_.inverse()) {}

  Vec3 toOld(const Vec3& index) const override {
    const Vec3 world = linear_ * index + offset_;
    const auto at = transform_.worldToIndex(openvdb::Vec3d(world.x(), world.y(), world.z()));
    return {at.x(), at.y(), at.z()};
  }

  Vec3 toNew(const Vec3& index) const override {
    const auto at = transform_.indexToWorld(openvdb::Vec3d(index.x(), index.y(), index.z()));
    return back_ * (Vec3(at.x(), at.y(), at.z()) - offset_);
  }

  /// Around a box of the grid's voxels.
  IndexBox around(const openvdb::CoordBBox& box) const {
    IndexBox all;
    if (box.empty())
      return all;
    Box3 bounds;
    for (int corner = 0; corner < 8; ++corner) {
      Vec3 at;
      for (int axis = 0; axis < 3; ++axis)
        at[axis] = corner >> axis & 1 ? box.max()[axis] + 1 : box.min()[axis] - 1;
      bounds.extend(toNew(at));
    }
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double kFarthest = 1e9;
      const auto a = static_cast<std::size_t>(axis);
      all.begin[a] = std::llround(std::clamp(std::floor(bounds.min[axis]), -kFarthest, kFarthest));
      all.end[a] = std::llround(std::clamp(std::ceil(bounds.max[axis]), -kFarthest, kFarthest)) + 1;
    }
    return all;
  }

 private:
  const openvdb::math::Transform& transform_;
  Mat3 linear_;
  Vec3 offset_;
  Mat3 back_;
};

/// As readTransform(), of a grid with a frustum that is sampled; cubes as small as its voxels in
/// the middle where the lattice is not said.
Status readSampledPlace(const openvdb::GridBase& grid, const openvdb::GridBase& topology,
                        const FrustumSampling& how, const std::string& where, LatticeFrame& frame) {
  GridMatrix matrix = how.indexToWorld;
  const openvdb::CoordBBox box = topology.evalActiveVoxelBoundingBox();
  if (matrix == GridMatrix{}) {
    const openvdb::Vec3d middle =
        box.empty() ? openvdb::Vec3d(0) : 0.5 * (box.min().asVec3d() + box.max().asVec3d());
    const openvdb::Vec3d size = grid.transform().voxelSize(middle);
    const double side = std::min({size[0], size[1], size[2]});
    matrix = alongAxes({side, side, side}, {0.5 * side, 0.5 * side, 0.5 * side});
  }
  if (!isSound(matrix)) {
    return fail(ErrorCode::kInvalidData, "{}: the grid's frustum is not finite, or makes it flat",
                where);
  }
  const GridSpace space = spaceOf(matrix);
  frame.matrix = matrix;
  frame.voxelSize = space.voxelSize, frame.origin = space.origin;
  frame.turned = matrix != alongAxes(space.voxelSize, space.origin);
  frame.box = FrustumLattices(grid.transform(), matrix).around(box);
  return {};
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

/// Of a number and its float, a difference from `offset`.
template <class Scalar>
double roundingOf(const Scalar& number, float value, double offset) {
  const double error =
      std::abs(static_cast<double>(number) - (offset + static_cast<double>(value)));
  return std::isfinite(error) ? error : 0;
}

template <class Value>
struct Channels {
  static constexpr int kCount = 1;

  static void store(const Value& value, float* to, double offset) {
    *to = static_cast<float>(value - static_cast<Value>(offset));
  }

  static double rounding(const Value& value, const float* to, double offset) {
    return roundingOf(value, *to, offset);
  }
};

template <class Scalar>
struct Channels<openvdb::math::Vec3<Scalar>> {
  static constexpr int kCount = 3;

  static void store(const openvdb::math::Vec3<Scalar>& value, float* to, double offset) {
    for (int c = 0; c < 3; ++c) to[c] = static_cast<float>(value[c] - static_cast<Scalar>(offset));
  }

  static double rounding(const openvdb::math::Vec3<Scalar>& value, const float* to, double offset) {
    double most = 0;
    for (int c = 0; c < 3; ++c) most = std::max(most, roundingOf(value[c], to[c], offset));
    return most;
  }
};

/// What is in the grid, as far as it reaches into `box`: voxels and tiles that are active or not
/// the background. Inactive voxels that are no numbers are background. Values are differences from
/// `offset`.
/// @param topology  the same without values; where only `box` was read, tiles across its border are
/// voxels in `grid`
template <class Grid>
Bricks bricksOf(const Grid& grid, const Grid& topology, const openvdb::CoordBBox& box,
                double offset, double& rounding) {
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
  for (float& value : background)
    value = std::isfinite(value) ? value : static_cast<float>(0 - offset);
  Bricks all(Traits::kCount, background);
  const auto holds = [&](const Colour& colour, bool active) {
    return active || (finite(colour) && colour != background);
  };
  const auto originOf = [](const openvdb::Coord& at) -> VoxelIndex {
    return {at.x(), at.y(), at.z()};
  };
  auto tile = topology.cbeginValueAll();
  tile.setMaxDepth(openvdb::Index(decltype(tile)::LEAF_DEPTH - 1));
  for (; tile; ++tile) {
    const Colour colour = colourOf(*tile);
    openvdb::CoordBBox part;
    tile.getBoundingBox(part);
    if (!holds(colour, tile.isValueOn()) || !part.hasOverlap(box))
      continue;
    rounding = std::max(rounding, Traits::rounding(*tile, colour.data(), offset));
    all.addTile({originOf(part.min()), part.max().x() - std::int64_t{part.min().x()} + 1,
                 tile.isValueOn(), colour});
  }
  all.reserve(grid.tree().leafCount(), all.tiles().size());
  for (auto it = grid.tree().cbeginLeaf(); it; ++it) {
    if (!it->getNodeBoundingBox().hasOverlap(box) ||
        (&grid != &topology && topology.tree().probeConstLeaf(it->origin()) == nullptr))
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
      leaf.active[z] |= static_cast<std::uint64_t>(active) << bit;
      leaf.valued[z] |= static_cast<std::uint64_t>(holds(colourOf(values[n]), active)) << bit;
      any |= leaf.valued[z];
    });
    if (any == 0)
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
  return all;
}

bool hasDoubles(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::DoubleGrid>() || grid.isType<openvdb::Vec3DGrid>();
}

/// Nothing where the grid is of a type that is no volume.
std::optional<Bricks> bricksOfGrid(const openvdb::GridBase& grid, const openvdb::GridBase& topology,
                                   const openvdb::CoordBBox& box, double offset, double& rounding) {
  std::optional<Bricks> bricks;
  const auto take = [&]<class Grid>() {
    if (!bricks && grid.isType<Grid>() && topology.isType<Grid>())
      bricks = bricksOf(static_cast<const Grid&>(grid), static_cast<const Grid&>(topology), box,
                        offset, rounding);
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

void putText(std::string_view text, char* to, std::size_t most) {
  text.substr(0, most).copy(to, most);
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

/// Of a grid whose voxels cannot be read.
GridFacts unknownOf(const std::string& name, const std::string& type, std::string_view problem) {
  GridFacts facts;
  name.copy(facts.name, GridFacts::kMaxName);
  type.copy(facts.type, GridFacts::kMaxType);
  facts.least = facts.most = std::numeric_limits<double>::quiet_NaN();
  problem.substr(0, GridFacts::kMaxProblem).copy(facts.problem, GridFacts::kMaxProblem);
  return facts;
}

/// What OpenVDB writes of itself, and what we keep elsewhere.
bool isKeptElsewhere(const std::string& name) {
  using openvdb::GridBase;
  return name == GridBase::META_GRID_CLASS || name == GridBase::META_GRID_NAME ||
         name == GridBase::META_FILE_BBOX_MIN || name == GridBase::META_FILE_BBOX_MAX ||
         name == GridBase::META_FILE_COMPRESSION || name == GridBase::META_FILE_MEM_BYTES ||
         name == GridBase::META_FILE_VOXEL_COUNT || name == GridBase::META_FILE_DELAYED_LOAD;
}

/// The same name again, and none at all ("[0]"), is told apart by OpenVDB itself.
std::string nameInFile(const std::string& name) {
  const auto bracket = name.rfind('[');
  const bool second = bracket != std::string::npos && name.back() == ']' &&
                      bracket + 2 < name.size() &&
                      name.find_first_not_of("0123456789", bracket + 1) == name.size() - 1;
  return second ? name.substr(0, bracket) : name;
}

/// The same as OpenVDB writes it.
/// @param own  the grid's own name
std::string uniqueNameOf(const std::string& name, const std::string& own) {
  if (own == name)
    return name;
  return openvdb::io::GridDescriptor::addSuffix(own, std::atoi(name.c_str() + own.size() + 1));
}

constexpr std::size_t kSizeBytes = sizeof(openvdb::Index32);  // before a value of metadata

/// All entries but those that are kept elsewhere, of types that nobody knows too.
MetadataList listMetadata(const openvdb::MetaMap& map) {
  MetadataList list;
  for (auto it = map.beginMeta(); it != map.endMeta(); ++it) {
    if (isKeptElsewhere(it->first))
      continue;
    std::ostringstream bytes;
    it->second->write(bytes);
    list.push_back({it->first, it->second->typeName(), bytes.str().substr(kSizeBytes)});
  }
  return list;
}

/// The same the other way; leaves out what cannot be. What no type of OpenVDB's own needs is
/// written as bytes.
void putMetadata(const MetadataList& list, openvdb::MetaMap& map) {
  using openvdb::Metadata;
  for (const GridMetadata& entry : list) {
    if (entry.name.empty() || isKeptElsewhere(entry.name) || entry.name == kTypeEntry ||
        entry.name == kNumberEntry || entry.type.starts_with("__"))
      continue;
    const bool known = Metadata::isRegisteredType(entry.type);
    const Metadata::Ptr metadata = known ? Metadata::createMetadata(entry.type)
                                         : std::make_shared<openvdb::UnknownMetadata>(entry.type);
    if (known && entry.type != "string" && metadata->size() != entry.value.size())
      continue;
    const auto size = static_cast<openvdb::Index32>(entry.value.size());
    std::string bytes(kSizeBytes, '\0');
    std::memcpy(bytes.data(), &size, kSizeBytes);
    std::istringstream in(bytes + entry.value);
    metadata->read(in);
    map.insertMeta(entry.name, *metadata);
  }
}

template <class Grid>
bool addBackground(const openvdb::GridBase& base, GridTraits& traits) {
  if (!base.isType<Grid>())
    return false;
  const auto& background = static_cast<const Grid&>(base).background();
  constexpr std::size_t kCount = Channels<typename Grid::ValueType>::kCount;
  for (std::size_t c = 0; c < kCount; ++c) {
    double number = 0;
    if constexpr (kCount == 1)
      number = background;
    else
      number = background[static_cast<int>(c)];
    traits.background[c] = std::isfinite(number) ? number : 0;
  }
  return true;
}

/// A program that writes caches, and its up axis.
struct Writer {
  std::string_view name;
  char up;
};

/// As what people and programs state calls them.
constexpr Writer kWriters[] = {
    {"Houdini", 'y'},  {"Blender", 'z'}, {"Bifrost", 'y'},   {"EmberGen", 'y'},  {"JangaFX", 'y'},
    {"LiquiGen", 'y'}, {"GeoGen", 'y'},  {"Maya", 'y'},      {"Cinema 4D", 'y'}, {"Katana", 'y'},
    {"Unreal", 'z'},   {"3ds Max", 'z'}, {"Mantaflow", 'z'}, {"RealFlow", 'y'}};

/// By what metadata of a file or a grid say; null: nothing.
const Writer* writerOf(const openvdb::MetaMap& map) {
  const auto named = [](std::string_view name) {
    return std::ranges::find(kWriters, name, &Writer::name);
  };
  for (const char* key : {"creator", "software", "application", "generator", "author"}) {
    const auto stated = map.getMetadata<openvdb::StringMetadata>(key);
    for (const Writer& writer : kWriters) {
      if (stated && stated->value().find(writer.name) != std::string::npos)
        return &writer;
    }
  }
  for (auto entry = map.beginMeta(); entry != map.endMeta(); ++entry) {
    if (entry->first.find("bifrost") != std::string::npos)
      return named("Bifrost");
  }
  // Mantaflow's, which is Blender's solver.
  if (map["file_base_resolution"] && map["file_voxel_size"])
    return named("Blender");
  return nullptr;
}

void putWriter(const VdbFile& file, LatticeFrame& frame) {
  const Writer* writer = writerOf(file.metadata());
  for (std::size_t i = 0; !writer && i < file.gridCount(); ++i) writer = writerOf(file.grid(i));
  if (!writer)
    return;
  frame.up = writer->up;
  putText(writer->name, frame.writer, LatticeFrame::kMaxWriter);
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
  putWriter(file, result.frame);
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
  (void)(addBackground<openvdb::FloatGrid>(*tree, traits) ||
         addBackground<openvdb::DoubleGrid>(*tree, traits) ||
         addBackground<openvdb::Vec3SGrid>(*tree, traits) ||
         addBackground<openvdb::Vec3DGrid>(*tree, traits));
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

/// Reads the values of a grid that takes more than `limit` bytes in parts of at most that, or of
/// one layer of leaves.
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
      putWriter(file, frame);
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
            bricksOfGrid(*grid, *grid, openvdb::CoordBBox::inf(), offset_, rounding);
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
      auto bricks = bricksOfGrid(*grid, *topology, part, offset_, rounding);
      if (!bricks)
        return changedType(path, wanted);
      return *std::move(bricks);
    });
  }

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
  double offset_ = 0;
};

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

/// A grid of a frame of a cache.
Result<openvdb::GridBase::Ptr> cacheGrid(const GridFrame& frame, const std::string& target) {
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
      if (extensionOf(target) == ".nvdb") {
        std::vector<openvdb::GridBase::Ptr> grids;
        for (const GridFrame& frame : frames) {
          if (frame.kept)
            return fail(ErrorCode::kUnsupported, "{}: takes no grids as their bytes",
                        target.string());
          VOLUTE_ASSIGN(const auto grid, cacheGrid(frame, target.string()));
          grids.push_back(grid);
        }
        writeNanoGrids(stream, grids);
        return {};
      }
      openvdb::MetaMap ofFile;
      if (metadata)
        putMetadata(*metadata, ofFile);
      const VdbOutput output(packing());
      output.begin(stream, ofFile, frames.size());
      std::uint32_t content = 0;
      int number = 0;
      for (const GridFrame& frame : frames) {
        if (frame.kept) {
          VOLUTE_TRY(VdbOutput::add(stream, *frame.kept, target.string(), content));
          continue;
        }
        VOLUTE_ASSIGN(const auto grid, cacheGrid(frame, target.string()));
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
