// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/nano_grids.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#include <nanovdb/util/GridValidator.h>
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#pragma GCC diagnostic pop

#include <cstring>
#include <fstream>
#include <memory>
#include <type_traits>

#include "volute/io/vdb_grid.hpp"

#if NANOVDB_MINOR_VERSION_NUMBER < 5
/// NanoVDB has grids of such vectors, and this step of its converter alone lacks their name; the
/// rest of it is the original's.
template <>
nanovdb::Vec3dGrid* nanovdb::OpenToNanoVDB<openvdb::Vec3d, nanovdb::Vec3d, nanovdb::AbsDiff,
                                           nanovdb::HostBuffer>::processGrid(const OpenGridT& of) {
  auto* made = reinterpret_cast<Vec3dGrid*>(mBufferPtr + mBufferOffsets[0]);
  GridData* data = made->data();
  const std::string name = of.getName();
  const auto map = of.transform().baseMap()->getAffineMap();
  std::memset(static_cast<void*>(data), 0, sizeof *data);
  data->mMagic = NANOVDB_MAGIC_NUMBER;
  data->mVersion = Version();
  data->mFlags = static_cast<std::uint32_t>(GridFlags::IsBreadthFirst);
  data->mGridCount = 1;
  data->mGridSize = mBufferOffsets[8];
  name.copy(data->mGridName, GridData::MaxNameSize - 1);
  data->setLongGridNameOn(name.size() >= GridData::MaxNameSize);
  data->mWorldBBox = BBox<Vec3R>();
  const bool staggered = of.getGridClass() == openvdb::GRID_STAGGERED;
  data->mGridClass = staggered ? nanovdb::GridClass::Staggered : nanovdb::GridClass::Unknown;
  data->mGridType = GridType::Vec3d;
  data->mVoxelSize = map->voxelSize();
  const auto matrix = map->getMat4();
  data->mMap.set(matrix, matrix.inverse(), 1.0);
  mDelta = nanovdb::Vec3d(0);
  processTree(of.tree());
  if (!mBlindMetaData.empty()) {  // a long name
    auto* blind = processMetadata(of);
    data->mBlindMetadataOffset = PtrDiff(blind, made);
    data->mBlindMetadataCount = static_cast<std::uint32_t>(mBlindMetaData.size());
    blind->setBlindData(reinterpret_cast<char*>(mBufferPtr + mBufferOffsets[7]));
  }
  return made;
}
#endif

namespace volute {
namespace {

constexpr std::string_view kNanoName = "NanoVDB";

/// The beginning of a file, zeros where it ends before.
nanovdb::io::Header headerOf(const std::filesystem::path& path) {
  nanovdb::io::Header header;
  std::memset(static_cast<void*>(&header), 0, sizeof header);
  std::ifstream(path, std::ios::binary).read(reinterpret_cast<char*>(&header), sizeof header);
  return header;
}

template <class Value>
Value valueOf(const auto& value) {
  static_assert(sizeof(Value) == sizeof value);
  Value made;
  std::memcpy(static_cast<void*>(&made), &value, sizeof made);
  return made;
}

/// A kind of NanoVDB's values in OpenVDB: its packed ones (Fp4 to FpN) are float.
template <class Kind>
struct OpenKind {
  using Type = std::conditional_t<std::is_arithmetic_v<Kind>, Kind, float>;
};

template <class T>
struct OpenKind<nanovdb::Vec3<T>> {
  using Type = openvdb::math::Vec3<T>;
};

template <>
struct OpenKind<nanovdb::ValueMask> {
  using Type = openvdb::ValueMask;
};

/// Copies a leaf, or an inner node with all below it, to an empty tree of OpenVDB.
template <class To, class Node>
std::unique_ptr<To> copied(const Node& from) {
  using Value = typename To::ValueType;
  const auto& at = from.origin();
  auto to = std::make_unique<To>(openvdb::Coord(at[0], at[1], at[2]), Value());
  for (openvdb::Index i = 0; i < To::NUM_VALUES; ++i) {
    const bool active = from.valueMask().isOn(i);
    if constexpr (To::LEVEL == 0) {
      if constexpr (std::is_same_v<typename To::BuildType, openvdb::ValueMask>)
        to->setActiveState(i, active);
      else
        active ? to->setValueOn(i, valueOf<Value>(from.getValue(i)))
               : to->setValueOff(i, valueOf<Value>(from.getValue(i)));
    } else if (from.childMask().isOn(i)) {
      using Child = typename To::ChildNodeType;
      to->addChild(copied<Child>(*from.data()->getChild(i)).release());
    } else {
      to->addTile(i, valueOf<Value>(from.data()->mTable[i].value), active);
    }
  }
  return to;
}

openvdb::GridClass classOf(nanovdb::GridClass of) {
  switch (of) {
    case nanovdb::GridClass::LevelSet:
      return openvdb::GRID_LEVEL_SET;
    case nanovdb::GridClass::FogVolume:
      return openvdb::GRID_FOG_VOLUME;
    case nanovdb::GridClass::Staggered:
      return openvdb::GRID_STAGGERED;
    default:
      return openvdb::GRID_UNKNOWN;
  }
}

/// The same as nanovdb::nanoToOpenVDB(), which instantiates each type's trees.
template <class Kind>
openvdb::GridBase::Ptr toOpenVdb(const nanovdb::NanoGrid<Kind>& grid) {
  using Tree = typename openvdb::tree::Tree4<typename OpenKind<Kind>::Type>::Type;
  using Root = typename Tree::RootNodeType;
  using Value = typename Tree::ValueType;
  const auto made = emptyGrid<openvdb::Grid<Tree>>(valueOf<Value>(grid.tree().background()));
  made->setName(grid.gridName());
  made->setGridClass(classOf(grid.gridClass()));
  const nanovdb::Map& map = grid.map();
  auto matrix = openvdb::math::Mat4d::identity();
  matrix.setMat3(openvdb::math::Mat3d(map.mMatD));
  matrix = matrix.transpose();  // NanoVDB's is the transposed of OpenVDB's
  matrix.setTranslation(openvdb::Vec3d(map.mVecD));
  made->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
  Root& root = made->tree().root();
  const auto* from = grid.tree().root().data();
  for (std::uint32_t i = 0; i < from->mTableSize; ++i) {
    const auto* tile = from->tile(i);
    const auto at = tile->origin();
    if (tile->isChild())
      root.addChild(copied<typename Root::ChildNodeType>(*from->getChild(tile)).release());
    else
      root.addTile({at[0], at[1], at[2]}, valueOf<Value>(tile->value), tile->state);
  }
  return made;
}

/// Whether it is as it was written. NanoVDB's own check refuses a class that does not go with the
/// type, such as vectors of a fog volume, which OpenVDB's grids may have: a label, no damage.
template <class Kind>
bool isSound(nanovdb::NanoGrid<Kind>& grid) {
  using nanovdb::GridClass;
  if (nanovdb::isValid(grid.gridType(), grid.gridClass()))
    return nanovdb::isValid(grid, true);
  if (grid.gridClass() >= GridClass::End ||
      !nanovdb::validateChecksum(grid, nanovdb::ChecksumMode::Full))
    return false;
  auto& data = *grid.data();
  const auto [own, checksum] = std::pair(data.mGridClass, data.mChecksum);
  data.mGridClass = GridClass::Unknown;
  data.mChecksum = nanovdb::GridChecksum::EMPTY;  // of the rest, which was compared
  const bool sound = nanovdb::isValid(grid, true);
  data.mGridClass = own, data.mChecksum = checksum;
  return sound;
}

/// Of any kind that OpenVDB has too.
template <class... Kinds>
openvdb::GridBase::Ptr toOpenVdb(nanovdb::GridHandle<>& handle, bool& sound) {
  openvdb::GridBase::Ptr made;
  const auto take = [&]<class Kind>() {
    auto* grid = made ? nullptr : handle.grid<Kind>();
    if (!grid)
      return;
    sound = grid->gridSize() == handle.size() && isSound(*grid);
    if (sound)
      made = toOpenVdb<Kind>(*grid);
  };
  (take.template operator()<Kinds>(), ...);
  return made;
}

/// With no class where NanoVDB has no such one for its values.
openvdb::GridBase::ConstPtr labelled(const openvdb::GridBase::Ptr& grid) {
  const openvdb::GridClass own = grid->getGridClass();
  const bool vectors = grid->valueType().starts_with("vec");
  if (own == openvdb::GRID_UNKNOWN || vectors == (own == openvdb::GRID_STAGGERED))
    return grid;
  const auto copy = grid->copyGrid();
  copy->setGridClass(openvdb::GRID_UNKNOWN);
  return copy;
}

/// Nothing for a type that is none of these.
template <class... Grids>
nanovdb::GridHandle<> toNanoVdb(const openvdb::GridBase::ConstPtr& grid) {
  nanovdb::GridHandle<> made;
  const auto take = [&]<class Grid>() {
    if (const auto one = openvdb::GridBase::grid<Grid>(grid))
      made = nanovdb::openToNanoVDB<nanovdb::HostBuffer, typename Grid::TreeType>(
          *one, nanovdb::StatsMode::Default, nanovdb::ChecksumMode::Full);
  };
  (take.template operator()<Grids>(), ...);
  return made;
}

}  // namespace

bool isNanoFile(const std::filesystem::path& path) {
  const auto header = headerOf(path);
  return std::memcmp(&header.magic, kNanoName.data(), kNanoName.size()) == 0;
}

Result<std::vector<openvdb::GridBase::Ptr>> readNanoGrids(const std::filesystem::path& path) {
  using namespace nanovdb;
  const io::Header header = headerOf(path);
  constexpr auto kMajor = static_cast<unsigned>(NANOVDB_MAJOR_VERSION_NUMBER);
  if (header.magic != NANOVDB_MAGIC_NUMBER || header.version.getMajor() > kMajor) {
    char magic[sizeof header.magic + 1] = {};
    std::memcpy(magic, &header.magic, sizeof header.magic);
    return fail(ErrorCode::kUnsupported,
                "{}: a NanoVDB file of a newer kind (\"{}\", version {}.{}.{}); expected \"{}0\" "
                "of version {}, which NanoVDB up to 11 writes; write it as .vdb",
                path.string(), magic, header.version.getMajor(), header.version.getMinor(),
                header.version.getPatch(), kNanoName, kMajor);
  }
  if (header.version.getMajor() < kMajor) {
    return fail(ErrorCode::kUnsupported,
                "{}: a NanoVDB file of version {}.{}.{}; expected version {}", path.string(),
                header.version.getMajor(), header.version.getMinor(), header.version.getPatch(),
                kMajor);
  }
  const auto damaged = [&](std::string_view why) {
    return fail(ErrorCode::kTruncated, "{}: not a whole NanoVDB file: {}", path.string(), why);
  };
  std::uint64_t stored = 0;
  const std::uint64_t size = std::filesystem::file_size(path);
  for (const auto& grid : io::readGridMetaData(path.string())) {
    stored += std::min(grid.fileSize, size);
    if (stored > size || (grid.codec == io::Codec::NONE && grid.gridSize > size))
      return damaged("it ends before its grids do");
  }
  std::vector<openvdb::GridBase::Ptr> grids;
  for (auto& handle : io::readGrids<HostBuffer, std::vector>(path.string())) {
    bool sound = true;
    auto grid = toOpenVdb<float, double, Fp4, Fp8, Fp16, FpN, Vec3f, Vec3d, std::int32_t,
                          std::int64_t, bool, ValueMask>(handle, sound);
    if (!sound)
      return damaged("a grid is damaged");
    if (!grid) {
      const auto* meta = handle.gridMetaData();
      return fail(ErrorCode::kUnsupported,
                  "{}: grid '{}' is of NanoVDB's type {}, which OpenVDB does not have",
                  path.string(), meta ? meta->shortGridName() : "",
                  meta ? toStr(meta->gridType()) : "?");
    }
    grids.push_back(std::move(grid));
  }
  return grids;
}

void writeNanoGrids(std::ostream& stream, const std::vector<openvdb::GridBase::Ptr>& grids) {
  using namespace openvdb;
  std::vector<nanovdb::GridHandle<>> handles;
  for (const auto& grid : grids) {
    handles.push_back(toNanoVdb<FloatGrid, DoubleGrid, Vec3fGrid, Vec3dGrid>(labelled(grid)));
    if (!handles.back())
      throw std::runtime_error("grid '" + grid->getName() + "' is of OpenVDB's type " +
                               grid->valueType() + ", which is not written as NanoVDB");
  }
  nanovdb::io::writeGrids<nanovdb::HostBuffer, std::vector>(stream, handles,
                                                            nanovdb::io::Codec::NONE);
}

}  // namespace volute
