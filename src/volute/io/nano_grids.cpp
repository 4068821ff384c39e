// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/nano_grids.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#include <nanovdb/util/GridValidator.h>
#include <nanovdb/util/IO.h>
#include <nanovdb/util/NanoToOpenVDB.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#pragma GCC diagnostic pop

#include <cstring>
#include <fstream>

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

/// Of any kind that OpenVDB has too.
template <class... Kinds>
openvdb::GridBase::Ptr toOpenVdb(const nanovdb::GridHandle<>& handle, bool& sound) {
  openvdb::GridBase::Ptr made;
  const auto take = [&]<class Kind>() {
    const auto* grid = made ? nullptr : handle.grid<Kind>();
    if (!grid)
      return;
    sound = grid->gridSize() == handle.size() && nanovdb::isValid(*grid, true);
    if (sound)
      made = nanovdb::nanoToOpenVDB(*grid);
  };
  (take.template operator()<Kinds>(), ...);
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
    return fail(ErrorCode::kInvalidData, "{}: not a whole NanoVDB file: {}", path.string(), why);
  };
  std::uint64_t stored = 0;
  const std::uint64_t size = std::filesystem::file_size(path);
  for (const auto& grid : io::readGridMetaData(path.string())) {
    stored += std::min(grid.fileSize, size);
    if (stored > size || (grid.codec == io::Codec::NONE && grid.gridSize > size))
      return damaged("it ends before its grids do");
  }
  std::vector<openvdb::GridBase::Ptr> grids;
  for (const auto& handle : io::readGrids<HostBuffer, std::vector>(path.string())) {
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
  using namespace nanovdb;
  std::vector<GridHandle<>> handles;
  for (const auto& grid : grids)
    handles.push_back(openToNanoVDB(grid, StatsMode::Default, ChecksumMode::Full));
  io::writeGrids<HostBuffer, std::vector>(stream, handles, io::Codec::NONE);
}

}  // namespace volute
