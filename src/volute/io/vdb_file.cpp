// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/vdb_file.hpp"

#include <openvdb/io/io.h>
#include <openvdb/util/Name.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <optional>
#include <sstream>

#include "volute/base/checksum.hpp"
#include "volute/io/nano_grids.hpp"
#include "volute/io/vdb_grid.hpp"
#include "volute/io/vdb_identifier.hpp"

namespace volute {
namespace {

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

}  // namespace

VdbFile::VdbFile(const std::filesystem::path& path) : path_(path) {
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

openvdb::GridBase::Ptr VdbFile::readTopology(std::size_t index) {
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

openvdb::GridBase::Ptr VdbFile::readTree(std::size_t index, const openvdb::CoordBBox* box) {
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

void VdbFile::takeNanoGrids() {
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

void VdbFile::readDescriptor(Entry& entry) {
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
    OPENVDB_THROW(openvdb::IoError, "a grid of type " << type << " cannot be where the file says");
  entry.foreignType = type;
  entry.grid = emptyGrid<openvdb::MaskGrid>(false);
  entry.grid->setName(openvdb::io::GridDescriptor::stripSuffix(name));
}

const VdbFile::Entry& VdbFile::parentOf(const Entry& entry) const {
  const auto parent = std::ranges::find(grids_, entry.descriptor.instanceParentName(),
                                        [](auto& e) { return e.descriptor.uniqueName(); });
  if (parent == grids_.end() || parent->descriptor.isInstance()) {
    OPENVDB_THROW(openvdb::IoError, "the grid that shares its voxels is missing");
  }
  return *parent;
}

void VdbFile::readNext(Entry& entry) {
  metadata_->setSeekable(false);
  readGrid(entry.grid, entry.descriptor, stream_);
}

void VdbFile::readDescription(Entry& entry) {
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

void overwriteIdentifier(std::ostream& stream, std::uint32_t content, int number) {
  stream.seekp(kVdbIdentifierPlace);
  stream << vdbIdentifier(content, number);
}

Status VdbOutput::add(std::ostream& stream, KeptBytes& kept, const std::string& target,
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

}  // namespace volute
