// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/volume_extraction.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <ranges>

#include "volute/base/ordered_delivery.hpp"
#include "volute/codec/extract_source.hpp"
#include "volute/codec/kept_grids.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/copy_frames.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/output_names.hpp"
#include "volute/io/vdb_identifier.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/volume_files/fds_input.hpp"
#include "volute/volume_files/volume_grids.hpp"
#include "volute/volume_files/volume_input.hpp"
#include "volute/volume_files/volume_writer.hpp"

namespace volute {
namespace {

/// Grids of a .volute that are taken out of it together.
struct ExtractedGrids {
  std::vector<GridTarget> targets;                           ///< what becomes of each
  std::vector<std::unique_ptr<FrameSource>> sources;         ///< of each; null: it is empty
  std::vector<std::shared_ptr<const VoluteReader>> readers;  ///< the same
  std::vector<KeptTarget> kept;                              ///< grids that go out as their bytes
  std::vector<std::string> keptNames;                        ///< of each of those
  FrameMetadata fileMetadata;
  std::vector<int> positions;  ///< of the frames in the file, ascending
};

/// Where values go, made on rank 0 alone.
using MakeSink = std::function<Result<std::unique_ptr<CacheSink>>()>;

constexpr std::string_view kGridWord = "{grid}", kMeshWord = "{mesh}";

using GridValues = std::vector<Bricks>;

Status readFrames(const std::vector<std::unique_ptr<FrameSource>>& sources, int index,
                  GridValues& values) {
  values.resize(sources.size());
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (sources[i])
      VOLUTE_TRY(sources[i]->readBricks(index, values[i]));
  }
  return {};
}

/// What the cache says of a grid, of these frames of it and at this level.
GridDescription descriptionOf(const VoluteGrid& grid, const Extraction& extraction) {
  if (!grid.description)
    return {.type = grid.info.channels == 3 ? "vec3s" : "float", .gridClass = "fog volume"};
  GridDescription one = grid.description->of(extraction.positions);
  if (extraction.level == 0) {
    for (std::size_t axis = 0; axis < 3; ++axis) one.begin[axis] += extraction.region.begin[axis];
    return one;
  }
  one.map.clear();  // voxels of another size: the bounds say where they are
  one.begin = {};
  one.shifts.clear();
  return one;
}

/// Means of a coarser level are floats.
Offsets offsetsAt(int level) {
  return level == 0 ? Offsets::kOfRounded : Offsets::kNone;
}

/// Some frames of a volume.
/// @param rate  of all of its frames, instead of its own times
VolumeInfo framesAt(VolumeInfo info, const std::vector<int>& positions,
                    const std::optional<double>& rate = {}) {
  if (rate)
    info.setRate(*rate);
  std::vector<int> numbers;
  std::vector<double> times;
  for (const int position : positions) {
    numbers.push_back(info.frameNumbers[static_cast<std::size_t>(position)]);
    times.push_back(info.times[static_cast<std::size_t>(position)]);
  }
  info.frames = static_cast<int>(positions.size());
  info.frameNumbers = std::move(numbers), info.times = std::move(times);
  return info;
}

bool isKept(const VoluteReader& reader, const std::string& name) {
  return std::ranges::find(reader.kept().grids, name, &KeptGrid::name) != reader.kept().grids.end();
}

/// One of the grids that a file keeps as bytes, between the coded ones called `names`.
KeptTarget keptTarget(const std::shared_ptr<const VoluteReader>& main, const std::string& name,
                      const std::vector<std::string>& names, const std::vector<int>& positions,
                      bool partial, Reading& reading) {
  const auto& kept = main->kept().grids;
  const auto at = std::ranges::find(kept, name, &KeptGrid::name);
  KeptTarget target;
  for (std::size_t row = 0; row < std::min(at->place, main->grids().size()); ++row)
    target.place +=
        static_cast<std::size_t>(std::ranges::count(names, main->grids()[row].info.name));
  target.open = [main, grid = static_cast<std::size_t>(at - kept.begin()), positions, partial,
                 &reading](int position) -> Result<std::unique_ptr<KeptBytes>> {
    const int frame = positions[static_cast<std::size_t>(position)];
    auto bytes = main->keptBytes(grid, frame);
    // Only what is whole of a damaged file is given out.
    for (auto tried = partial && bytes ? main->keptBytes(grid, frame) : nullptr; tried;) {
      const auto part = tried->next();
      if (!part) {
        reading.progress.remark(
            {RemarkCode::kLeftOut,
             fmt::format("{}; '{}' is left out of frame {}", part.error().message,
                         main->kept().grids[grid].name,
                         main->info().frameText(static_cast<std::size_t>(frame)))});
        return nullptr;
      }
      if (part->empty())
        break;
    }
    return bytes;
  };
  return target;
}

/// Opens the grids called `names`.
/// @param extraction  `region` is of one grid; else whole grids are taken
Result<ExtractedGrids> openGrids(const std::string& path, const std::vector<std::string>& wanted,
                                 const Extraction& extraction, bool isPart, bool partial,
                                 Reading& reading) {
  ExtractedGrids all;
  all.positions = extraction.positions;
  VOLUTE_ASSIGN(const auto main, openVolute(path, partial, reading, false));
  std::vector<std::string> names;
  for (const std::string& name : wanted)
    (isKept(*main, name) ? all.keptNames : names).push_back(name);
  for (const std::string& name : all.keptNames)
    all.kept.push_back(keptTarget(main, name, names, extraction.positions, partial, reading));
  all.fileMetadata = main->fileMetadata();
  if (!all.fileMetadata.listOf.empty())
    all.fileMetadata = all.fileMetadata.of(extraction.positions);
  double voxels = 0;  // of all, to share the memory out
  for (const VoluteGrid& grid : main->grids()) {
    if (std::ranges::find(names, grid.info.name) != names.end())
      voxels += static_cast<double>(grid.info.frameValues());
  }
  for (const std::string& name : names) {
    const auto grid = std::ranges::find_if(
        main->grids(), [&](const VoluteGrid& one) { return one.info.name == name; });
    GridTarget& target = all.targets.emplace_back();
    Extraction own = extraction;
    if (!isPart)
      own.region = {{0, 0, 0}, {grid->info.x, grid->info.y, grid->info.z}};
    target.description = descriptionOf(*grid, own);
    if (grid->info.channels == 3 && extraction.level > 0 &&
        target.description.gridClass == kStaggered) {
      reading.progress.remark(
          Remark(RemarkCode::kDoubtful,
                 fmt::format("{}: '{}' is staggered: means of its faces lie half a voxel of the "
                             "full resolution beyond those of the level; resampled ones lie on "
                             "them",
                             path, name))
              .in(path));
    }
    if (grid->empty) {
      target.info = framesAt(grid->info, extraction.positions);
      all.sources.push_back(nullptr);
      all.readers.push_back(nullptr);
      continue;
    }
    VOLUTE_ASSIGN(auto reader,
                  openVolute(path, partial, reading, true, name, offsetsAt(extraction.level)));
    target.offset = reader->offset();
    if (target.offset != 0)
      target.description.type = grid->info.channels == 3 ? "vec3d" : "double";
    own.bricks = true;
    own.maxMemory =
        static_cast<std::uint64_t>(static_cast<double>(extraction.maxMemory) *
                                   static_cast<double>(grid->info.frameValues()) / voxels);
    VOLUTE_ASSIGN(auto source, ExtractSource::create(reader, std::move(own), reading.progress));
    target.info = source->info();
    all.sources.push_back(withLevelSet(*reader, std::move(source)));
    all.readers.push_back(std::move(reader));
  }
  return all;
}

/// Hands all frames to the sink in order. The frames of a row of blocks are a unit of work for the
/// ranks; rank 0 writes. Collective.
/// @param sources  null ones give no values
/// @param positions  of the frames in the file
Status extractFrames(const std::vector<std::unique_ptr<FrameSource>>& sources,
                     const std::vector<int>& positions, const MakeSink& makeSink, Reading& reading,
                     Team& team) {
  const auto frames = static_cast<std::int64_t>(positions.size());
  std::unique_ptr<CacheSink> sink;
  const auto make = [&]() -> Status {
    VOLUTE_ASSIGN(sink, makeSink());
    return {};
  };
  VOLUTE_TRY(team.agree(team.leads() ? make() : Status()));
  GridValues values;
  if (team.size() == 1) {
    for (std::int64_t i = 0; i < frames; ++i) {
      if (reading.progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped: extracting frame {} of {}", i + 1, frames);
      VOLUTE_TRY(readFrames(sources, static_cast<int>(i), values));
      VOLUTE_TRY(sink->writeFrame(values));
      reading.progress.report("extracting", static_cast<double>(i + 1),
                              static_cast<double>(frames));
    }
    return sink->finish();
  }
  std::vector<std::size_t> begins;  // of rows
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (i == 0 || positions[i] / BlockGrid::kSide != positions[i - 1] / BlockGrid::kSide)
      begins.push_back(i);
  }
  begins.push_back(positions.size());
  // Each grid after the length of its message.
  OrderedDelivery delivery(team, frames, reading.maxMemory / 8,
                           [&](std::int64_t, const OrderedDelivery::Bytes& bytes) -> Status {
                             GridValues taken;
                             std::span<const std::byte> left = bytes;
                             while (!left.empty()) {
                               std::uint64_t size = 0;
                               std::memcpy(&size, left.data(), sizeof size);
                               left = left.subspan(sizeof size);
                               VOLUTE_ASSIGN(auto one, Bricks::fromMessage(left.first(size)));
                               taken.push_back(std::move(one));
                               left = left.subspan(size);
                             }
                             return sink->writeFrame(taken);
                           });
  VOLUTE_TRY(team.forUnits(
      "extracting", static_cast<std::int64_t>(begins.size() - 1), reading.progress,
      [&](std::int64_t row) -> Status {
        const auto at = static_cast<std::size_t>(row);
        for (std::size_t i = begins[at]; i < begins[at + 1]; ++i) {
          if (reading.progress.cancelled())
            return fail(ErrorCode::kCancelled, "stopped: extracting frame {} of {}", i + 1, frames);
          VOLUTE_TRY(readFrames(sources, static_cast<int>(i), values));
          OrderedDelivery::Bytes bytes;
          for (const Bricks& grid : values) {
            const std::uint64_t size = grid.messageBytes();
            const std::size_t begin = bytes.size() + sizeof size;
            bytes.resize(begin + size);
            std::memcpy(bytes.data() + begin - sizeof size, &size, sizeof size);
            grid.toMessage(std::span(bytes).subspan(begin));
          }
          VOLUTE_TRY(delivery.give(static_cast<std::int64_t>(i), std::move(bytes)));
        }
        return {};
      },
      [&] { return delivery.finish(); }));
  return team.agree(sink ? sink->finish() : Status());
}

/// A sink of one grid as one of several.
class OneGridSink final : public CacheSink {
 public:
  OneGridSink(std::unique_ptr<FrameSink> sink, const VolumeInfo& info)
      : sink_(std::move(sink)), info_(info) {}

  Status writeFrame(std::span<const Bricks> grids) override {
    if (sink_->takesBricks())
      return sink_->writeBricks(grids[0]);
    values_.resize(info_.frameValues());
    grids[0].toDense({{0, 0, 0}, {info_.x, info_.y, info_.z}}, values_);
    return sink_->writeFrame(values_);
  }

  Status finish() override { return sink_->finish(); }

 private:
  std::unique_ptr<FrameSink> sink_;
  VolumeInfo info_;
  std::vector<float> values_;
};

/// @param counts  bytes read, blocks decoded
void addReads(Report& report, std::span<const std::uint64_t> counts, std::size_t blocks) {
  report.add("bytes_read", counts[0], bytesText(counts[0]))
      .add("blocks_decoded", counts[1],
           counts[1] > blocks ? fmt::format("{}, some of {} again and again", counts[1], blocks)
                              : fmt::format("{} of {}", counts[1], blocks));
}

/// `name` in place of {word}.
std::string filledIn(std::string target, std::string_view word, const std::string& name) {
  const auto place = target.find(word);
  return place == std::string::npos ? target : target.replace(place, word.size(), name);
}

/// Takes things out of one file.
class Extractor {
 public:
  Extractor(const std::string& path, const ExtractionRequest& request, const Extracted& extracted,
            Reading& reading, Team& team)
      : path_(path), request_(request), extracted_(extracted), reading_(reading), team_(team) {}

  /// One grid, to a file of any format.
  Status one(const std::string& grid, const std::string& target);

  /// Several grids, or one with what a cache says of it, to .vdb files.
  Status cache(const std::vector<std::string>& names, const std::string& target,
               const VolumeInfo& frames);

  /// Voxels of extinction out of an FDS case: all meshes together, or one.
  Status fds(const std::string& target, std::optional<int> mesh);

 private:
  Result<Extraction> extractionOf(const VolumeInfo& info) const;

  const std::string& path_;
  const ExtractionRequest& request_;
  const Extracted& extracted_;
  Reading& reading_;
  Team& team_;
};

Result<Extraction> Extractor::extractionOf(const VolumeInfo& info) const {
  Extraction extraction;
  VOLUTE_ASSIGN(extraction.positions, selectPositions(info, request_.frames));
  extraction.region = request_.region.value_or(Region{{0, 0, 0}, {info.x, info.y, info.z}});
  extraction.level = request_.level;
  extraction.maxMemory = reading_.maxMemory;
  return extraction;
}

/// What the voxels take of the largest of some frames. Looks up no others: a file may have many.
std::uint64_t brickBytes(const VoluteReader& reader, std::span<const int> positions) {
  const BlockGrid& grid = reader.blocks();
  std::uint64_t most = 0;
  int last = -1;
  for (const int position : positions) {
    const int row = grid.rowOf(position);
    if (row == last)
      continue;
    last = row;
    const int frames = grid.endOfRow(row) - row * grid.frames();
    most = std::max(most, reader.brickBytes(row) / static_cast<std::uint64_t>(frames));
  }
  return most;
}

/// The voxels of a frame of .vdb files, as they are read and as they are written.
Status checkBricks(std::span<const std::shared_ptr<const VoluteReader>> readers,
                   std::span<const int> positions, const std::string& path,
                   std::uint64_t maxMemory) {
  std::uint64_t needed = 0;
  for (const auto& reader : readers)
    needed += reader && reader->hasTopology() ? 2 * brickBytes(*reader, positions) : 0;
  if (needed <= maxMemory)
    return {};
  return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
              "{}: the voxels of a frame need {} MiB of memory, more than the {} MiB allowed", path,
              (needed >> 20) + 1, maxMemory >> 20);
}

Status Extractor::one(const std::string& grid, const std::string& target) {
  VOLUTE_ASSIGN(auto reader, openVolute(path_, request_.partial, reading_, true, grid,
                                        offsetsAt(request_.level)));
  VOLUTE_ASSIGN(auto extraction, extractionOf(reader->info()));
  const std::vector<int> positions = extraction.positions;
  if (const auto& description = reader->grid().description;
      description && !description->matrices.empty() && extensionOf(target) != ".npy" &&
      target != "-") {
    return fail(ErrorCode::kUnsupported,
                "{}: '{}' is turned, or moves by parts of a voxel, which this output cannot say; "
                "expected whole .vdb files at full resolution, or .npy",
                target, reader->info().name);
  }
  extraction.bricks = isVdbPath(target);
  const std::uint64_t needed = 8 * extraction.region.voxels() * reader->info().channels;
  if (!extraction.bricks && needed > reading_.maxMemory) {
    const Region fits =
        fittingRegion(*reader, positions,
                      reading_.maxMemory / 8 / static_cast<std::uint64_t>(reader->info().channels));
    return fail(ErrorCode::kTooLarge,
                "{}: a file of this format holds all {} x {} x {} voxels of a frame, which need {} "
                "MiB of memory, more than the {} MiB allowed; the region {}:{},{}:{},{}:{} fits{}",
                target, extraction.region.x(), extraction.region.y(), extraction.region.z(),
                (needed >> 20) + 1, reading_.maxMemory >> 20, fits.begin[0], fits.end[0],
                fits.begin[1], fits.end[1], fits.begin[2], fits.end[2],
                checkBricks(std::array{reader}, positions, path_, reading_.maxMemory)
                    ? ", and so does .vdb"
                    : "");
  }
  if (extraction.bricks && extraction.level == 0)
    VOLUTE_TRY(checkBricks(std::array{reader}, positions, path_, reading_.maxMemory));
  VOLUTE_ASSIGN(auto source,
                ExtractSource::create(reader, std::move(extraction), reading_.progress));
  VolumeInfo info = source->info();
  info.times = framesAt(reader->info(), positions, request_.framesPerSecond).times;
  const auto& said = reader->grid().description;
  info.levelSet = info.levelSet || (said && said->gridClass == "level set");
  remarkOnWhatIsLost(info, {.turned = said && !said->matrices.empty()}, target, reading_);
  const auto open = [&] { return createSink(target, info, {.offset = reader->offset()}); };
  if (team_.size() == 1) {
    VOLUTE_ASSIGN(const auto sink, open());
    VOLUTE_TRY(copyFrames(*source, *sink, "extracting", reading_.progress));
  } else {
    std::vector<std::unique_ptr<FrameSource>> sources;
    sources.push_back(std::move(source));
    const MakeSink make = [&]() -> Result<std::unique_ptr<CacheSink>> {
      VOLUTE_ASSIGN(auto sink, open());
      return std::make_unique<OneGridSink>(std::move(sink), info);
    };
    VOLUTE_TRY(extractFrames(sources, positions, make, reading_, team_));
  }
  std::array<std::uint64_t, 2> counts{reader->bytesRead(), reader->blocksDecoded()};
  VOLUTE_TRY(team_.sum(counts));
  Report report;
  report.add("output", target);
  addSize(report, info);
  report.add("channels", info.channels, fmt::format("{}", info.channels));
  addReads(report, counts, reader->blocks().count());
  return extracted_(report);
}

Status Extractor::cache(const std::vector<std::string>& names, const std::string& target,
                        const VolumeInfo& frames) {
  VOLUTE_ASSIGN(const auto extraction, extractionOf(frames));
  VOLUTE_ASSIGN(auto grids, openGrids(path_, names, extraction, request_.region.has_value(),
                                      request_.partial, reading_));
  if (extraction.level == 0)
    VOLUTE_TRY(checkBricks(grids.readers, grids.positions, path_, reading_.maxMemory));
  const VolumeInfo numbers = framesAt(frames, grids.positions, request_.framesPerSecond);
  for (GridTarget& grid : grids.targets) grid.info.times = numbers.times;
  const auto says = [](const FrameMetadata& of) {
    return std::ranges::any_of(of.lists, [](const auto& list) { return !list.empty(); });
  };
  const bool metadata =
      says(grids.fileMetadata) || std::ranges::any_of(grids.targets, [&](const GridTarget& grid) {
        return says(grid.description.metadata);
      });
  VolumeInfo all = numbers;
  for (const GridTarget& grid : grids.targets)
    all.unit = all.unit.empty() ? grid.info.unit : all.unit;
  remarkOnWhatIsLost(all, {.metadata = metadata}, target, reading_);
  const MakeSink make = [&] {
    return createCacheSink(target, grids.targets, grids.fileMetadata, grids.kept, &numbers);
  };
  VOLUTE_TRY(extractFrames(grids.sources, grids.positions, make, reading_, team_));
  std::array<std::uint64_t, 2> counts{};
  std::size_t blocks = 0;
  for (const auto& reader : grids.readers) {
    if (!reader)
      continue;
    counts[0] += reader->bytesRead(), counts[1] += reader->blocksDecoded();
    blocks += reader->blocks().count();
  }
  VOLUTE_TRY(team_.sum(counts));
  auto list = nlohmann::ordered_json::array();
  std::string text;
  for (const GridTarget& grid : grids.targets) {
    const VolumeInfo& info = grid.info;
    list.push_back({{"name", info.name},
                    {"size", {info.x, info.y, info.z}},
                    {"channels", info.channels},
                    {"half", grid.description.half}});
    text += fmt::format(
        "\n  {:<16} {}", info.name,
        info.x == 0 ? std::string("empty")
                    : fmt::format("{} x {} x {}, {}{}", info.x, info.y, info.z,
                                  grid.description.type, grid.description.half ? " (half)" : ""));
  }
  for (const std::string& name : grids.keptNames) {
    list.push_back({{"name", name}, {"kept", true}});
    text += fmt::format("\n  {:<16} as it was", name);
  }
  Report report;
  report.add("output", target)
      .add("frames", grids.positions.size(), fmt::format("{}", grids.positions.size()))
      .add("grids", list, text);
  addReads(report, counts, blocks);
  return extracted_(report);
}

Status Extractor::fds(const std::string& target, std::optional<int> mesh) {
  VOLUTE_ASSIGN(auto volume, openFdsVolume(path_, request_.fields, std::nullopt, mesh, reading_));
  remarkOnRange(path_, volume->info(), request_.frames, reading_);
  VOLUTE_ASSIGN(auto source, selectFrames(std::move(volume), request_.frames));
  remarkOnWhatIsLost(source->info(), {}, target, reading_);
  remarkOnOtherFrames(target, source->info(), reading_);
  VOLUTE_ASSIGN(auto sink, createSink(target, source->info()));
  VOLUTE_TRY(copyFrames(*source, *sink, "extracting", reading_.progress));
  Report report;
  report.add("output", target);
  addSize(report, source->info());
  return extracted_(report);
}

/// Who extracts into the folder of a cache loses it.
/// @param info  of the frames that are written
void remarkOnReplaced(const std::string& path, const std::string& target, const VolumeInfo& info,
                      Reading& reading) {
  if (extensionOf(target) != ".vdb")
    return;
  std::vector<std::filesystem::path> there;
  if (namesSeries(target)) {
    const auto pattern = FramePattern::parse(target);
    for (std::size_t i = 0; pattern && i < info.frameNumbers.size(); ++i)
      there.push_back(pattern->format(info.frameNumbers[i], info.frameScale));
  } else {
    there.emplace_back(target);
  }
  std::erase_if(there, [](const std::filesystem::path& file) {
    std::error_code none;
    return !std::filesystem::is_regular_file(file, none) || hasOwnIdentifier(file);
  });
  if (there.empty())
    return;
  const std::string first = there.front().string();
  const std::string all = there.size() == 1
                              ? first + " was not written by Volute and is"
                              : fmt::format("{} and {} more were not written by Volute and are",
                                            first, there.size() - 1);
  reading.progress.remark(
      Remark(RemarkCode::kDoubtful,
             fmt::format("{} replaced: is that what {} was made of?", all, path))
          .in(first));
}

/// The names of the outputs of all meshes are checked first.
Status checkMeshNames(const std::string& target, const ExtractionRequest& request, int meshes) {
  OutputNames outputs;
  for (const std::string& taken : request.taken) VOLUTE_TRY(outputs.add(taken, "another output"));
  for (int mesh = 0; !request.taken.empty() && mesh < meshes; ++mesh) {
    VOLUTE_TRY(outputs.add(filledIn(target, kMeshWord, fmt::format("{:04}", mesh + 1)),
                           fmt::format("mesh {}", mesh + 1)));
  }
  return {};
}

}  // namespace

bool namesEachGrid(const std::string& target) {
  return target.find(kGridWord) != std::string::npos;
}

Status checkWords(const std::string& target, std::string_view known) {
  const std::string name = std::filesystem::path(target).filename().string();
  for (auto begin = name.find('{'); begin != name.npos; begin = name.find('{', begin + 1)) {
    const auto end = name.find_first_not_of("abcdefghijklmnopqrstuvwxyz", begin + 1);
    if (end == name.npos || name[end] != '}' || end == begin + 1)
      continue;
    if (const auto word = name.substr(begin, end + 1 - begin); word != known) {
      return failFor("output", ErrorCode::kInvalidArgument,
                     "'{}' has {}, which nothing is filled in for; expected {} or none", target,
                     word, known);
    }
  }
  return {};
}

bool namesEachMesh(const std::string& target) {
  return target.find(kMeshWord) != std::string::npos;
}

std::string nameOfGrid(std::string target, const std::string& grid) {
  return filledIn(std::move(target), kGridWord, grid);
}

Status extractVolute(const std::string& path, const std::string& target,
                     const ExtractionRequest& request, const Extracted& extracted, Reading& reading,
                     Team& team) {
  VOLUTE_TRY(checkWords(target, kGridWord));
  VOLUTE_TRY(checkReplacesNothing(target, {path}));
  VOLUTE_TRY(checkFormat(target, false));
  Extractor extractor(path, request, extracted, reading, team);
  VOLUTE_ASSIGN(const auto main, openVolute(path, request.partial, reading, false));
  InputOptions input;
  input.partial = request.partial;
  input.verify = false;  // who reads a grid says what is damaged
  VOLUTE_ASSIGN(const auto grids, VolumeGrids::open(path, input, reading));
  VOLUTE_ASSIGN(const auto chosen, grids->choose(request.fields, path));
  std::vector<std::string> names;
  for (const std::size_t i : chosen) names.push_back(grids->grids()[i].name);
  const bool each = namesEachGrid(target);
  VOLUTE_ASSIGN(const auto positions, selectPositions(main->info(), request.frames));
  const VolumeInfo frames = framesAt(main->info(), positions);
  for (std::size_t i = 0; team.leads() && i < (each ? names.size() : 1); ++i) {
    const std::string own = each ? nameOfGrid(target, names[i]) : target;
    remarkOnReplaced(path, own, frames, reading);
    remarkOnOtherFrames(own, frames, reading);
  }
  remarkOnRange(path, main->info(), request.frames, reading);
  const bool described = main->grids().size() != 1 || main->grids()[0].description.has_value() ||
                         !main->kept().grids.empty();
  // Only .vdb files take what is no volume.
  if (extensionOf(target) != ".vdb" || request.region || request.level > 0) {
    std::vector<std::string> kept;
    for (const std::string& name : names) {
      if (isKept(*main, name))
        kept.push_back(name);
    }
    std::erase_if(names, [&](const std::string& name) { return isKept(*main, name); });
    if (!kept.empty() && (names.empty() || !request.fields.empty())) {
      return fail(ErrorCode::kInvalidArgument,
                  "{}: '{}' holds no volume; expected .vdb files, of whole grids at full "
                  "resolution",
                  target, fmt::join(kept, "', '"));
    }
    if (!kept.empty()) {
      reading.progress.remark(
          Remark(RemarkCode::kLeftOut,
                 fmt::format("{}: left out, as only whole .vdb files hold them: '{}'", path,
                             fmt::join(kept, "', '")))
              .in(path));
    }
  }
  if (request.region && names.size() > 1) {
    return fail(ErrorCode::kInvalidArgument, Hint::choose("field"),
                "a region is of one grid, as each has voxels of its own; {} has {}", path,
                fmt::join(names, ", "));
  }
  const auto turned = [](const VolumeGrid& grid) {
    return grid.description && !grid.description->matrices.empty();
  };
  const bool asCache = isVdbPath(target) && (names.size() > 1 || described) &&
                       !(request.level > 0 && std::ranges::any_of(chosen, [&](std::size_t i) {
                           return turned(grids->grids()[i]);
                         }));
  if (asCache && !each)
    return extractor.cache(names, target, main->info());
  VOLUTE_TRY(checkHoldsGrids(names, path, target));
  OutputNames outputs;
  for (const std::string& taken : request.taken) VOLUTE_TRY(outputs.add(taken, "another output"));
  for (const std::string& name : names) {
    if (!each)
      break;
    VOLUTE_TRY(checkNamePart(name, fmt::format("{}: a grid", path)));
    VOLUTE_TRY(outputs.add(nameOfGrid(target, name), fmt::format("grid '{}'", name)));
  }
  for (const std::size_t i : chosen) {
    const std::string& name = grids->grids()[i].name;
    if (std::ranges::find(names, name) == names.end())
      continue;
    if (grids->grids()[i].empty && names.size() > 1) {
      reading.progress.remark(
          Remark(RemarkCode::kLeftOut, fmt::format("{}: '{}' is empty and is left out", path, name))
              .in(path));
      continue;
    }
    const std::string own = nameOfGrid(target, name);
    VOLUTE_TRY(asCache ? extractor.cache({name}, own, main->info()) : extractor.one(name, own));
  }
  return {};
}

Status extractFds(const std::string& path, const std::string& target,
                  const ExtractionRequest& request, const Extracted& extracted, Reading& reading) {
  VOLUTE_TRY(checkWords(target, kMeshWord));
  VOLUTE_TRY(checkReplacesNothing(target, {path}));
  VOLUTE_TRY(checkFormat(target, false));
  Team alone;
  Extractor extractor(path, request, extracted, reading, alone);
  if (!namesEachMesh(target))
    return extractor.fds(target, std::nullopt);
  VOLUTE_ASSIGN(const SmvIndex index, SmvIndex::read(path, reading.maxMemory));
  VOLUTE_TRY(checkMeshNames(target, request, static_cast<int>(index.meshes.size())));
  for (int mesh = 0; mesh < static_cast<int>(index.meshes.size()); ++mesh) {
    const Status status =
        extractor.fds(filledIn(target, kMeshWord, fmt::format("{:04}", mesh + 1)), mesh);
    if (!status && status.error().code == ErrorCode::kNotFound) {
      reading.progress.remark({RemarkCode::kLeftOut, status.error().message});
      continue;
    }
    VOLUTE_TRY(status);
  }
  return {};
}

}  // namespace volute
