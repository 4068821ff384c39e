// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/lattice_source.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <optional>
#include <utility>

#include "volute/base/assert.hpp"
#include "volute/base/input_file.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/grid/look_figures.hpp"
#include "volute/grid/rounding_source.hpp"
#include "volute/io/collection.hpp"
#include "volute/io/grid_choice.hpp"
#include "volute/io/lattice_message.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/reader_process.hpp"
#include "volute/io/written_frames.hpp"

namespace volute {
namespace {

/// Crosses to the child as bytes, the file's name after it. The grid's name travels in it: it is
/// chosen after the child was forked.
struct Request {
  bool describe = false;
  bool list = false;     ///< of all grids
  bool cache = false;    ///< describe all grids
  bool bricks = false;   ///< read() as bricks: first their size, then they themselves
  bool keep = false;     ///< keep() the grid at `offset`: its size
  bool fetch = false;    ///< what the last one of `cache` and `keep` made, from byte `offset` on
  bool flag = false;     ///< needBox when describing, crop when reading
  bool sampled = false;  ///< frusta are read as `frusta` say
  FrustumSampling frusta{};
  std::uint64_t offset = 0, limit = 0;
  double less = 0;  ///< values are differences from it
  IndexBox whole;   ///< of the volume
  IndexBox box;     ///< what is read of it
  char grid[LatticeFrame::kMaxName + 1] = {};
  char usual[LatticeFrame::kMaxName + 1] = {};
};

/// Of bricks that wait to be fetched.
struct BricksReply {
  std::uint64_t bytes = 0;
  double rounding = 0;
  double lostBackground = 0;
};

/// What waits in the child for the calls that fetch it.
struct Held {
  std::optional<Bricks> bricks;
  std::string bytes;
};

/// The child's side.
Result<std::string> serve(LatticeReader& reader, Held& held, const std::filesystem::path& path,
                          const Request& request, std::span<float> values) {
  std::optional<Bricks>& kept = held.bricks;
  if (request.fetch) {
    const auto room = std::as_writable_bytes(values);
    if (request.offset > held.bytes.size())
      return fail(ErrorCode::kInvalidData, "{}: was not read before", path.string());
    std::memcpy(room.data(), held.bytes.data() + request.offset,
                std::min<std::size_t>(room.size(), held.bytes.size() - request.offset));
    return std::string();
  }
  if (request.bricks && !values.empty()) {
    const auto room = std::as_writable_bytes(values);
    if (!kept || kept->messageBytes() > room.size())
      return fail(ErrorCode::kInvalidData, "{}: its bricks were not read before", path.string());
    kept->toMessage(room);
    kept.reset();
    return std::string();
  }
  kept.reset();
  held.bytes = {};
  VOLUTE_TRY(InputFile::check(path));
  reader.sampleFrusta(request.sampled ? &request.frusta : nullptr);
  reader.takeOffset(request.less);
  if (request.list) {
    VOLUTE_ASSIGN(const auto grids, reader.list(path, request.limit));
    return detail::encodeGridFacts(grids);
  }
  if (request.cache) {
    VOLUTE_ASSIGN(const auto cache, reader.describeAll(path));
    held.bytes = detail::encodeCache(cache);
    return toMessage(std::uint64_t{held.bytes.size()});
  }
  if (request.keep) {
    VOLUTE_ASSIGN(held.bytes,
                  reader.keep(path, static_cast<std::size_t>(request.offset), request.limit));
    return toMessage(std::uint64_t{held.bytes.size()});
  }
  if (request.describe) {
    VOLUTE_ASSIGN(const LatticeFrame frame,
                  reader.describe(path, request.grid, request.usual, request.flag));
    return toMessage(frame);
  }
  double rounding = 0;
  if (request.bricks) {
    VOLUTE_ASSIGN(kept, reader.readBricks(path, request.grid, request.whole, request.box,
                                          request.flag, rounding));
    return toMessage(BricksReply{kept->messageBytes(), rounding, reader.lostBackground()});
  }
  VOLUTE_TRY(
      reader.read(path, request.grid, request.whole, request.box, request.flag, values, rounding));
  return toMessage(rounding);
}

using LoadLatticePlugin = Result<const LatticePlugin*> (*)();

Result<ReaderProcess::Serve> makeServe(std::string_view parameters) {
  VOLUTE_ASSIGN(const auto loadPlugin, fromMessage<LoadLatticePlugin>(parameters));
  VOLUTE_ASSIGN(const LatticePlugin* plugin, loadPlugin());
  return [reader = std::shared_ptr<LatticeReader>(plugin->makeReader()),
          held = std::make_shared<Held>()](std::string_view bytes,
                                           std::span<float> values) -> Result<std::string> {
    VOLUTE_ASSIGN(const auto request, fromMessage<Request>(bytes.substr(0, sizeof(Request))));
    return serve(*reader, *held, bytes.substr(sizeof(Request)), request, values);
  };
}

/// Their libraries have tens of thousands of symbols.
ReaderJob jobWith(LoadLatticePlugin loadPlugin, ReaderJob::Make make) {
  ReaderJob job{make, toMessage(loadPlugin)};
  job.prepare =
      loadPlugin == loadVdbPlugin ? [] { (void)loadVdbPlugin(); } : [] { (void)loadVtkPlugin(); };
  return job;
}

ReaderJob readerOf(const std::vector<LatticeFile>& files, LoadLatticePlugin loadPlugin) {
  ReaderJob job = jobWith(loadPlugin, makeServe);
  for (const LatticeFile& file : files) job.readable.push_back(file.path);
  return job;
}

std::uint64_t sizeOf(const std::filesystem::path& file) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  return error ? 0 : size;
}

ReaderProcess::Limits limitsFor(const std::filesystem::path& file, std::size_t values,
                                std::uint64_t maxMemory) {
  constexpr std::uint64_t kLibraries = 56 << 20;
  ReaderProcess::Limits limits;
  limits.memory = maxMemory + kLibraries;
  limits.seconds =
      3 + 1e-6 * static_cast<double>(sizeOf(file)) + 1e-7 * static_cast<double>(values);
  return limits;
}

/// What the child holds after a request for it, part by part.
class HeldBytes final : public KeptBytes {
 public:
  static Result<HeldBytes> ask(ReaderProcess& process, const std::filesystem::path& file,
                               const Request& request, const ReaderProcess::Limits& limits) {
    const std::string name = file.string();
    VOLUTE_ASSIGN(const std::string reply,
                  process.call(name, toMessage(request) + name, 0, limits));
    VOLUTE_ASSIGN(const auto size, fromMessage<std::uint64_t>(reply));
    return HeldBytes(process, name, size, limits);
  }

  std::uint64_t size() const override { return size_; }

  Result<std::span<const std::byte>> next() override {
    Request request;
    request.fetch = true;
    request.offset = done_;
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(kPart, size_ - done_));
    if (count == 0)
      return std::span<const std::byte>();
    VOLUTE_TRY(process_->call(file_, toMessage(request) + file_, (count + 3) / 4, limits_));
    // The child may still write to what is shared.
    const auto shared = std::as_bytes(process_->values()).first(count);
    part_.assign(shared.begin(), shared.end());
    done_ += count;
    return std::span<const std::byte>(part_);
  }

 private:
  HeldBytes(ReaderProcess& process, std::string file, std::uint64_t size,
            const ReaderProcess::Limits& limits)
      : process_(&process), file_(std::move(file)), size_(size), limits_(limits) {}

  ReaderProcess* process_;
  std::string file_;
  std::uint64_t size_, done_ = 0;
  ReaderProcess::Limits limits_;
  std::vector<std::byte> part_;
};

std::string text(const std::array<double, 3>& v) {
  return fmt::format("{} x {} x {} m", plainNumber(v[0]), plainNumber(v[1]), plainNumber(v[2]));
}

std::string text(const Box3& box) {
  return fmt::format("{},{},{},{},{},{}", box.min.x(), box.min.y(), box.min.z(), box.max.x(),
                     box.max.y(), box.max.z());
}

/// How many voxels `frame`'s index 0 lies away from that of `first`; nothing unless both are on one
/// lattice along the axes.
std::optional<std::array<std::int64_t, 3>> latticeShift(const LatticeFrame& first,
                                                        const LatticeFrame& frame) {
  constexpr double kSameSize = 1e-5;   // relative; single-precision transforms are this far apart
  constexpr double kSamePlace = 1e-3;  // voxels
  constexpr double kFarthest = 1e9;    // voxels; anything beyond has a matrix of its own
  if (first.turned || frame.turned)
    return std::nullopt;
  std::array<std::int64_t, 3> shift{};
  for (int axis = 0; axis < 3; ++axis) {
    const double voxels = (frame.origin[axis] - first.origin[axis]) / first.voxelSize[axis];
    if (!(std::abs(frame.voxelSize[axis] - first.voxelSize[axis]) <=
          kSameSize * first.voxelSize[axis]) ||
        !(std::abs(voxels) < kFarthest) || std::abs(voxels - std::round(voxels)) > kSamePlace)
      return std::nullopt;
    shift[axis] = std::llround(voxels);
  }
  return shift;
}

Box3 toBounds(const LatticeFrame& lattice, const IndexBox& box) {
  Box3 bounds;
  for (int axis = 0; axis < 3; ++axis) {
    const double begin = static_cast<double>(box.begin[axis]) - 0.5;
    const double end = static_cast<double>(box.end[axis]) - 0.5;
    bounds.min[axis] = lattice.origin[axis] + begin * lattice.voxelSize[axis];
    bounds.max[axis] = lattice.origin[axis] + end * lattice.voxelSize[axis];
  }
  return bounds;
}

/// The voxels between `bounds`, which must lie on voxel faces.
Result<IndexBox> toIndexBox(const LatticeFrame& lattice, const Box3& bounds,
                            const std::string& where) {
  constexpr double kOnGrid = 1e-3;  // voxels
  constexpr double kFarthest = 2e9;
  if (bounds.empty() || !bounds.min.allFinite() || !bounds.max.allFinite()) {
    return fail(ErrorCode::kInvalidArgument,
                "{}: bounds {} are empty; expected min < max on every axis", where, text(bounds));
  }
  IndexBox box;
  bool onGrid = true;
  for (int axis = 0; axis < 3; ++axis) {
    const double begin = (bounds.min[axis] - lattice.origin[axis]) / lattice.voxelSize[axis] + 0.5;
    const double end = (bounds.max[axis] - lattice.origin[axis]) / lattice.voxelSize[axis] + 0.5;
    if (!(std::abs(begin) < kFarthest && std::abs(end) < kFarthest)) {
      return fail(ErrorCode::kInvalidArgument, "{}: bounds {} are too far from its voxels of {}",
                  where, text(bounds), text(lattice.voxelSize));
    }
    onGrid = onGrid && std::abs(begin - std::round(begin)) <= kOnGrid &&
             std::abs(end - std::round(end)) <= kOnGrid;
    box.begin[axis] = std::llround(begin);
    box.end[axis] = std::max(std::llround(end), box.begin[axis] + 1LL);
  }
  if (onGrid)
    return box;
  return fail(ErrorCode::kInvalidArgument,
              "{}: bounds {} do not lie on its voxels' faces; the nearest that do are {}", where,
              text(bounds), text(toBounds(lattice, box)));
}

/// Refuses what a damaged box may ask for, before anything is allocated.
Status checkSize(const IndexBox& box, int channels, std::uint64_t maxMemory,
                 const std::string& where, bool byLayers) {
  const double bytes = 4.0 * channels * box.size(0) * box.size(1) * box.size(2);
  constexpr std::int64_t kMax = 1'000'000'000;  // so that shifted indices stay within 32 bits
  const bool huge = std::ranges::any_of(std::array{0, 1, 2}, [&](int axis) {
    return box.size(axis) > kMax || box.begin[axis] < -kMax || box.end[axis] > kMax;
  });
  if (!huge && (byLayers || bytes <= static_cast<double>(maxMemory)))
    return {};
  if (huge) {
    return fail(ErrorCode::kTooLarge, Hint::set("bounds"),
                "{}: voxels lie at indices from ({}, {}, {}) to ({}, {}, {}); those up to {} on "
                "either side of 0 can be counted, in boxes as wide as that",
                where, box.begin[0], box.begin[1], box.begin[2], box.end[0] - 1, box.end[1] - 1,
                box.end[2] - 1, kMax);
  }
  return fail(ErrorCode::kTooLarge, {Hint::set("bounds"), Hint::raise("max_memory")},
              "{}: a frame of {} x {} x {} voxels needs {:.0f} MiB, more than the {} MiB allowed",
              where, box.size(0), box.size(1), box.size(2), bytes / (1 << 20),
              static_cast<double>(maxMemory) / (1 << 20));
}

/// The times that files state. Files without the grid say none: theirs lie between their
/// neighbours', by their numbers.
std::vector<double> timesOf(const std::vector<LatticeFile>& files,
                            const std::vector<LatticeFrame>& frames,
                            const std::vector<bool>& present) {
  std::vector<double> times;
  std::vector<std::size_t> stated;
  for (std::size_t i = 0; i < files.size(); ++i) {
    times.push_back(files[i].time.value_or(frames[i].time));
    if (present.empty() || present[i])
      stated.push_back(i);
  }
  if (stated.size() < 2)
    return times;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto after = std::clamp<std::ptrdiff_t>(
        std::ranges::lower_bound(stated, i) - stated.begin(), 1, std::ssize(stated) - 1);
    const std::size_t a = stated[static_cast<std::size_t>(after - 1)],
                      b = stated[static_cast<std::size_t>(after)];
    if (files[i].time || present.empty() || present[i])
      continue;
    const double share = (files[i].number - files[a].number) /
                         static_cast<double>(files[b].number - files[a].number);
    times[i] = times[a] + share * (times[b] - times[a]);
  }
  return times;
}

/// Stated times when all frames have one and they ascend; else none, and `remark` says why where
/// some are stated and differ.
std::vector<double> statedTimes(const std::vector<LatticeFile>& files,
                                const std::vector<LatticeFrame>& frames,
                                const std::vector<bool>& present, std::string& remark) {
  constexpr double kUnwritten = 1e30;  // netCDF's fill value, say
  const auto all = timesOf(files, frames, present);
  const auto timeOf = [&](std::size_t i) { return all[i]; };
  std::vector<double> times;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const double time = timeOf(i);
    if (std::abs(time) < kUnwritten && (times.empty() || time > times.back())) {
      times.push_back(time);
      continue;
    }
    bool differ = false;
    for (std::size_t k = 1; k < files.size(); ++k) differ = differ || timeOf(k) != timeOf(0);
    if (differ &&
        std::ranges::any_of(frames, [](const auto& f) { return std::isfinite(f.time); })) {
      remark = fmt::format(
          "{}: {}, so that the times that the files state are not used: frames follow each other "
          "by their numbers",
          files[i].path.string(),
          std::isfinite(time)
              ? fmt::format("states {} s, which is not after the file before it", plainNumber(time))
              : std::string("states no time"));
    }
    return {};
  }
  return times;
}

std::string contradictionIn(const std::vector<LatticeFile>& files,
                            const std::vector<LatticeFrame>& frames) {
  std::vector<CollectedFile> collected;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (files[i].time)
      // NOLINTNEXTLINE(bugprone-unchecked-optional-access): asked for above
      collected.push_back({files[i].path, *files[i].time, frames[i].time});
  }
  return contradictionOf(collected);
}

bool isOfData(const Error& error) {
  return error.code == ErrorCode::kInvalidData || error.code == ErrorCode::kTruncated;
}

/// What is wrong with data of one file of several says which frame that is, which of the later ones
/// are as bad, and what to do.
/// @param open  whether a file can be used
Error inFrame(Error error, const std::vector<LatticeFile>& files, std::size_t i,
              const std::function<Status(std::size_t)>& open) {
  if (files.size() == 1 || !isOfData(error))
    return error;
  constexpr std::size_t kNamed = 8;
  std::vector<std::string> others;
  for (std::size_t k = i + 1; k < files.size(); ++k) {
    if (const auto opened = open(k); !opened && isOfData(opened.error()))
      others.push_back(files[k].frameText());
  }
  const std::size_t more = others.size() - std::min(others.size(), kNamed);
  others.resize(others.size() - more);
  error.message += fmt::format(" (frame {}{}{}{})", files[i].frameText(),
                               others.empty() ? "" : "; nor can be used ", fmt::join(others, ", "),
                               more > 0 ? fmt::format(" and {} more", more) : "");
  if (others.size() + 1 < files.size())
    error.message += others.empty() ? "; without that file the sequence has a gap there"
                                    : "; without these files the sequence has gaps there";
  error.statement.clear();
  return error;
}

class LatticeSource final : public LayerwiseSource,
                            public PlacedFrames,
                            public VectorFrames,
                            public CountedFrames,
                            public WrittenFrames {
 public:
  LatticeSource(std::vector<LatticeFile> files, Result<const LatticePlugin*> (*loadPlugin)(),
                const SourceOptions& options, std::optional<KnownGrid> known)
      : files_(std::move(files)),
        process_(readerOf(files_, loadPlugin)),
        options_(options),
        known_(std::move(known)) {}

  /// Reads what the files say about themselves and settles the volume's place and size.
  Status open() {
    std::vector<LatticeFrame> frames;
    std::string grid = known_ ? known_->name : options_.grid;
    const bool isDefault = grid.empty();
    if (known_)
      frames = known_->frames;
    if (!known_)
      VOLUTE_TRY(describeAll(grid, frames));
    VOLUTE_ASSIGN(auto places, latticePlaces(files_, frames));
    VOLUTE_TRY(checkUp(frames, grid));
    if (isDefault && !options_.bounds && places.box.empty())
      takeOneWithVoxels(grid, frames, places);
    if (!unchosen_.empty() && options_.remark) {
      options_.remark(Remark(RemarkCode::kAssumed,
                             fmt::format("{}: the grid '{}' is read; it also has {}",
                                         files_[0].path.string(), grid, unchosen_),
                             {Hint::choose("field")})
                          .in(files_[0].path.string()));
    }
    tellWhereMissing();
    shifts_ = std::move(places.shifts);
    IndexBox box = places.box;
    grid_ = grid;
    const std::string where = files_.front().path.string();
    if (!places.matrices.empty()) {
      const GridSpace space{frames.front().voxelSize, frames.front().origin};
      for (const GridMatrix& matrix : places.matrices) places_.push_back(placeIn(matrix, space));
    }
    if (options_.bounds && !places_.empty()) {
      return fail(ErrorCode::kInvalidArgument,
                  "{}: grid '{}' is turned, or moves by parts of a voxel, so that bounds along the "
                  "axes do not crop it; leave them out",
                  where, grid);
    }
    if (options_.bounds) {
      VOLUTE_ASSIGN(box, toIndexBox(frames.front(), *options_.bounds, where));
      tellCut(places.box, box, frames.front(), where);
    } else if (box.empty()) {
      return fail(
          ErrorCode::kInvalidData, "{}: grid '{}' is empty{}", where, grid,
          files_.size() == 1 ? std::string() : fmt::format(" in all {} frames", files_.size()));
    }
    hasBricks_ = std::ranges::any_of(frames, [](const auto& frame) { return frame.bricks; });
    rounded_ = std::ranges::any_of(frames, [](const auto& frame) { return frame.rounded; });
    VOLUTE_TRY(checkSize(box, frames.front().channels, options_.maxMemory, where,
                         options_.byLayers || hasBricks_));
    box_ = box;
    for (const LatticeFrame& frame : frames) {
      memory_ = std::max(memory_, frame.memory);
      amounts_.push_back(frame.box.empty() ? 0 : static_cast<double>(frame.memory));
    }
    fillInfo(frames);
    return info_.validate(where);
  }

  const VolumeInfo& info() const override { return info_; }

  const std::vector<GridMatrix>& places() const override { return places_; }

  VectorKind vectors() const override { return vectors_; }

  const std::string& writer() const override { return writer_; }

  const std::string& gridClass() const override { return gridClass_; }

  std::vector<double> amounts() const override {
    return memory_ > 0 ? amounts_ : std::vector<double>();
  }

  std::pair<std::string, VoxelIndex> fileOf(int frame) const override {
    const auto i = static_cast<std::size_t>(frame);
    const auto& shift = shifts_[i];
    return {files_[i].path.string(), box_.shifted({-shift[0], -shift[1], -shift[2]}).begin};
  }

  std::vector<std::string> otherGrids() const override { return others_; }

  Status readLayers(int index, int first, int end, std::span<float> values) override {
    VOLUTE_ASSERT(values.size() == info_.frameValues() / static_cast<std::size_t>(info_.z) *
                                       static_cast<std::size_t>(end - first));
    if (known_ && !known_->present[static_cast<std::size_t>(index)]) {
      const auto channels = static_cast<std::size_t>(info_.channels);
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<float>(known_->background[i % channels] - offset_);
      return {};
    }
    const Request request = readingOf(index, first, end);
    const auto& path = files_[index].path;
    VOLUTE_ASSIGN(const std::string reply,
                  process_.call(path.string(), toMessage(request) + path.string(), values.size(),
                                limitsFor(path, values.size(), options_.maxMemory)));
    VOLUTE_ASSIGN(const double rounding, fromMessage<double>(reply));
    rounding_ = std::max(rounding_, rounding);
    std::ranges::copy(process_.values(), values.begin());
    return {};
  }

  double rounding() const override { return rounding_; }

  double offset() const override { return offset_; }

  bool mayRound() const override { return rounded_; }

  bool takesOffset() const override { return true; }

  void takeOffset(double offset) override { offset_ = offset, rounding_ = 0; }

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    if (!hasBricks_)
      return FrameSource::readBricks(index, first, end, bricks);
    if (known_ && !known_->present[static_cast<std::size_t>(index)]) {
      const auto& background = known_->background;
      bricks = Bricks(info_.channels, {static_cast<float>(background[0] - offset_),
                                       static_cast<float>(background[1] - offset_),
                                       static_cast<float>(background[2] - offset_)});
      return {};
    }
    Request request = readingOf(index, first, end);
    request.bricks = true;
    const auto& path = files_[index].path;
    const std::string message = toMessage(request) + path.string();
    VOLUTE_ASSIGN(const std::string reply,
                  process_.call(path.string(), message, 0, limitsFor(path, 0, options_.maxMemory)));
    VOLUTE_ASSIGN(const auto said, fromMessage<BricksReply>(reply));
    const std::uint64_t bytes = said.bytes;
    rounding_ = std::max(rounding_, said.rounding);
    tellLostBackground(said.lostBackground, path);
    if (bytes > options_.maxMemory) {
      return fail(ErrorCode::kTooLarge,
                  "{}: frame {} holds {} MiB of voxels, more than the {} MiB of memory allowed",
                  path.string(), files_[index].number, bytes >> 20, options_.maxMemory >> 20);
    }
    const std::size_t values = (static_cast<std::size_t>(bytes) + 3) / 4;
    VOLUTE_TRY(
        process_.call(path.string(), message, values, limitsFor(path, values, options_.maxMemory)));
    // The child may still write to what is shared.
    const std::vector<float> copy(process_.values().begin(), process_.values().end());
    auto read = Bricks::fromMessage(std::as_bytes(std::span(copy)));
    if (!read || read->channels() != info_.channels)
      return fail(ErrorCode::kInvalidData, "{}: its reader {}", path.string(),
                  read ? "gives other channels" : read.error().message);
    bricks = *std::move(read);
    bricks.shift({-request.whole.begin[0], -request.whole.begin[1], -request.whole.begin[2]});
    if (request.flag)
      bricks.crop({{0, 0, 0}, {info_.x, info_.y, info_.z}});
    return {};
  }

  bool hasTopology() const override { return hasBricks_; }

  std::uint64_t brickBytes() const override {
    if (!hasBricks_ || memory_ == 0)
      return FrameSource::brickBytes();
    return std::min(memory_, FrameSource::brickBytes());
  }

 private:
  /// Who states bounds cuts on purpose; who leaves nothing does not.
  void tellCut(const IndexBox& whole, const IndexBox& box, const LatticeFrame& lattice,
               const std::string& file) const {
    if (whole.empty() || box.contains(whole) || !options_.remark)
      return;
    const bool nothing = box.intersection(whole).empty();
    options_.remark(Remark(nothing ? RemarkCode::kLeftOut : RemarkCode::kNote,
                           fmt::format("{}: '{}' takes {}; {} the bounds", file, grid_,
                                       text(toBounds(lattice, whole)),
                                       nothing ? "nothing of it lies within" : "it is cut to"))
                        .in(file));
  }

  /// Programs say with it that nothing is known there.
  void tellLostBackground(double background, const std::filesystem::path& file) {
    if (background == 0 || !options_.remark || std::exchange(toldBackground_, true))
      return;
    options_.remark(Remark(RemarkCode::kChanged,
                           fmt::format("{}: the background of '{}' is {} and is taken as 0",
                                       file.string(), grid_, background))
                        .in(file.string()));
  }

  /// What is asked of a file for some layers of its frame.
  Request readingOf(int index, int first, int end) const {
    const auto& shift = shifts_[static_cast<std::size_t>(index)];
    Request request;
    request.flag = options_.bounds.has_value();
    request.whole = box_.shifted({-shift[0], -shift[1], -shift[2]});
    request.box = request.whole;
    request.box.begin[2] = request.whole.begin[2] + first;
    request.box.end[2] = request.whole.begin[2] + end;
    grid_.copy(request.grid, LatticeFrame::kMaxName);
    request.less = offset_;
    sample(request);
    return request;
  }

  void sample(Request& request) const {
    request.sampled = options_.frusta.has_value();
    request.frusta = options_.frusta.value_or(FrustumSampling());
  }

  Result<LatticeFrame> describe(std::size_t index, const std::string& grid) {
    const auto& path = files_[index].path;
    Request request;
    request.describe = true;
    request.flag = true;  // what bounds cut is told
    grid.copy(request.grid, LatticeFrame::kMaxName);
    options_.usualGrid.copy(request.usual, LatticeFrame::kMaxName);
    sample(request);
    VOLUTE_ASSIGN(const std::string reply,
                  process_.call(path.string(), toMessage(request) + path.string(), 0,
                                limitsFor(path, 0, options_.maxMemory)));
    VOLUTE_ASSIGN(auto frame, detail::decodeFrame(reply, path.string()));
    // The first one settles the lattice of all.
    if (options_.frusta && options_.frusta->indexToWorld == GridMatrix{} && !frame.turned)
      options_.frusta->indexToWorld = alongAxes(frame.voxelSize, frame.origin);
    return frame;
  }

  /// `grid`, or the one that is meant where it is empty, in all files. Simulations leave out what
  /// is not there yet: a file without the grid has an empty one.
  Status describeAll(std::string& grid, std::vector<LatticeFrame>& frames) {
    std::vector<bool> present;
    std::optional<Error> missing;
    std::size_t first = files_.size();
    for (std::size_t i = 0; i < files_.size(); ++i) {
      auto frame = describe(i, grid);
      std::error_code error;
      const bool absent = !frame && !grid.empty() && frame.error().code == ErrorCode::kNotFound &&
                          std::filesystem::exists(files_[i].path, error);
      if (!frame && !absent)
        return tl::unexpected(inFrame(std::move(frame.error()), files_, i, [&](std::size_t k) {
          return Status(describe(k, grid).map([](const auto&) {}));
        }));
      present.push_back(!absent);
      if (absent) {
        if (!missing)
          missing = frame.error();
        frames.emplace_back();
        continue;
      }
      const std::string_view others(frame->others,
                                    ::strnlen(frame->others, LatticeFrame::kMaxName));
      if (grid.empty())
        unchosen_ = others;
      grid = frame->grid;
      for (const std::string& name : namesOfGrids(others)) {
        if (std::ranges::find(others_, name) == others_.end())
          others_.push_back(name);
      }
      first = std::min(first, i);
      frames.push_back(*frame);
    }
    if (first == files_.size())
      // NOLINTNEXTLINE(bugprone-unchecked-optional-access): no file has the grid
      return tl::unexpected(std::move(*missing));
    if (!missing)
      return {};
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (present[i])
        continue;
      frames[i] = frames[first];
      frames[i].box = {};
      frames[i].time = std::numeric_limits<double>::quiet_NaN();
    }
    known_ = KnownGrid{grid, frames, std::move(present), {}, std::move(missing->message)};
    return {};
  }

  /// One sequence has one up axis.
  Status checkUp(const std::vector<LatticeFrame>& frames, const std::string& grid) const {
    const auto said = [](const LatticeFrame& frame) {
      if (frame.up == 0)
        return std::string("does not say which axis points upwards");
      return frame.writer[0] == '\0' ? fmt::format("says that {} points upwards", frame.up)
                                     : fmt::format("was written by {}, where {} points upwards",
                                                   frame.writer, frame.up);
    };
    for (std::size_t i = 1; i < frames.size() && !options_.upStated; ++i) {
      if (frames[i].up == frames[0].up)
        continue;
      const char stated = frames[0].up ? frames[0].up : frames[i].up;
      return fail(ErrorCode::kInvalidData,
                  Hint::set("up", std::string(1, stated)).so("takes that for all of them"),
                  "{}: grid '{}', frame {}: the file {}, but {} {}; expected one up axis in all "
                  "frames",
                  files_[i].path.string(), grid, files_[i].frameText(), said(frames[i]),
                  files_[0].path.string(), said(frames[0]));
    }
    return {};
  }

  /// Simulations leave grids out where they are empty, and other tools call them otherwise.
  void tellWhereMissing() const {
    if (!known_ || known_->missing.empty() || !options_.remark)
      return;
    constexpr std::size_t kNamed = 8;
    std::vector<std::string> frames;
    for (std::size_t i = 0; i < files_.size(); ++i) {
      if (!known_->present[i])
        frames.push_back(files_[i].frameText());
    }
    const std::size_t more = frames.size() - std::min(frames.size(), kNamed), count = frames.size();
    frames.resize(count - more);
    options_.remark({RemarkCode::kAssumed,
                     fmt::format("{}: it is taken as empty in {} of {} frames: {}{}",
                                 known_->missing, count, files_.size(), fmt::join(frames, ", "),
                                 more > 0 ? fmt::format(" and {} more", more) : "")});
  }

  /// Where the grid that is meant is empty in all frames: another one that is not, if there is one.
  void takeOneWithVoxels(std::string& grid, std::vector<LatticeFrame>& frames,
                         LatticePlaces& places) {
    const std::string emptyGrid = grid, emptyOthers = unchosen_;
    const auto emptyKnown = known_;
    for (const std::string& name : namesOfGrids(emptyOthers)) {
      std::string other = name;
      std::vector<LatticeFrame> its;
      known_.reset();
      if (!describeAll(other, its))
        continue;
      auto found = latticePlaces(files_, its);
      if (!found || found->box.empty())
        continue;
      if (options_.remark) {
        options_.remark(Remark(RemarkCode::kFallback,
                               fmt::format("{}: the grid '{}' is empty, so '{}' is read instead",
                                           files_[0].path.string(), emptyGrid, other))
                            .in(files_[0].path.string()));
      }
      grid = other, frames = std::move(its), places = std::move(*found);
      unchosen_.clear();
      std::erase(others_, grid);
      if (std::ranges::find(others_, emptyGrid) == others_.end())
        others_.push_back(emptyGrid);
      return;
    }
    known_ = emptyKnown;
  }

  void fillInfo(const std::vector<LatticeFrame>& frames) {
    info_.name = grid_;
    info_.frames = static_cast<int>(files_.size());
    info_.x = static_cast<int>(box_.size(0));
    info_.y = static_cast<int>(box_.size(1));
    info_.z = static_cast<int>(box_.size(2));
    info_.channels = frames.front().channels;
    info_.bounds = toBounds(frames.front(), box_);
    for (const auto& file : files_) info_.frameNumbers.push_back(file.number);
    info_.frameScale = files_.front().scale;
    info_.up = frames.front().up;
    info_.unit = frames.front().unit;
    info_.levelSet = frames.front().levelSet;
    writer_ = frames.front().writer;
    gridClass_ = frames.front().gridClass;
    vectors_ = frames.front().vectors;
    std::string remark;
    info_.times =
        statedTimes(files_, frames, known_ ? known_->present : std::vector<bool>(), remark);
    if (!remark.empty() && options_.remark)
      options_.remark({RemarkCode::kAssumed, remark});
    const auto hidden = std::ranges::find_if(frames, &LatticeFrame::hidden);
    if (hidden != frames.end() && options_.remark) {
      const std::string& file = files_[static_cast<std::size_t>(hidden - frames.begin())].path;
      options_.remark(
          Remark(RemarkCode::kLeftOut, fmt::format("{}: {} of its values are marked as hidden "
                                                   "(vtkGhostType) and taken as 0",
                                                   file, hidden->hidden))
              .in(file));
    }
    const auto rest = std::ranges::find_if(
        frames, [](const LatticeFrame& frame) { return frame.leftOut[0] != '\0'; });
    if (rest != frames.end() && options_.remark) {
      const std::string& file = files_[static_cast<std::size_t>(rest - frames.begin())].path;
      options_.remark(Remark(RemarkCode::kLeftOut,
                             fmt::format("{}: not read: {}", file, std::string(rest->leftOut)))
                          .in(file));
    }
    if (remark = contradictionIn(files_, frames); !remark.empty() && options_.remark)
      options_.remark({RemarkCode::kDoubtful, remark});
    info_.fillDefaults();
  }

  std::vector<LatticeFile> files_;
  ReaderProcess process_;
  SourceOptions options_;
  std::optional<KnownGrid> known_;
  std::string grid_, writer_, gridClass_;
  std::vector<std::string> others_;
  std::string unchosen_;  ///< the grids of the file that first had the grid, where none was named
  IndexBox box_;          // on the first frame's lattice
  std::vector<std::array<std::int64_t, 3>> shifts_;
  std::vector<GridMatrix> places_;
  VectorKind vectors_;
  bool hasBricks_ = false, rounded_ = false, toldBackground_ = false;
  std::uint64_t memory_ = 0;  // of the bricks of a frame, about
  std::vector<double> amounts_;
  VolumeInfo info_;
  double rounding_ = 0, offset_ = 0;
};

/// Answers a collection's name with the files that it names.
Result<ReaderProcess::Serve> serveCollection(std::string_view parameters) {
  VOLUTE_ASSIGN(const auto loadPlugin, fromMessage<LoadLatticePlugin>(parameters));
  VOLUTE_ASSIGN(const LatticePlugin* plugin, loadPlugin());
  return [plugin](std::string_view name, std::span<float>) -> Result<std::string> {
    VOLUTE_ASSIGN(const auto files, plugin->readCollection(name));
    std::string text = detail::encodeFiles(files);
    if (text.size() > ReaderProcess::kMaxMessage)
      return fail(ErrorCode::kTooLarge, "{}: names too many files", name);
    return text;
  };
}

Result<std::unique_ptr<FrameSource>> openedSource(std::vector<LatticeFile> files,
                                                  LoadLatticePlugin loadPlugin,
                                                  const SourceOptions& options,
                                                  std::optional<KnownGrid> known) {
  VOLUTE_ASSERT(!files.empty());
  if (options.grid.size() > LatticeFrame::kMaxName) {
    return fail(ErrorCode::kInvalidArgument, "a grid's name of {} characters; expected {} at most",
                options.grid.size(), LatticeFrame::kMaxName);
  }
  auto source =
      std::make_unique<LatticeSource>(std::move(files), loadPlugin, options, std::move(known));
  VOLUTE_TRY(source->open());
  return source;
}

}  // namespace

Result<LatticePlaces> latticePlaces(const std::vector<LatticeFile>& files,
                                    const std::vector<LatticeFrame>& frames) {
  LatticePlaces places;
  const LatticeFrame& first = frames.front();
  bool oneLattice = true;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].channels != first.channels) {
      return fail(ErrorCode::kInvalidData,
                  "{}: frame {} has {} channels, but the first frame has {}",
                  files[i].path.string(), files[i].frameText(), frames[i].channels, first.channels);
    }
    const auto shift = latticeShift(first, frames[i]);
    oneLattice = oneLattice && shift;
    places.shifts.push_back(shift.value_or(std::array<std::int64_t, 3>{}));
  }
  if (!oneLattice)
    std::ranges::fill(places.shifts, std::array<std::int64_t, 3>{});
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const LatticeFrame& frame = frames[i];
    places.box.extend(frame.box.shifted(places.shifts[i]));
    if (!oneLattice)
      places.matrices.push_back(frame.turned ? frame.matrix
                                             : alongAxes(frame.voxelSize, frame.origin));
  }
  return places;
}

Result<std::unique_ptr<FrameSource>> openLatticeSource(std::vector<LatticeFile> files,
                                                       Result<const LatticePlugin*> (*loadPlugin)(),
                                                       const SourceOptions& options) {
  return openedSource(std::move(files), loadPlugin, options, std::nullopt);
}

Result<std::unique_ptr<FrameSource>> openLatticeSource(std::vector<LatticeFile> files,
                                                       Result<const LatticePlugin*> (*loadPlugin)(),
                                                       const SourceOptions& options,
                                                       KnownGrid known) {
  VOLUTE_ASSERT(known.frames.size() == files.size() && known.present.size() == files.size());
  return openedSource(std::move(files), loadPlugin, options, std::move(known));
}

Result<std::vector<LatticeCache>> describeCache(const std::vector<LatticeFile>& files,
                                                std::uint64_t maxMemory) {
  ReaderProcess process(readerOf(files, loadVdbPlugin));
  std::vector<LatticeCache> caches;
  const auto ask = [&](const std::filesystem::path& path) {
    Request request;
    request.cache = true;
    // Grids whose box the file does not note are read for it.
    ReaderProcess::Limits limits = limitsFor(path, 0, maxMemory);
    limits.seconds += 2e-6 * static_cast<double>(sizeOf(path));
    return HeldBytes::ask(process, path, request, limits);
  };
  for (std::size_t i = 0; i < files.size(); ++i) {
    const LatticeFile& file = files[i];
    const std::string name = file.path.string();
    auto asked = ask(file.path);
    if (!asked) {
      return tl::unexpected(inFrame(std::move(asked.error()), files, i, [&](std::size_t k) {
        return Status(ask(files[k].path).map([](const auto&) {}));
      }));
    }
    HeldBytes bytes = std::move(*asked);
    constexpr std::uint64_t kMaxBytes = std::uint64_t{32} << 20;
    if (bytes.size() > kMaxBytes) {
      return fail(ErrorCode::kTooLarge,
                  "{}: what its grids say of themselves takes {} KiB; expected {} at most", name,
                  bytes.size() >> 10, kMaxBytes >> 10);
    }
    std::string all;
    while (all.size() < bytes.size()) {
      VOLUTE_ASSIGN(const auto part, bytes.next());
      all.append(reinterpret_cast<const char*>(part.data()), part.size());
    }
    VOLUTE_ASSIGN(auto cache, detail::decodeCache(all, name));
    caches.push_back(std::move(cache));
  }
  return caches;
}

KeptReader::KeptReader(const std::vector<LatticeFile>& files, std::uint64_t maxMemory)
    : process_(std::make_unique<ReaderProcess>(readerOf(files, loadVdbPlugin))),
      maxMemory_(maxMemory) {}

KeptReader::~KeptReader() = default;

Result<std::unique_ptr<KeptBytes>> KeptReader::open(const std::filesystem::path& file,
                                                    std::size_t grid) const {
  Request request;
  request.keep = true;
  request.offset = grid;
  request.limit = maxMemory_;
  VOLUTE_ASSIGN(auto bytes,
                HeldBytes::ask(*process_, file, request, limitsFor(file, 0, maxMemory_)));
  if (bytes.size() == 0 || bytes.size() > maxMemory_)
    return fail(ErrorCode::kInvalidData, "{}: its reader gives a grid of {} bytes", file.string(),
                bytes.size());
  return std::make_unique<HeldBytes>(std::move(bytes));
}

Result<std::vector<GridFacts>> listGrids(const std::filesystem::path& file,
                                         std::uint64_t maxMemory) {
  const std::string name = file.string();
  VOLUTE_TRY(InputFile::check(file));
  ReaderProcess process(readerOf({{0, file, std::nullopt}}, loadVdbPlugin));
  Request request;
  request.list = true;
  request.limit = maxMemory;
  // Every grid is read for its range, and its topology again for each part of it.
  ReaderProcess::Limits limits = limitsFor(file, 0, maxMemory);
  limits.seconds += 2e-6 * static_cast<double>(sizeOf(file));
  VOLUTE_ASSIGN(const std::string reply, process.call(name, toMessage(request) + name, 0, limits));
  return detail::decodeGridFacts(reply);
}

Result<std::vector<TimedFile>> readCollection(const std::filesystem::path& collection,
                                              Result<const LatticePlugin*> (*loadPlugin)()) {
  const std::string name = collection.string();
  VOLUTE_TRY(InputFile::check(collection));
  ReaderJob job = jobWith(loadPlugin, serveCollection);
  job.readable = {collection};
  ReaderProcess process(std::move(job));
  VOLUTE_ASSIGN(const std::string reply, process.call(name, name, 0, limitsFor(collection, 0, 0)));
  return detail::decodeFiles(reply, name);
}

}  // namespace volute
