// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/bundle.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <string_view>

#include "volute/base/output_file.hpp"
#include "volute/codec/compress.hpp"
#include "volute/codec/container.hpp"
#include "volute/codec/written_file.hpp"
#include "volute/grid/bricks.hpp"

namespace volute {
namespace {

struct BundlePart {
  InputFile file;
  FileHead head;  ///< of it
};

class EmptyFrames final : public FrameSource {
 public:
  explicit EmptyFrames(const VolumeInfo& frames) {
    info_.frames = frames.frames;
    info_.frameNumbers = frames.frameNumbers;
    info_.frameScale = frames.frameScale;
    info_.times = frames.times;
    info_.timesAssumed = frames.timesAssumed;
    info_.up = frames.up;
    info_.name.clear();
    info_.x = info_.y = info_.z = 1;
    info_.fillDefaults();
  }

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int, std::span<float> values) override {
    std::ranges::fill(values, 0.0f);
    return {};
  }

  Status readBricks(int, int, int, Bricks& bricks) override {
    bricks = Bricks(info_.channels, {});
    return {};
  }

  bool hasTopology() const override { return true; }

 private:
  VolumeInfo info_;
};

/// Opens a .volute of one grid.
Result<BundlePart> openBundlePart(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(auto file, InputFile::open(path));
  VOLUTE_ASSIGN(auto head, readHeadAndPages(file, std::numeric_limits<std::uint64_t>::max()));
  if (head.grids.size() != 1) {
    return fail(ErrorCode::kInvalidArgument, "{}: holds {} grids; expected one", path.string(),
                head.grids.size());
  }
  return BundlePart{std::move(file), std::move(head)};
}

Status copyTier(const BundlePart& part, std::size_t begin, std::size_t end, OutputFile& out) {
  for (std::size_t i = begin; i < end; ++i) {
    const SegmentEntry& segment = part.head.segments[i];
    const auto bytes = readSegment(part.file, part.head, segment);
    if (!bytes) {
      return fail(ErrorCode::kInvalidData, "{}: is damaged at byte {}", part.file.path().string(),
                  segment.offset);
    }
    VOLUTE_TRY(out.write(*bytes));
  }
  return {};
}

}  // namespace

bool wantsDescription(const GridDescription& grid, bool cropped) {
  constexpr std::array<std::string_view, 4> kOwn{"volute:time", "volute:up", "volute:unit",
                                                 "is_saved_as_half_float"};
  const bool plainType = grid.type == "float" || grid.type == "vec3s";
  const bool plainClass = grid.gridClass == "fog volume";
  const bool plainMetadata =
      std::ranges::all_of(grid.metadata.lists, [&](const MetadataList& list) {
        return std::ranges::all_of(list, [&](const auto& entry) {
          return std::ranges::find(kOwn, entry.name) != kOwn.end();
        });
      });
  const bool inAllFrames =
      std::ranges::none_of(grid.metadata.listOf, [](int list) { return list < 0; });
  // Where a volume alone is written: from index 0 on, its place in the transform.
  const bool even =
      grid.voxelSize[0] == grid.voxelSize[1] && grid.voxelSize[0] == grid.voxelSize[2];
  const bool plainPlace = !cropped && grid.begin == GridDescription::Index{} &&
                          grid.shifts.empty() && grid.matrices.empty() &&
                          grid.map == (even ? "UniformScaleTranslateMap" : "ScaleTranslateMap");
  return grid.half || !plainPlace || !plainType || !plainClass || !plainMetadata || !inAllFrames ||
         grid.background != std::array<double, 3>{};
}

std::unique_ptr<FrameSource> emptyFrames(const VolumeInfo& frames) {
  return std::make_unique<EmptyFrames>(frames);
}

Result<std::uint64_t> bundle(const std::vector<BundledGrid>& grids,
                             const FrameMetadata& fileMetadata, const std::filesystem::path& target,
                             Progress& progress, KeptStore* kept, FrameSource* frames) {
  std::vector<BundlePart> parts;
  std::vector<FileHead> heads;
  std::vector<VoluteGrid> table;
  std::set<std::string> names;
  for (const BundledGrid& grid : grids) {
    if (!names.insert(grid.name).second) {
      return fail(ErrorCode::kInvalidArgument, "{}: two grids are called '{}'", target.string(),
                  grid.name);
    }
    VoluteGrid& row = table.emplace_back();
    row.info.name = grid.name;
    row.description = grid.description;
    row.empty = grid.file.empty();
    if (row.empty)
      continue;
    VOLUTE_ASSIGN(auto part, openBundlePart(grid.file));
    FileHead& head = part.head;
    head.info.name = grid.name;
    if (!heads.empty() &&
        (head.info.frameNumbers != heads.front().info.frameNumbers ||
         head.info.frameScale != heads.front().info.frameScale ||
         head.info.up != heads.front().info.up || head.info.times != heads.front().info.times)) {
      return fail(ErrorCode::kInvalidArgument, "{}: grid '{}' has other frames than '{}'",
                  target.string(), grid.name, heads.front().info.name);
    }
    if (!heads.empty() && head.header.codec != heads.front().header.codec) {
      return fail(ErrorCode::kInvalidArgument,
                  "{}: grid '{}' is of codec {} and '{}' of codec {}; expected one",
                  target.string(), grid.name, head.header.codec, heads.front().info.name,
                  heads.front().header.codec);
    }
    heads.push_back(head);
    parts.push_back(std::move(part));
  }
  if (heads.empty()) {
    if (!frames)
      return fail(ErrorCode::kInvalidArgument, "{}: no grid has values", target.string());
    VOLUTE_ASSIGN(auto file, PendingFile::create(target));
    VOLUTE_TRY(compress(*frames, file.path(), {}, progress));
    VOLUTE_ASSIGN(auto standIn, openBundlePart(file.path()));
    heads.push_back(standIn.head);
    parts.push_back(std::move(standIn));
  }
  if (kept)
    heads.front().kept = kept->table();
  const bool plain = table.size() == 1 && !table.front().empty && !table.front().description &&
                     fileMetadata.lists.empty();
  VOLUTE_ASSIGN(auto out, CheckedFile::create(target));
  const auto headBytes = plain ? writeHead(heads.front()) : writeHead(table, fileMetadata, heads);
  VOLUTE_TRY(out.bytes().write(headBytes));
  std::size_t tiers = 0;
  for (const FileHead& head : heads) tiers = std::max(tiers, head.decoder->tierLevels().size());
  for (std::size_t tier = 0; tier < tiers; ++tier) {
    for (std::size_t i = 0; i < heads.size(); ++i) {
      if (progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped: {} was not written", target.string());
      const std::size_t own = heads[i].decoder->tierLevels().size();
      const std::size_t blocks = heads[i].blocks.size();
      if (tier < own)
        VOLUTE_TRY(copyTier(parts[i], tier * blocks, (tier + 1) * blocks, out.bytes()));
    }
  }
  if (kept)
    VOLUTE_TRY(kept->copyTo(out.bytes()));
  VOLUTE_TRY(out.commit(headBytes, heads, progress));
  return heads.front().fileBytes;
}

}  // namespace volute
