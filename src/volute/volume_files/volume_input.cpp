// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/volume_input.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "volute/codec/kept_grids.hpp"
#include "volute/codec/recompress.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/select_frames.hpp"
#include "volute/grid/wrapped_source.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/named_files.hpp"
#include "volute/io/volume_source.hpp"
#include "volute/io/written_frames.hpp"
#include "volute/volume_files/fds_input.hpp"
#include "volute/volume_files/memory_volumes.hpp"

namespace volute {
namespace {

void remarkOnGaps(const std::string& path, const VolumeInfo& info, Reading& reading) {
  if (const auto gaps = missingNumbers(info.frameNumbers, info.frameScale); !gaps.empty())
    reading.progress.remark(
        Remark(RemarkCode::kAssumed, fmt::format("{}: {}; until the next one the frame before is "
                                                 "shown, unless frames are interpolated",
                                                 path, gaps))
            .in(path));
}

Status refuseVolumeOptions(const std::string& path, const InputOptions& options) {
  if (options.bounds) {
    return fail(ErrorCode::kInvalidArgument, Hint::leaveOut("bounds"),
                "{}: a .volute file states its bounds", path);
  }
  return {};
}

}  // namespace

bool isVolutePath(const std::string& path) {
  return extensionOf(path) == ".volute";
}

bool isNumpyPath(const std::string& path) {
  const std::string extension = extensionOf(path);
  return extension == ".npy" || extension == ".npz";
}

std::string integrityText(const Integrity& integrity, const VoluteReader& reader) {
  if (integrity.complete())
    return "complete";
  // The longest block has the most levels; a border block may have fewer.
  const int levels = reader.blocks().levels(0);
  return fmt::format(
      "damaged: {}; {} of {} segments are intact, {} of {} levels whole in every block",
      integrity.firstFault, integrity.intactSegments, integrity.segments, integrity.intactLevels,
      levels);
}

Result<std::shared_ptr<const VoluteReader>> openVolute(const std::string& path, bool partial,
                                                       Reading& reading, bool verify,
                                                       const std::string& grid,
                                                       Offsets differences) {
  if (namesSeriesOfFiles(path)) {
    return fail(ErrorCode::kUnsupported,
                "{}: a pattern of .volute files; expected one, which holds all frames: parts of a "
                "sequence are joined to one",
                path);
  }
  VoluteReader::Options options;
  options.partial = partial;
  options.maxMemory = reading.maxMemory;
  options.grid = grid;
  options.differences = differences;
  VOLUTE_ASSIGN(auto opened, VoluteReader::open(path, options));
  auto reader = std::make_shared<const VoluteReader>(std::move(opened));
  if (partial && verify) {
    const Integrity integrity = reader->verify();
    if (!integrity.complete())
      reading.progress.remark(Remark(RemarkCode::kDamaged,
                                     fmt::format("{}: {}", path, integrityText(integrity, *reader)))
                                  .in(path));
  }
  return reader;
}

namespace {

/// The grid that is meant of a .volute with one or more.
Result<std::shared_ptr<const VoluteReader>> openGrid(const std::string& path,
                                                     const InputOptions& options,
                                                     Reading& reading) {
  VOLUTE_ASSIGN(auto reader, openVolute(path, options.partial, reading, options.verify,
                                        options.grid, options.offsets));
  const auto& grids = reader->grids();
  if (reader->grid().empty) {
    std::string empty, kept;
    for (const VoluteGrid& grid : grids)
      empty += (empty.empty() ? "'" : ", '") + grid.info.name + "'";
    for (const KeptGrid& grid : reader->kept().grids)
      kept += fmt::format("{}'{}' ({})", kept.empty() ? "" : ", ", grid.name, grid.type);
    return fail(ErrorCode::kUnsupported, "{}: no grid has values: {}{}{}{}", path,
                empty.empty() ? "" : "empty in all frames are ", empty,
                empty.empty() || kept.empty() ? "" : "; ",
                kept.empty() ? "" : "as their bytes it keeps " + kept);
  }
  if (!options.grid.empty() || grids.size() < 2)
    return reader;
  const auto usual = std::ranges::find_if(grids, [&](const VoluteGrid& grid) {
    return grid.info.name == options.usualGrid && !grid.empty;
  });
  if (usual != grids.end() && reader->info().name != options.usualGrid) {
    VOLUTE_ASSIGN(reader, openVolute(path, options.partial, reading, options.verify,
                                     options.usualGrid, options.offsets));
  }
  std::string others;
  for (const VoluteGrid& grid : reader->grids()) {
    if (grid.info.name != reader->info().name)
      others += (others.empty() ? "" : ", ") + grid.info.name;
  }
  reading.progress.remark(Remark(RemarkCode::kAssumed,
                                 fmt::format("{}: the grid '{}' is read; it also has {}", path,
                                             reader->info().name, others),
                                 {Hint::choose("field")})
                              .in(path));
  return reader;
}

}  // namespace

namespace {

Result<VolumeInput> openAsStated(const std::string& path, const InputOptions& options,
                                 Reading& reading) {
  VolumeInput input;
  if (reading.volumes)
    input.source = reading.volumes->open(path);
  if (input.source) {
    const std::string& name = input.source->info().name;
    if (!options.grid.empty() && options.grid != name) {
      return fail(ErrorCode::kNotFound, "{}: holds '{}' alone, and no '{}'", path, name,
                  options.grid);
    }
    if (options.bounds) {
      return fail(ErrorCode::kInvalidArgument,
                  "{}: a volume in memory has its bounds from who made it; leave them out here",
                  path);
    }
    return input;
  }
  if (!options.raw && isVolutePath(path)) {
    VOLUTE_TRY(refuseVolumeOptions(path, options));
    VOLUTE_ASSIGN(input.reader, openGrid(path, options, reading));
    input.source = frameSource(input.reader);
    remarkOnGaps(path, input.source->info(), reading);
    const auto& shares = input.reader->header().amounts.shares;
    input.amounts.assign(shares.begin(), shares.end());
    if (const auto& description = input.reader->grid().description) {
      input.places = description->places();
      input.gridClass = description->gridClass;
      if (!description->metadata.lists.empty())
        input.vectors = vectorKindOf(description->metadata.lists.front());
    }
    return input;
  }
  if (!options.raw && isSmvPath(path)) {
    VOLUTE_ASSIGN(input.source,
                  openFdsVolume(path, options.grid, options.bounds, std::nullopt, reading));
    return input;
  }
  if (!options.raw && isPicturePath(path)) {
    return fail(ErrorCode::kUnsupported,
                "{}: this is a picture; expected a volume: .volute, .npy, .npz, .vdb, .vti, "
                ".pvd, .nc, .h5, .zarr or .smv",
                path);
  }
  SourceOptions source;
  source.grid = options.grid;
  source.usualGrid = options.usualGrid;
  source.bounds = options.bounds;
  source.maxMemory = reading.maxMemory;
  source.byLayers = options.byLayers;
  source.upStated = options.stated.up != 0;
  source.raw = options.raw;
  source.frusta = options.frusta;
  source.offsets = options.offsets;
  source.remark = [&](const Remark& remark) { reading.progress.remark(remark); };
  VOLUTE_ASSIGN(input.source, openSource(path, source));
  if (const auto* placed = dynamic_cast<const PlacedFrames*>(input.source.get()))
    input.places = placed->places();
  if (const auto* vectors = dynamic_cast<const VectorFrames*>(input.source.get()))
    input.vectors = vectors->vectors();
  if (const auto* written = dynamic_cast<const WrittenFrames*>(input.source.get()))
    input.writer = written->writer(), input.gridClass = written->gridClass();
  if (const auto* counted = dynamic_cast<const CountedFrames*>(input.source.get()))
    input.amounts = counted->amounts();
  remarkOnFiles(path, reading);
  remarkOnGaps(path, input.source->info(), reading);
  return input;
}

}  // namespace

Result<VolumeInput> openVolume(const std::string& path, const InputOptions& options,
                               Reading& reading) {
  VOLUTE_ASSIGN(auto input, openAsStated(path, options, reading));
  input.replaced = std::make_shared<ReplacedValues>();
  input.source = asFinite(std::move(input.source), options.notFinite, path, input.replaced);
  input.source = asStated(std::move(input.source), options.stated);
  return input;
}

Status alongAxesOnly(const VolumeInput& input, const std::string& path, std::string_view what) {
  if (input.places.empty())
    return {};
  return fail(ErrorCode::kUnsupported,
              "{}: grid '{}' is turned, sheared or mirrored, or moves by parts of a voxel, and {}; "
              "expected voxels along the axes",
              path, input.source->info().name, what);
}

OwnError ownErrorOf(const VoluteReader& reader) {
  CompressOptions options;
  addOwnError(reader, options);
  return {options.sourceRms, options.sourceMaxError};
}

void remarkOnOwnError(const std::string& path, const VoluteReader& reader, Reading& reading) {
  const VoluteHeader& header = reader.header();
  if (header.reachedMaxError == 0)
    return;
  reading.progress.remark(
      Remark(RemarkCode::kNote,
             fmt::format(
                 "{}: is compressed itself: '{}' is a relative rms of {:.3g} (maximum {:.3g}) "
                 "from what it was made of; the errors measured now are beside that, and the "
                 "new file states their sums",
                 path, reader.info().name, header.support ? header.support->rms : header.reachedRms,
                 header.reachedMaxError))
          .in(path));
}

bool hasUsualBounds(const VolumeInfo& info) {
  VolumeInfo unsaid = info;
  unsaid.bounds = {};
  unsaid.fillDefaults();
  return info.bounds.min == unsaid.bounds.min && info.bounds.max == unsaid.bounds.max;
}

void remarkOnRange(const std::string& path, const VolumeInfo& info, const FrameRange& range,
                   Reading& reading) {
  if (const auto text = beyondText(range, info.frameNumbers, info.frameScale); !text.empty())
    reading.progress.remark(
        Remark(RemarkCode::kDoubtful, fmt::format("{}: {}", path, text)).in(path));
}

namespace {

class ToldSource final : public WrappedSource {
 public:
  ToldSource(std::unique_ptr<FrameSource> source, std::string path, Progress& log, Hints hints)
      : WrappedSource(std::move(source)),
        path_(std::move(path)),
        log_(log),
        hints_(std::move(hints)) {}

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    VOLUTE_TRY(source_->readBricks(index, first, end, bricks));
    if (bricks.leftOut() > 0 && !std::exchange(told_, true)) {
      log_.remark(
          Remark(RemarkCode::kLeftOut,
                 fmt::format("{}: '{}', frame {}: what inactive voxels hold is not kept where they "
                             "lie beyond all active ones or are no numbers ({} of them)",
                             path_, info().name, info().frameText(static_cast<std::size_t>(index)),
                             bricks.leftOut()),
                 hints_)
              .in(path_));
    }
    return {};
  }

 private:
  std::string path_;
  Progress& log_;
  Hints hints_;
  bool told_ = false;
};

}  // namespace

std::unique_ptr<FrameSource> tellingLosses(std::unique_ptr<FrameSource> source, std::string path,
                                           Progress& log, Hints hints) {
  return std::make_unique<ToldSource>(std::move(source), std::move(path), log, std::move(hints));
}

void remarkOnFiles(const std::string& path, Reading& reading) {
  std::error_code error;
  std::string extension = extensionOf(path);
  if (std::filesystem::is_directory(path, error)) {
    const auto kind = volumesIn(path);
    extension = kind ? *kind : "";
  }
  if (const auto leftOut = leftOutFiles(path, extension); !leftOut.empty())
    reading.progress.remark(
        Remark(RemarkCode::kLeftOut, fmt::format("{}: {}", path, leftOut)).in(path));
}

std::optional<std::uint64_t> bytesOnDisk(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  std::uint64_t bytes = 0;
  if (fs::is_regular_file(path, error)) {
    bytes = fs::file_size(path, error);
    if (extensionOf(path) == ".smv")
      return std::nullopt;
    if (extensionOf(path) != ".pvd")
      return bytes;
    std::set<fs::path> files;
    for (const std::string& name : namesInCollection(path)) {
      const fs::path file = fs::path(path).parent_path() / name;
      if (extensionOf(file).starts_with(".pv"))  // its own pieces are in files of their own
        return std::nullopt;
      const auto size = fs::file_size(file, error);
      bytes += !error && files.insert(file.lexically_normal()).second ? size : 0;
    }
    return bytes;
  }
  if (namesSeries(path)) {
    const auto pattern = FramePattern::parse(path);
    if (!pattern)
      return std::nullopt;
    const auto files = pattern->list(SubFrames::kAllowed);
    if (!files)
      return std::nullopt;
    for (const NumberedFile& file : *files) bytes += fs::file_size(file.path, error);
    return bytes;
  }
  if (!fs::is_directory(path, error))
    return std::nullopt;
  // Of a sequence its own files; a simulation may keep others beside them.
  const auto kind = volumesIn(path);
  if (kind) {
    if (const auto sequence = listNumberedFiles(path, *kind)) {
      for (const NumberedFile& file : *sequence) bytes += fs::file_size(file.path, error);
      return bytes;
    }
  }
  for (const auto& entry : fs::directory_iterator(path, error)) {
    if (entry.is_regular_file(error))
      bytes += entry.file_size(error);
  }
  return bytes;
}

}  // namespace volute
