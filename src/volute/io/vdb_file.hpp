// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

// What OpenVDB reads and writes as files, and what of it we do ourselves.
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/io/lattice.hpp"

namespace volute {

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
  explicit VdbFile(const std::filesystem::path& path);

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
  openvdb::GridBase::Ptr readTopology(std::size_t index);

  /// @param box  [voxels] what lies outside of it is left in the file; null: nothing is
  openvdb::GridBase::Ptr readTree(std::size_t index, const openvdb::CoordBBox* box = nullptr);

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

  void takeNanoGrids();

  /// As GridDescriptor::read(), which refuses types that are not registered.
  void readDescriptor(Entry& entry);

  /// The grid whose voxels an instance shares.
  const Entry& parentOf(const Entry& entry) const;

  /// The grid that comes next in a file that does not say where its grids are.
  void readNext(Entry& entry);

  void readDescription(Entry& entry);

  std::filesystem::path path_;
  // The stream keeps the address of this pointer.
  openvdb::io::StreamMetadata::Ptr metadata_ = std::make_shared<openvdb::io::StreamMetadata>();
  std::ifstream stream_;
  openvdb::MetaMap fileMetadata_;
  std::vector<Entry> grids_;
  bool whole_ = false;  ///< grids_ hold their trees
};

/// OpenVDB writes a random identifier into each file; one that follows from the content keeps equal
/// inputs equal.
void overwriteIdentifier(std::ostream& stream, std::uint32_t content, int number);

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
                    std::uint32_t& content);
};

}  // namespace volute
