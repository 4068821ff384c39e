// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/grid_compression.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "volute/base/output_file.hpp"
#include "volute/base/remark_log.hpp"
#include "volute/codec/bundle.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/output_names.hpp"
#include "volute/volume_files/compression_report.hpp"
#include "volute/volume_files/finite_source.hpp"

namespace volute {
namespace {

/// Says which grid a stage is of.
class GridProgress final : public Progress {
 public:
  GridProgress(Progress& next, std::string name) : next_(next), name_(std::move(name)) {}

  void report(std::string_view stage, double done, double total) override {
    next_.report(fmt::format("{}: {}", name_, stage), done, total);
  }

  void detail(std::string_view text) override { next_.detail(text); }

  void remark(const Remark& remark) override { next_.remark(remark); }

  bool cancelled() const override { return next_.cancelled(); }

 private:
  Progress& next_;
  std::string name_;
};

Hints wayToKeep(const std::string& grid) {
  return {Hint::set("keep", grid).so("keeps the grid as it is")};
}

/// Adds up what all ranks have replaced, and tells it.
Result<std::uint64_t> tellReplaced(const std::string& path, const std::string& grid,
                                   const ReplacedValues& values, NotFinite what, Reading& reading,
                                   Team& team) {
  std::uint64_t count = values.count();
  VOLUTE_TRY(team.sum(std::span(&count, 1)));
  if (count > 0) {
    reading.progress.remark(
        Remark(RemarkCode::kNote,  // as it was asked for
               fmt::format("{}: '{}': {} value{} {}", path, grid, count,
                           count == 1 ? " is not finite," : "s are not finite,",
                           what == NotFinite::kInactive ? "and left out: their voxels are inactive"
                                                        : "and replaced by the background"))
            .in(path));
  }
  return count;
}

/// Of what was read of a damaged file: whatever is made of it is not whole.
void addDamage(const RemarkLog& log, const std::string& path, CompressOptions& options) {
  for (const Remark& remark : log.remarks()) {
    const std::string_view sentence = remark.sentence;
    if (remark.code == RemarkCode::kDamaged)
      options.provenance += fmt::format(
          "; {}", sentence.substr(sentence.starts_with(path + ": ") ? path.size() + 2 : 0));
  }
}

/// The volume may be a part of the cache's.
void placeWithin(const Box3& bounds, GridDescription& grid) {
  for (int axis = 0; axis < 3 && grid.matrices.empty(); ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (grid.voxelSize[a] > 0)
      grid.begin[a] = std::llround((bounds.min[axis] - grid.origin[a]) / grid.voxelSize[a] + 0.5);
  }
}

/// The grids of one file in the making.
class GridFiles {
 public:
  GridFiles(const VolumeGrids& grids, const std::vector<std::size_t>& chosen,
            const std::vector<std::size_t>& kept, const std::string& target,
            const GridCompression& how, Reading& reading, Team& team)
      : grids_(grids),
        chosen_(chosen),
        kept_(kept),
        target_(target),
        how_(how),
        reading_(reading),
        team_(team) {}

  /// Compresses all with these targets, in the order of `chosen`.
  Status compressAll(const std::vector<ErrorTarget>& targets);

  /// Puts what came of it into one file.
  /// @param keep  it becomes the target unless it has more bytes than this; without it the file is
  /// thrown away, to know how large it is
  Result<CompressedGrids> write(std::optional<double> keep);

 private:
  Status compressOne(std::size_t i, const ErrorTarget& target);
  Status keepAll();
  std::vector<KeptResult> keptResults() const;

  const VolumeGrids& grids_;
  const std::vector<std::size_t>&chosen_, &kept_;
  std::string target_;
  const GridCompression& how_;
  Reading& reading_;
  Team& team_;
  std::vector<PendingFile> files_;  // of rank 0: of each grid, an empty one's stays empty
  std::vector<CompressedGrid> done_;
  std::vector<int> positions_;           // of the frames
  std::unique_ptr<FrameSource> frames_;  // the same, without values
  std::optional<KeptStore> store_;       // of rank 0
};

Status GridFiles::compressOne(std::size_t i, const ErrorTarget& target) {
  const VolumeGrid& grid = grids_.grids()[chosen_[i]];
  done_.push_back({grid.name, {}, {}});
  if (grid.empty)
    return {};
  VOLUTE_ASSIGN(auto source, grids_.source(chosen_[i]));
  const auto replaced = std::make_shared<ReplacedValues>();
  source = asFinite(std::move(source), how_.notFinite, target_, replaced);
  source = tellingLosses(std::move(source), target_, reading_.progress, wayToKeep(grid.name));
  source = asStated(std::move(source), how_.stated);
  VOLUTE_ASSIGN(source, selectFrames(std::move(source), how_.frames));
  CompressOptions options = how_.options;
  options.target = target;
  VOLUTE_ASSIGN(const OwnError own, grids_.ownError(chosen_[i]));
  options.sourceRms = own.rms, options.sourceMaxError = own.maximum;
  options.halves = grid.description && grid.description->half;
  options.floats = grid.description && grid.description->isOfFloats();
  if (!options.work.empty())
    options.work /= fmt::format("{:03}", i);
  options.name = target_;  // errors do not name a grid's own, temporary file
  const std::string file = team_.leads() ? files_[i].path().string() : target_;
  GridProgress progress(reading_.progress, grid.name);
  auto report = compress(*source, file, options, progress, team_);
  if (!report) {
    return fail(report.error().code, report.error().hints, "grid '{}': {}", grid.name,
                report.error().message);
  }
  VOLUTE_ASSIGN(done_.back().replaced,
                tellReplaced(target_, grid.name, *replaced, how_.notFinite, reading_, team_));
  done_.back().info = source->info();
  done_.back().report = *report;
  return {};
}

Status GridFiles::compressAll(const std::vector<ErrorTarget>& targets) {
  files_.clear();
  done_.clear();
  VOLUTE_ASSIGN(positions_, selectPositions(grids_.frames(), how_.frames));
  VOLUTE_ASSIGN(frames_,
                selectFrames(asStated(emptyFrames(grids_.frames()), how_.stated), how_.frames));
  const auto makeFiles = [&]() -> Status {
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      VOLUTE_ASSIGN(auto file, PendingFile::create(target_));
      files_.push_back(std::move(file));
    }
    return {};
  };
  VOLUTE_TRY(team_.agree(team_.leads() ? makeFiles() : Status()));
  for (std::size_t i = 0; i < chosen_.size(); ++i) VOLUTE_TRY(compressOne(i, targets[i]));
  return {};
}

/// Once, whatever becomes of the other grids.
Status GridFiles::keepAll() {
  if (kept_.empty() || store_)
    return {};
  VOLUTE_ASSIGN(auto store, KeptStore::create(target_));
  store_.emplace(std::move(store));
  for (const std::size_t i : kept_) {
    const VolumeGrid& grid = grids_.grids()[i];
    const auto place =
        static_cast<std::size_t>(std::ranges::lower_bound(chosen_, i) - chosen_.begin());
    store_->begin({grid.name, grid.description ? grid.description->type : grid.type, place});
    double done = 0;
    for (const int position : positions_) {
      if (reading_.progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped: {} was not written", target_);
      VOLUTE_ASSIGN(const auto bytes, grids_.keep(i, position));
      VOLUTE_TRY(store_->add(bytes.get()));
      reading_.progress.report(grid.name + ": keeping", ++done,
                               static_cast<double>(positions_.size()));
    }
  }
  return {};
}

std::vector<KeptResult> GridFiles::keptResults() const {
  std::vector<KeptResult> all;
  for (std::size_t i = 0; store_ && i < kept_.size(); ++i) {
    const KeptTable& table = store_->table();
    all.push_back({table.grids[i].name, table.grids[i].type, table.storedBytes(i)});
  }
  return all;
}

Result<CompressedGrids> GridFiles::write(std::optional<double> keep) {
  std::uint64_t bytes = 0;
  const auto bundleAll = [&]() -> Status {
    std::vector<BundledGrid> bundled;
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const VolumeGrid& grid = grids_.grids()[chosen_[i]];
      BundledGrid& one = bundled.emplace_back();
      one.name = grid.name;
      if (grid.description)
        one.description = grid.description->of(positions_);
      if (grid.empty)
        continue;
      one.file = files_[i].path();
      if (one.description)
        placeWithin(done_[i].info.bounds, *one.description);
    }
    VOLUTE_ASSIGN(auto file, PendingFile::create(target_));
    FrameMetadata ofFiles = grids_.fileMetadata();
    if (!ofFiles.listOf.empty())
      ofFiles = ofFiles.of(positions_);
    VOLUTE_TRY(keepAll());
    VOLUTE_ASSIGN(bytes, bundle(bundled, ofFiles, file.path(), reading_.progress,
                                store_ ? &*store_ : nullptr, frames_.get()));
    if (!keep)
      return {};
    if (static_cast<double>(bytes) > *keep) {
      return fail(ErrorCode::kUnsupported,
                  "{}: cannot be made as small as {:.0f} bytes; its {} grids take {}", target_,
                  *keep, chosen_.size(), bytes);
    }
    return file.commit();
  };
  VOLUTE_TRY(team_.agree(team_.leads() ? bundleAll() : Status()));
  VOLUTE_ASSIGN(bytes, team_.broadcast(bytes));
  VolumeInfo frames = frames_->info();
  for (const CompressedGrid& grid : done_) {
    if (grid.info.x > 0)
      frames = grid.info;
  }
  return CompressedGrids{done_, bytes, 0, std::move(frames), keptResults()};
}

/// The same, of an empty grid and of one whose name its file would not give back, too.
bool wantsDescription(const VolumeGrid& grid, bool cropped) {
  return grid.description &&
         (grid.empty || grid.name.starts_with('[') || wantsDescription(*grid.description, cropped));
}

/// Whether it is read with an offset: floats come back as such where a description says that they
/// were.
Result<bool> isFarFromZero(const VolumeGrids& grids, std::size_t i) {
  const VolumeGrid& grid = grids.grids()[i];
  if (grid.empty || !grid.description)
    return false;
  VOLUTE_ASSIGN(const auto source, grids.source(i));
  return offsetOf(*source) != 0;
}

/// The one grid of files that are no cache, whose voxels do not lie along the axes or move.
class PlacedGrid final : public VolumeGrids {
 public:
  PlacedGrid(std::string path, InputOptions options, const VolumeInput& input, Reading& reading)
      : path_(std::move(path)), options_(std::move(options)), reading_(reading) {
    if (options_.notFinite != NotFinite::kRefuse)
      options_.notFinite = NotFinite::kKeep;  // compressGrids() replaces and counts them
    const VolumeInfo& info = input.source->info();
    const Vec3 voxel = info.voxelSize(), origin = info.bounds.min + 0.5 * voxel;
    GridDescription grid;
    grid.type = typeOfValues(*input.source);
    grid.map = "AffineMap";
    grid.voxelSize = {voxel.x(), voxel.y(), voxel.z()};
    grid.origin = {origin.x(), origin.y(), origin.z()};
    for (const GridMatrix& place : input.places) {
      const Mat3 linear = linearOf(place);
      grid.matrices.push_back(
          gridMatrix(linear * voxel.asDiagonal(), linear * origin + offsetOf(place)));
      const MetadataList none;
      grid.metadata.add(&none);
    }
    grids_.push_back({info.name, std::move(grid)});
    frames_ = info;
  }

  Result<std::unique_ptr<FrameSource>> source(std::size_t) const override {
    VOLUTE_ASSIGN(auto input, openVolume(path_, options_, reading_));
    return std::move(input.source);
  }

 private:
  std::string path_;
  InputOptions options_;
  Reading& reading_;
};

void remarkOnTimes(const std::string& path, const VolumeInfo& info, Reading& reading) {
  if (info.frames > 1 && info.timesAssumed)
    reading.progress.remark(Remark(RemarkCode::kAssumed,
                                   fmt::format("{}: no times are stated; 25 frames a second", path),
                                   {Hint::set("fps")})
                                .in(path));
}

/// Of files that state none in any way.
void remarkOnBounds(const std::string& path, const InputOptions& input, Reading& reading) {
  std::error_code error;
  const bool numpy = isNumpyPath(path) || (std::filesystem::is_directory(path, error) &&
                                           volumesIn(path).value_or("") == ".npy");
  if (!input.bounds && (numpy || input.raw))
    reading.progress.remark(
        Remark(RemarkCode::kAssumed,
               fmt::format("{}: no bounds are stated; the longest side is 1 m", path),
               {Hint::set("bounds")})
            .in(path));
}

/// The bytes that `target` allows a file.
double bytesAllowed(const ErrorTarget& target, std::uint64_t rawBytes) {
  return target.kind == ErrorTarget::Kind::kSize
             ? target.value
             : std::floor(static_cast<double>(rawBytes) / target.value);
}

bool isSize(const ErrorTarget& target) {
  return target.kind == ErrorTarget::Kind::kSize || target.kind == ErrorTarget::Kind::kRatio;
}

/// Who asks for a size and gets far less wonders what was lost.
void remarkOnSize(const std::string& path, const ErrorTarget& target, std::uint64_t rawBytes,
                  std::uint64_t bytes, double supportRms, Reading& reading) {
  if (!isSize(target) || 2 * static_cast<double>(bytes) >= bytesAllowed(target, rawBytes))
    return;
  reading.progress.remark(
      Remark(RemarkCode::kNote,
             fmt::format("{}: {} bytes, less than half of the {:.0f} that were asked for: finer "
                         "steps gain nothing, the relative rms is {:.2g}",
                         path, bytes, bytesAllowed(target, rawBytes), supportRms))
          .in(path));
}

/// Wild values may stand for what is not known, or be a fault: they are told, not judged.
void remarkOnValuesApart(const std::string& grid, const CompressReport& report, Reading& reading) {
  constexpr double kWild = 100;  // ranges of all others; hot spots of flames are nearer
  const SupportError& support = report.support;
  const double reach = kWild * (support.high - support.low);
  if (!support.robust ||
      (report.valueMax - support.high <= reach && support.low - report.valueMin <= reach))
    return;
  constexpr double kLost = 0.05;
  const bool lost = support.rms > kLost;  // where the target is over all
  reading.progress.remark(Remark(
      RemarkCode::kDoubtful,
      fmt::format("{}: some values are far from all others, which are {:.4g} to {:.4g}: the "
                  "extremes are {:.4g} and {:.4g}; they are kept exactly{}",
                  grid, support.low, support.high, report.valueMin, report.valueMax,
                  lost ? fmt::format(", and the others are off by {:.2g}, as the error that is "
                                     "asked for counts by the extremes",
                                     support.rms * (support.high - support.low))
                       : ""),
      lost ? Hints{Hint::set("rms").so("counts by the others")} : Hints{}));
}

/// The grids of a cache; nothing where one grid is to be compressed by itself.
Result<std::optional<Report>> compressCache(const std::string& path, const std::string& target,
                                            GridCompression how, const InputOptions& input,
                                            Reading& reading, Team& team) {
  const bool one = gridNames(input.grid).size() == 1 && how.keep.empty();
  if (input.raw || !VolumeGrids::mayBe(path)) {
    if (!how.rms.empty())
      return failFor("rms_of", ErrorCode::kInvalidArgument, Hint::set("rms"),
                     "is for several grids, and this is one");
    if (!how.keep.empty())
      return failFor("keep", ErrorCode::kInvalidArgument, "is for grids of a cache, and {} is none",
                     path);
    if (how.dropUncoded)
      return failFor("uncoded", ErrorCode::kInvalidArgument,
                     "is for grids of a cache, and {} is none", path);
    return std::nullopt;
  }
  InputOptions unverified = input;  // who reads it says what is damaged
  unverified.verify = false;
  unverified.stated = how.stated;
  VOLUTE_ASSIGN(const auto grids, VolumeGrids::open(path, unverified, reading));
  const auto& all = grids->grids();
  VOLUTE_ASSIGN(const auto named, grids->choose(input.grid, path));
  std::vector<std::size_t> keep;
  for (const std::string& name : how.keep) {
    VOLUTE_ASSIGN(const auto found, grids->choose(name, path));
    keep.push_back(found[0]);
    if (std::ranges::find(named, found[0]) == named.end()) {
      return failFor(
          "keep", ErrorCode::kInvalidArgument,
          "{}: grid '{}' is to be kept, and is not one of the grids to be compressed: {}", path,
          name, input.grid);
    }
  }
  std::vector<std::size_t> chosen, kept;
  std::vector<std::string> asBytes, leftOut;
  for (const std::size_t i : named) {
    const bool asked = std::ranges::find(keep, i) != keep.end();
    if (!asked && all[i].kept.empty()) {
      chosen.push_back(i);
      continue;
    }
    const bool dropped = how.dropUncoded && !asked;
    if (!dropped && all[i].keptBytes > reading.maxMemory) {
      return fail(ErrorCode::kTooLarge,
                  {Hint::raise("max_memory"), Hint::set("uncoded", "drop").so("leaves it out")},
                  "{}: grid '{}' is kept as it is ({}) and takes {} MiB, more than the {} MiB of "
                  "memory allowed",
                  all[i].keptIn, all[i].name, all[i].kept, all[i].keptBytes >> 20,
                  reading.maxMemory >> 20);
    }
    (dropped ? leftOut : asBytes)
        .push_back(fmt::format("'{}' ({})", all[i].name, asked ? "as asked" : all[i].kept));
    if (!dropped)
      kept.push_back(i);
  }
  const bool frusta =
      std::ranges::any_of(named, [&](std::size_t i) { return all[i].kept == "with a frustum"; });
  Hints wayOut = frusta ? Hints{Hint::set("resample").so("makes a volume of a frustum")} : Hints();
  // Who compresses nothing but frusta expects volumes.
  const bool frustaAlone = how.keep.empty() && std::ranges::all_of(named, [&](std::size_t i) {
                             return all[i].kept == "with a frustum";
                           });
  if (chosen.empty() && !named.empty() && (kept.empty() || frustaAlone)) {
    wayOut.push_back(Hint::set("keep", all[named[0]].name).so("keeps it as it is"));
    asBytes.insert(asBytes.end(), leftOut.begin(), leftOut.end());
    return fail(ErrorCode::kUnsupported, wayOut, "{}: no grid can be compressed: {}", path,
                fmt::join(asBytes, ", "));
  }
  if (named.empty())
    return std::nullopt;
  if (chosen.size() == 1 && (all.size() == 1 || one) && how.rms.empty() &&
      grids->fileMetadata().lists.empty() &&
      !wantsDescription(all[chosen[0]], input.bounds.has_value())) {
    VOLUTE_ASSIGN(const bool far, isFarFromZero(*grids, chosen[0]));
    if (!far)
      return std::nullopt;
  }
  if (input.bounds && chosen.size() + kept.size() > 1) {
    return failFor("bounds", ErrorCode::kInvalidArgument, Hint::choose("field"),
                   "is for one grid, and {} has {}", path, chosen.size() + kept.size());
  }
  if (input.bounds && isVolutePath(path))
    return std::nullopt;  // refused where it is opened
  for (const auto& [name, rms] : how.rms) {
    VOLUTE_ASSIGN(const auto found, grids->choose(name, path));
    if (std::ranges::find(chosen, found[0]) == chosen.end()) {
      return fail(ErrorCode::kInvalidArgument,
                  "{}: an error is stated for grid '{}', which is not to be compressed", path,
                  name);
    }
  }
  for (const auto& [names, what] : {std::pair(&asBytes, "kept as they are, without loss"),
                                    std::pair(&leftOut, "left out, as they hold no volume")}) {
    if (!names->empty())
      reading.progress.remark({RemarkCode::kNote,
                               fmt::format("{}: {}: {}", path, what, fmt::join(*names, ", ")),
                               wayOut});
  }
  remarkOnFiles(path, reading);
  remarkOnRange(path, grids->frames(), how.frames, reading);
  for (const std::size_t i : chosen) {
    if (!isVolutePath(path) || all[i].empty)
      continue;
    RemarkLog log(reading.progress);
    Reading logged = reading.with(log);
    VOLUTE_ASSIGN(const auto own,
                  openVolute(path, input.partial, logged, input.partial, all[i].name));
    addDamage(log, path, how.options);
    remarkOnOwnError(path, *own, reading);
  }
  VOLUTE_ASSIGN(const auto result, compressGrids(*grids, chosen, target, how, reading, team, kept));
  const VolumeInfo& frames = result.frames;
  const bool allFrames = how.frames == FrameRange{};
  if (const auto gaps = missingNumbers(frames.frameNumbers, frames.frameScale);
      !gaps.empty() && allFrames)
    reading.progress.remark(
        Remark(RemarkCode::kDoubtful, fmt::format("{}: {}", path, gaps)).in(path));
  remarkOnTimes(path, frames, reading);
  const bool whole = allFrames && chosen.size() + kept.size() == all.size();
  return compressionReport(target, result, frames.frames, whole ? bytesOnDisk(path) : std::nullopt);
}

}  // namespace

std::uint64_t CompressedGrids::rawBytes() const {
  std::uint64_t bytes = 0;
  for (const CompressedGrid& grid : grids) bytes += grid.report.rawBytes;
  return bytes;
}

Result<CompressedGrids> compressGrids(const VolumeGrids& grids,
                                      const std::vector<std::size_t>& chosen,
                                      const std::string& target, const GridCompression& how,
                                      Reading& reading, Team& team,
                                      const std::vector<std::size_t>& kept) {
  const auto start = std::chrono::steady_clock::now();
  using Kind = ErrorTarget::Kind;
  const ErrorTarget wanted = how.options.target;
  const bool sized = isSize(wanted) && std::ranges::any_of(chosen, [&](std::size_t i) {
                       return !grids.grids()[i].empty;
                     });
  GridFiles files(grids, chosen, kept, target, how, reading, team);
  std::vector<ErrorTarget> targets(chosen.size(),
                                   sized ? ErrorTarget{Kind::kRms, 1e-2, true} : wanted);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (const auto own = how.rms.find(grids.grids()[chosen[i]].name); own != how.rms.end())
      targets[i] = {how.rmsOverAll ? Kind::kRmsOverAll : Kind::kRms, own->second};
  }
  VOLUTE_TRY(files.compressAll(targets));
  constexpr double kAny = std::numeric_limits<double>::infinity();
  VOLUTE_ASSIGN(auto result, files.write(sized ? std::nullopt : std::optional(kAny)));
  if (sized) {
    // A size is shared out as grids of one quality need it, less what the table of grids takes.
    const double most = bytesAllowed(wanted, result.rawBytes());
    // What is nearly nothing but its description cannot get smaller, and stays as it is.
    constexpr double kSmall = 1000;
    const auto stays = [&](const CompressedGrid& grid) {
      return static_cast<double>(grid.report.fileBytes) < kSmall || how.rms.contains(grid.name);
    };
    double sum = 0, fixed = 0;
    for (const CompressedGrid& grid : result.grids)
      (stays(grid) ? fixed : sum) += static_cast<double>(grid.report.fileBytes);
    const double table = std::max(static_cast<double>(result.fileBytes) - sum - fixed, 0.0);
    if (most <= table + fixed) {
      return fail(ErrorCode::kUnsupported,
                  "{}: cannot be made as small as {:.0f} bytes; it has {:.0f} without any values{}",
                  target, most, table + fixed,
                  how.rms.empty() ? "" : " but those of the grids whose error is stated");
    }
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const auto bytes = static_cast<double>(result.grids[i].report.fileBytes);
      const double share = std::floor((most - table - fixed) * bytes / std::max(sum, 1.0));
      if (!stays(result.grids[i]))
        targets[i] = {Kind::kSize, std::max(1.0, share)};
    }
    VOLUTE_TRY(files.compressAll(targets));
    VOLUTE_ASSIGN(result, files.write(most));
    double worst = 0;
    for (const CompressedGrid& grid : result.grids)
      worst = std::max(worst, grid.report.support.rms);
    remarkOnSize(target, wanted, result.rawBytes(), result.fileBytes, worst, reading);
  }
  for (const CompressedGrid& grid : result.grids)
    remarkOnValuesApart(fmt::format("grid '{}'", grid.name), grid.report, reading);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

Result<Report> compressVolume(const std::string& path, const std::string& target,
                              const GridCompression& how, const InputOptions& input,
                              Reading& reading, Team& team) {
  VOLUTE_TRY(checkReplacesNothing(target, {path}));
  VOLUTE_ASSIGN(auto report, compressCache(path, target, how, input, reading, team));
  if (report)
    return *std::move(report);
  InputOptions finite = input;
  finite.notFinite = how.notFinite;
  finite.stated = how.stated;
  RemarkLog log(reading.progress);
  Reading logged = reading.with(log);
  VOLUTE_ASSIGN(auto volume, openVolume(path, finite, logged));
  CompressOptions options = how.options;
  addDamage(log, path, options);
  if (!volume.places.empty()) {
    const PlacedGrid grid(path, std::move(finite), volume, reading);
    VOLUTE_ASSIGN(const auto result, compressGrids(grid, {0}, target, how, reading, team));
    return compressionReport(target, result, result.frames.frames, std::nullopt);
  }
  remarkOnTimes(path, volume.source->info(), reading);
  remarkOnBounds(path, input, reading);
  const bool whole =
      how.frames == FrameRange{} && !input.bounds && volume.source->otherGrids().empty();
  remarkOnRange(path, volume.source->info(), how.frames, reading);
  volume.source = tellingLosses(std::move(volume.source), path, reading.progress,
                                wayToKeep(volume.source->info().name));
  VOLUTE_ASSIGN(const auto source, selectFrames(std::move(volume.source), how.frames));
  if (volume.reader) {
    const OwnError own = ownErrorOf(*volume.reader);
    options.sourceRms = own.rms, options.sourceMaxError = own.maximum;
    remarkOnOwnError(path, *volume.reader, reading);
  }
  VOLUTE_ASSIGN(const auto result, compress(*source, target, options, reading.progress, team));
  VOLUTE_ASSIGN(
      const std::uint64_t replaced,
      tellReplaced(path, source->info().name, *volume.replaced, how.notFinite, reading, team));
  remarkOnSize(target, how.options.target, result.rawBytes, result.fileBytes, result.support.rms,
               reading);
  remarkOnValuesApart(path, result, reading);
  Report finished =
      compressionReport(target, source->info(), result, whole ? bytesOnDisk(path) : std::nullopt);
  finished.add("replaced_values", replaced, replaced > 0 ? fmt::format("{}", replaced) : "");
  return finished;
}

Result<std::map<std::string, double>> parseGridRms(const std::string& text) {
  std::map<std::string, double> all;
  for (const std::string& one : gridNames(text)) {
    const auto equals = one.rfind('=');
    double rms = 0;
    const char* const end = one.data() + one.size();
    const bool number = equals != std::string::npos && equals > 0 &&
                        std::from_chars(one.data() + equals + 1, end, rms).ptr == end && rms > 0 &&
                        rms <= 1;
    if (!number) {
      return fail(ErrorCode::kInvalidArgument,
                  "'{}' is no NAME=R; expected a grid's name and a relative RMS above 0, at "
                  "most 1, as density=0.001",
                  one);
    }
    if (!all.emplace(one.substr(0, equals), rms).second)
      return fail(ErrorCode::kInvalidArgument, "'{}' names '{}' twice", text,
                  one.substr(0, equals));
  }
  return all;
}

}  // namespace volute
