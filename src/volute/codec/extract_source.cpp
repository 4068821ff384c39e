// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/extract_source.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "volute/base/ordered_delivery.hpp"
#include "volute/base/parallel.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/copy_frames.hpp"

namespace volute {
namespace {

/// What comes of a level set in a file that keeps no topology: those values that lie beyond the
/// background are taken as inactive, and inside where they are negative.
class GuessedLevelSet final : public FrameSource {
 public:
  GuessedLevelSet(std::unique_ptr<FrameSource> source, float background)
      : source_(std::move(source)), background_(background) {}

  const VolumeInfo& info() const override { return source_->info(); }

  Status readFrame(int index, std::span<float> values) override {
    return source_->readFrame(index, values);
  }

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    std::vector<float> values(info().frameValues());
    VOLUTE_TRY(source_->readFrame(index, values));
    for (float& value : values) {
      if (std::abs(value) >= background_)
        value = std::copysign(background_, value);
    }
    bricks = Bricks::fromDense(info(), values, {background_, background_, background_});
    for (std::size_t i = 0; i < bricks.leaves().size(); ++i) {
      for (std::size_t voxel = 0; voxel < Bricks::kVoxels; ++voxel) {
        if (bricks.values(i)[voxel] == -background_)
          bricks.leaf(i).active[voxel / 64] &= ~(std::uint64_t{1} << voxel % 64);
      }
    }
    bricks.crop({{0, 0, first}, {info().x, info().y, end}});
    return {};
  }

 private:
  std::unique_ptr<FrameSource> source_;
  float background_;
};

constexpr int kSide = BlockGrid::kSide;

int coarse(int voxels, int level) {
  const int factor = 1 << level;
  return (voxels + factor - 1) / factor;
}

VolumeInfo extractedInfo(const VolumeInfo& whole, const Extraction& extraction) {
  const Region& region = extraction.region;
  VolumeInfo info = whole;
  info.frames = static_cast<int>(extraction.positions.size());
  info.frameNumbers.clear();
  info.times.clear();
  for (const int position : extraction.positions) {
    info.frameNumbers.push_back(whole.frameNumbers[position]);
    info.times.push_back(whole.times[position]);
  }
  info.x = coarse(region.x(), extraction.level);
  info.y = coarse(region.y(), extraction.level);
  info.z = coarse(region.z(), extraction.level);
  const Region full{{0, 0, 0}, {whole.x, whole.y, whole.z}};
  if (region == full && extraction.level == 0)
    return info;  // the bounds as they were, to the bit
  const Vec3 voxel = whole.voxelSize();
  const Vec3 begin(region.begin[0], region.begin[1], region.begin[2]);
  const Vec3 size = Vec3(info.x, info.y, info.z) * (1 << extraction.level);
  info.bounds.min = whole.bounds.min + voxel.cwiseProduct(begin);
  info.bounds.max = info.bounds.min + voxel.cwiseProduct(size);
  return info;
}

/// Means of cubes of 2^level voxels of `fine`, shape (z, y, x, c) of the region; beyond it they
/// count the background.
void averageCubes(std::span<const float> fine, const Region& region, int level,
                  const VolumeInfo& info, const std::array<float, 3>& background,
                  std::span<float> values) {
  const int channels = info.channels;
  std::vector<double> sums(info.frameValues());
  for (int z = 0; z < region.z(); ++z) {
    for (int y = 0; y < region.y(); ++y) {
      const std::size_t row =
          (static_cast<std::size_t>(z >> level) * info.y + (y >> level)) * info.x;
      const float* in =
          fine.data() + (static_cast<std::size_t>(z) * region.y() + y) * region.x() * channels;
      for (int x = 0; x < region.x(); ++x) {
        for (int c = 0; c < channels; ++c) sums[(row + (x >> level)) * channels + c] += *in++;
      }
    }
  }
  const auto full = static_cast<double>(std::int64_t{1} << (3 * level));
  // How many voxels of the region a cube has along an axis.
  const auto within = [level](int cube, int voxels) {
    return std::min(1 << level, voxels - (cube << level));
  };
  std::size_t i = 0;
  for (int z = 0; z < info.z; ++z) {
    for (int y = 0; y < info.y; ++y) {
      for (int x = 0; x < info.x; ++x) {
        const double beyond =
            full - static_cast<double>(std::int64_t{within(z, region.z())} * within(y, region.y()) *
                                       within(x, region.x()));
        for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c, ++i)
          values[i] = static_cast<float>((sums[i] + beyond * background[c]) / full);
      }
    }
  }
}

}  // namespace

ExtractSource::ExtractSource(std::shared_ptr<const VoluteReader> reader, Extraction extraction,
                             Progress& progress)
    : reader_(std::move(reader)),
      extraction_(std::move(extraction)),
      progress_(progress),
      info_(extractedInfo(reader_->info(), extraction_)) {}

Result<std::unique_ptr<ExtractSource>> ExtractSource::create(
    std::shared_ptr<const VoluteReader> reader, Extraction extraction, Progress& progress) {
  const VolumeInfo& info = reader->info();
  const Region& region = extraction.region;
  if (region.end[0] > info.x || region.end[1] > info.y || region.end[2] > info.z) {
    return fail(ErrorCode::kInvalidArgument,
                "the region ends at {}, {}, {}, beyond the {} x {} x {} voxels of the volume",
                region.end[0], region.end[1], region.end[2], info.x, info.y, info.z);
  }
  auto source = std::unique_ptr<ExtractSource>(
      new ExtractSource(std::move(reader), std::move(extraction), progress));
  // The frames of a row, or as many of them as there is room for; and one that is made of them.
  const std::uint64_t frame = 4ull * source->frameValues();
  if (source->keepsTopology() && source->extraction_.bricks)
    return source;
  if (2 * frame > source->extraction_.maxMemory) {
    return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                "the region needs {} MiB of memory, more than the {} MiB allowed; take a smaller "
                "region",
                (2 * frame >> 20) + 1, source->extraction_.maxMemory >> 20);
  }
  source->framesAtOnce_ = std::min<std::size_t>(
      kSide, std::max<std::uint64_t>(frame, source->extraction_.maxMemory) / frame - 1);
  return source;
}

std::vector<std::size_t> ExtractSource::blocksOfRow(int row) const {
  const Region& r = extraction_.region;
  std::vector<std::size_t> blocks;
  for (int z = r.begin[2] / kSide; z * kSide < r.end[2]; ++z) {
    for (int y = r.begin[1] / kSide; y * kSide < r.end[1]; ++y) {
      for (int x = r.begin[0] / kSide; x * kSide < r.end[0]; ++x) {
        blocks.push_back(reader_->blocks().blockAt({row, z, y, x}));
      }
    }
  }
  return blocks;
}

Status ExtractSource::load(std::size_t index) {
  const auto& positions = extraction_.positions;
  const BlockGrid& grid = reader_->blocks();
  const int row = grid.rowOf(positions[index]);
  firstLoaded_ = index;
  loaded_ = 0;
  std::size_t count = 0;
  while (count < framesAtOnce_ && index + count < positions.size() &&
         grid.rowOf(positions[index + count]) == row)
    ++count;
  row_.assign(count * frameValues(), 0.0f);
  const auto blocks = blocksOfRow(row);
  constexpr std::size_t kBatch = 256;  // between batches one may ask to stop
  for (std::size_t begin = 0; begin < blocks.size(); begin += kBatch) {
    if (progress_.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: reading frames from {} on",
                  positions[firstLoaded_]);
    const std::size_t batch = std::min(kBatch, blocks.size() - begin);
    std::vector<Status> results(batch);
    parallelFor(batch, [&](std::size_t i) { results[i] = loadBlock(blocks[begin + i]); });
    for (Status& result : results) VOLUTE_TRY(std::move(result));
  }
  loaded_ = count;
  return {};
}

Status ExtractSource::loadBlock(std::size_t block) {
  const BlockGrid& grid = reader_->blocks();
  const auto origin = grid.origin(block);
  const auto extents = grid.extents(block);
  const Region& r = extraction_.region;
  const int channels = info_.channels;
  std::vector<float> values(grid.values(block));

  // The mean of a block stands apart. Other coarse levels are read together; with all of them means
  // come out better.
  constexpr int kReadTogether = 3;
  const int levels = grid.levels(block) - extraction_.level;
  const auto frames =
      std::span(extraction_.positions).subspan(firstLoaded_, row_.size() / frameValues());
  const auto [first, last] = std::ranges::minmax(frames);
  VOLUTE_TRY(reader_->readBlock(block, values, levels > 1 ? std::max(kReadTogether, levels) : 1,
                                {first - origin[0], last + 1 - origin[0]}));

  const int x0 = std::max(origin[3], r.begin[0]), x1 = std::min(origin[3] + extents[3], r.end[0]);
  const int y0 = std::max(origin[2], r.begin[1]), y1 = std::min(origin[2] + extents[2], r.end[1]);
  const int z0 = std::max(origin[1], r.begin[2]), z1 = std::min(origin[1] + extents[1], r.end[2]);
  for (std::size_t i = 0; i < row_.size() / frameValues(); ++i) {
    const int t = extraction_.positions[firstLoaded_ + i] - origin[0];
    float* frame = row_.data() + i * frameValues();
    for (int z = z0; z < z1; ++z) {
      for (int y = y0; y < y1; ++y) {
        const std::size_t from =
            ((static_cast<std::size_t>(t) * extents[1] + (z - origin[1])) * extents[2] +
             (y - origin[2])) *
                extents[3] +
            (x0 - origin[3]);
        const std::size_t to =
            (static_cast<std::size_t>(z - r.begin[2]) * r.y() + (y - r.begin[1])) * r.x() +
            (x0 - r.begin[0]);
        std::copy_n(values.data() + from * channels, static_cast<std::size_t>(x1 - x0) * channels,
                    frame + to * channels);
      }
    }
  }
  return {};
}

// Those of a row that are selected are decoded together, where there is room for a row.
Status ExtractSource::loadBricks(std::size_t index) {
  const auto& positions = extraction_.positions;
  const BlockGrid& grid = reader_->blocks();
  const int first = positions[index], row = grid.rowOf(first);
  int last = first;
  if (reader_->brickBytes(row) <= reader_->maxMemory()) {
    for (std::size_t i = index; i < positions.size() && grid.rowOf(positions[i]) == row; ++i)
      last = std::max(last, positions[i]);
  }
  bricks_.clear();
  std::vector<Bricks> read(static_cast<std::size_t>(last + 1 - first));
  VOLUTE_TRY(reader_->readBricks(first, last + 1, read));
  bricks_ = std::move(read);
  firstBricks_ = first;
  return {};
}

bool ExtractSource::keepsTopology() const {
  return reader_->hasTopology() && extraction_.level == 0;
}

Status ExtractSource::readBricks(int index, int first, int end, Bricks& bricks) {
  if (progress_.cancelled()) {
    return fail(ErrorCode::kCancelled, "stopped: reading frame {}",
                extraction_.positions[static_cast<std::size_t>(index)]);
  }
  if (!keepsTopology() || !extraction_.bricks) {
    std::vector<float> values(info_.frameValues());
    VOLUTE_TRY(readFrame(index, values));
    bricks = Bricks::fromDense(info_, values, reader_->background());
    return {};
  }
  const Region& r = extraction_.region;
  const int position = extraction_.positions[static_cast<std::size_t>(index)];
  if (position < firstBricks_ || position >= firstBricks_ + static_cast<int>(bricks_.size()))
    VOLUTE_TRY(loadBricks(static_cast<std::size_t>(index)));
  bricks = bricks_[static_cast<std::size_t>(position - firstBricks_)];
  const VolumeInfo& all = reader_->info();
  if (first > 0 || end < r.z())
    bricks.crop({{0, 0, r.begin[2] + first}, {all.x, all.y, r.begin[2] + end}});
  if (r != Region{{0, 0, 0}, {all.x, all.y, all.z}})
    bricks.crop({{r.begin[0], r.begin[1], r.begin[2]}, {r.end[0], r.end[1], r.end[2]}});
  bricks.shift({-r.begin[0], -r.begin[1], -r.begin[2]});
  return {};
}

Status ExtractSource::readFrame(int index, std::span<float> values) {
  const auto wanted = static_cast<std::size_t>(index);
  if (wanted < firstLoaded_ || wanted >= firstLoaded_ + loaded_)
    VOLUTE_TRY(load(wanted));
  const auto frame =
      std::span<const float>(row_).subspan((wanted - firstLoaded_) * frameValues(), frameValues());
  if (extraction_.level == 0) {
    std::ranges::copy(frame, values.begin());
  } else {
    averageCubes(frame, extraction_.region, extraction_.level, info_, reader_->background(),
                 values);
  }
  // Coarse levels, asked for or all that is intact, may leave the original's range.
  const VoluteHeader& header = reader_->header();
  const auto around = reader_->background();
  const auto outside = std::span(around).first(static_cast<std::size_t>(info_.channels));
  const auto least =
      std::min(static_cast<float>(std::min(0.0, header.valueMin) - reader_->offset()),
               *std::ranges::min_element(outside));
  const auto most = std::max(static_cast<float>(std::max(0.0, header.valueMax) - reader_->offset()),
                             *std::ranges::max_element(outside));
  for (float& value : values) value = std::clamp(value, least, most);
  return {};
}

Region fittingRegion(const VoluteReader& reader, std::span<const int> positions,
                     std::uint64_t maxVoxels) {
  const BlockGrid& grid = reader.blocks();
  const VolumeInfo& info = reader.info();
  const std::array<int, 3> size{info.x, info.y, info.z};
  Region region{size, {0, 0, 0}};
  // An index that cannot be read is told when its values are.
  const auto occupied = reader.occupied().value_or(std::vector<std::uint64_t>());
  for (const std::uint64_t block : occupied) {
    const auto origin = grid.origin(static_cast<std::size_t>(block));
    const bool chosen = std::ranges::any_of(
        positions, [&](int position) { return grid.rowOf(position) == grid.rowOf(origin[0]); });
    for (std::size_t axis = 0; axis < 3 && chosen; ++axis) {
      const int first = origin[3 - axis];
      region.begin[axis] = std::min(region.begin[axis], first);
      region.end[axis] = std::max(region.end[axis], std::min(first + kSide, size[axis]));
    }
  }
  if (region.begin[0] >= region.end[0])
    region = {{0, 0, 0}, size};
  // The longest side is cut first.
  const auto side = [&](std::size_t axis) {
    return static_cast<double>(region.end[axis] - region.begin[axis]);
  };
  while (side(0) * side(1) * side(2) > static_cast<double>(maxVoxels)) {
    std::size_t longest = 0;
    for (const std::size_t axis : {1, 2}) longest = side(axis) > side(longest) ? axis : longest;
    const int kept = std::max(1, static_cast<int>(side(longest) * 0.9));
    if (kept == 1 && side(longest) == 1)
      break;
    region.begin[longest] += (static_cast<int>(side(longest)) - kept) / 2;
    region.end[longest] = region.begin[longest] + kept;
  }
  return region;
}

std::unique_ptr<FrameSource> withLevelSet(const VoluteReader& reader,
                                          std::unique_ptr<FrameSource> source) {
  const auto& description = reader.grid().description;
  if (reader.hasTopology() || !description || description->gridClass != "level set" ||
      !(description->background[0] > 0))
    return source;
  return std::make_unique<GuessedLevelSet>(std::move(source),
                                           static_cast<float>(description->background[0]));
}

}  // namespace volute
