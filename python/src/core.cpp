// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// volute._core: .volute files and FDS cases as arrays. Python's own part (volute/*.py) makes them
// comfortable; here is what must be fast.

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include "bridge.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/version.hpp"
#include "volute/codec/compress.hpp"
#include "volute/codec/extract_source.hpp"
#include "volute/codec/recompress.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/fds/fds_volume.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/masked_source.hpp"
#include "volute/grid/resample.hpp"

namespace volute::python {
namespace {

using Indices = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;
using Values = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// Voxels of one axis that lie in one block and are asked for.
struct Run {
  std::size_t to;  ///< place in the result
  int from;        ///< in the block
  int length;      ///< so many follow each other in both
};

struct AxisPart {
  int block = 0;
  std::vector<Run> runs;
};

/// What is asked for on an axis, by blocks.
std::vector<AxisPart> partsOf(const std::vector<std::int64_t>& indices, int side) {
  std::vector<AxisPart> parts;
  for (std::size_t place = 0; place < indices.size(); ++place) {
    const auto block = static_cast<int>(indices[place] / side);
    const auto from = static_cast<int>(indices[place] % side);
    auto part = std::ranges::find(parts.rbegin(), parts.rend(), block, &AxisPart::block);
    if (part == parts.rend()) {
      parts.push_back({block, {}});
      part = parts.rbegin();
    }
    if (!part->runs.empty()) {
      Run& last = part->runs.back();
      if (last.from + last.length == from &&
          last.to + static_cast<std::size_t>(last.length) == place) {
        ++last.length;
        continue;
      }
    }
    part->runs.push_back({place, from, 1});
  }
  return parts;
}

bool isRange(const std::vector<std::int64_t>& indices) {
  for (std::size_t i = 1; i < indices.size(); ++i) {
    if (indices[i] != indices[i - 1] + 1)
      return false;
  }
  return true;
}

/// The same for all four axes.
class Gather {
 public:
  Gather(const VoluteReader& reader, const std::array<std::vector<std::int64_t>, 4>& indices,
         int levels)
      : reader_(reader), levels_(levels) {
    for (std::size_t axis = 0; axis < 4; ++axis) {
      sizes_[axis] = indices[axis].size();
      parts_[axis] = partsOf(indices[axis], reader.blocks().sides()[axis]);
    }
  }

  /// Each touched block is decoded once.
  Status read(float* values, Progress& progress) const {
    std::size_t count = 1;
    for (const auto& parts : parts_) count *= parts.size();
    constexpr std::size_t kBatch = 256;  // between batches one may ask to stop
    for (std::size_t begin = 0; begin < count; begin += kBatch) {
      if (progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped");
      std::vector<Status> done(std::min(kBatch, count - begin));
      parallelFor(done.size(), [&](std::size_t i) { done[i] = readBlock(begin + i, values); });
      for (Status& status : done) VOLUTE_TRY(std::move(status));
    }
    return {};
  }

 private:
  Status readBlock(std::size_t number, float* values) const {
    std::array<const AxisPart*, 4> part{};
    BlockGrid::Index4 at{};
    for (std::size_t axis = 4; axis-- > 0; number /= parts_[axis].size()) {
      part[axis] = &parts_[axis][number % parts_[axis].size()];
      at[axis] = part[axis]->block;
    }
    const BlockGrid& grid = reader_.blocks();
    const std::size_t block = grid.blockAt(at);
    const BlockGrid::Index4 extents = grid.extents(block);
    std::vector<float> decoded(grid.values(block));
    FrameSpan wanted{grid.frames(), 0};
    for (const Run& run : part[0]->runs) {
      wanted.first = std::min(wanted.first, run.from);
      wanted.end = std::max(wanted.end, run.from + run.length);
    }
    VOLUTE_TRY(reader_.readBlock(block, decoded, levels_, wanted));
    const auto channels = static_cast<std::size_t>(grid.channels());
    eachIndex(*part[0], [&](std::size_t t, int fromT) {
      eachIndex(*part[1], [&](std::size_t z, int fromZ) {
        eachIndex(*part[2], [&](std::size_t y, int fromY) {
          const std::size_t row = ((t * sizes_[1] + z) * sizes_[2] + y) * sizes_[3];
          const std::size_t fromRow =
              ((static_cast<std::size_t>(fromT) * extents[1] + fromZ) * extents[2] + fromY) *
              extents[3];
          for (const Run& run : part[3]->runs) {
            std::copy_n(&decoded[(fromRow + run.from) * channels], run.length * channels,
                        values + (row + run.to) * channels);
          }
        });
      });
    });
    return {};
  }

  template <class Call>
  static void eachIndex(const AxisPart& part, Call&& call) {
    for (const Run& run : part.runs) {
      for (int i = 0; i < run.length; ++i) call(run.to + static_cast<std::size_t>(i), run.from + i);
    }
  }

  const VoluteReader& reader_;
  int levels_;
  std::array<std::size_t, 4> sizes_{};
  std::array<std::vector<AxisPart>, 4> parts_;
};

py::tuple tupleOf(const Vec3& v) {
  return py::make_tuple(v.x(), v.y(), v.z());
}

/// Whole numbers, or with decimals where the files' names have them.
py::array frameNumbers(const VolumeInfo& info) {
  if (info.frameScale.decimals == 0)
    return py::array_t<int>(info.frameNumbers.size(), info.frameNumbers.data());
  py::array_t<double> numbers(info.frameNumbers.size());
  for (std::size_t i = 0; i < info.frameNumbers.size(); ++i)
    numbers.mutable_at(static_cast<py::ssize_t>(i)) = info.frameScale.frame(info.frameNumbers[i]);
  return numbers;
}

/// @param places  as GridDescription has them
py::dict describe(const VolumeInfo& info, const std::vector<GridMatrix>& places = {}) {
  using namespace py::literals;
  py::object matrices = py::none();
  if (!places.empty()) {
    py::array_t<double> all(
        {static_cast<py::ssize_t>(places.size()), py::ssize_t{3}, py::ssize_t{4}});
    for (std::size_t frame = 0; frame < places.size(); ++frame) {
      const GridMatrix matrix = indexToWorld(info, places, frame);
      std::ranges::copy(matrix, all.mutable_data() + frame * matrix.size());
    }
    matrices = std::move(all);
  }
  const Box3 box = places.empty() ? info.bounds : aroundPlaces(info.bounds, places);
  const std::string up = info.up == 0 ? std::string() : std::string(1, info.up);
  return py::dict("name"_a = info.name, "unit"_a = info.unit,
                  "shape"_a = py::make_tuple(info.frames, info.z, info.y, info.x, info.channels),
                  "bounds"_a = py::make_tuple(tupleOf(box.min), tupleOf(box.max)),
                  "voxel_size"_a = tupleOf(info.voxelSize()), "matrices"_a = matrices, "up"_a = up,
                  "times"_a = py::array_t<double>(info.times.size(), info.times.data()),
                  "frame_numbers"_a = frameNumbers(info),
                  "basis"_a = std::string(basisName(info.basis)));
}

class File {
 public:
  File(const std::filesystem::path& path, bool partial, std::uint64_t maxMemory,
       const std::string& grid)
      : reader_(take(unlocked([&] {
          return VoluteReader::open(path, {.partial = partial,
                                           .maxMemory = maxMemory,
                                           .grid = grid,
                                           .differences = Offsets::kAll});
        }))) {}

  py::dict info() const {
    VolumeInfo info = reader_.info();
    if (reader_.grid().empty)  // no grid has values
      info.z = info.y = info.x = 0;
    const auto& description = reader_.grid().description;
    return describe(info, description ? description->places() : std::vector<GridMatrix>());
  }

  py::dict header() const {
    using namespace py::literals;
    const VoluteHeader& h = reader_.header();
    return py::dict(
        "version"_a = py::make_tuple(h.versionMajor, h.versionMinor), "written_by"_a = h.writtenBy,
        "provenance"_a = h.provenance, "target"_a = py::make_tuple(h.targetKind, h.targetValue),
        "rms"_a = h.reachedRms, "max_error"_a = h.reachedMaxError,
        "value_range"_a = py::make_tuple(h.valueMin, h.valueMax), "offset"_a = h.offset);
  }

  py::list grids() const {
    using namespace py::literals;
    py::list all;
    for (const VoluteGrid& grid : reader_.grids()) {
      const VoluteHeader& h = grid.header;
      const VolumeInfo& info = grid.info;
      const GridDescription own = grid.description.value_or(GridDescription());
      all.append(py::dict(
          "name"_a = info.name, "empty"_a = grid.empty,
          "shape"_a = py::make_tuple(info.frames, info.z, info.y, info.x, info.channels),
          "half"_a = own.half, "grid_class"_a = own.gridClass, "rms"_a = h.reachedRms,
          "max_error"_a = h.reachedMaxError,
          "value_range"_a = py::make_tuple(h.valueMin, h.valueMax), "file_bytes"_a = grid.bytes));
    }
    return all;
  }

  /// What a frame holds: leaves of 8^3 voxels and tiles, places as (z, y, x).
  py::dict bricks(int frame) const {
    using namespace py::literals;
    const VolumeInfo& info = reader_.info();
    if (frame < 0 || frame >= info.frames)
      throw py::index_error(fmt::format("there is no frame {}; it has {}", frame, info.frames));
    Bricks held;
    run(py::none(),
        [&](Progress&) { return reader_.readBricks(frame, frame + 1, std::span(&held, 1)); });
    constexpr py::ssize_t kSide = Bricks::kSide;
    const auto leaves = static_cast<py::ssize_t>(held.leaves().size());
    const auto tiles = static_cast<py::ssize_t>(held.tiles().size());
    const auto channels = static_cast<py::ssize_t>(info.channels);
    py::array_t<std::int64_t> places({leaves, py::ssize_t{3}}), corners({tiles, py::ssize_t{3}}),
        sides(tiles);
    py::array_t<bool> active({leaves, kSide, kSide, kSide}), tileActive(tiles);
    py::array_t<float> values({leaves, kSide, kSide, kSide, channels}),
        tileValues({tiles, channels});
    const auto place = [](const VoxelIndex& origin, std::int64_t* to) {
      for (int axis = 0; axis < 3; ++axis) to[axis] = origin[static_cast<std::size_t>(2 - axis)];
    };
    for (std::size_t i = 0; i < held.leaves().size(); ++i) {
      const Bricks::Leaf& leaf = held.leaves()[i];
      place(leaf.origin, places.mutable_data() + 3 * i);
      float* to = values.mutable_data() + i * held.values(i).size();
      for (std::size_t at = 0; at < Bricks::kVoxels; ++at) {
        active.mutable_data()[i * Bricks::kVoxels + at] = leaf.active[at / 64] >> (at % 64) & 1;
        for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c)
          *to++ = std::as_const(held).values(i)[c * Bricks::kVoxels + at];
      }
    }
    for (std::size_t i = 0; i < held.tiles().size(); ++i) {
      const Bricks::Tile& tile = held.tiles()[i];
      place(tile.origin, corners.mutable_data() + 3 * i);
      sides.mutable_data()[i] = tile.side;
      tileActive.mutable_data()[i] = tile.active;
      std::copy_n(tile.value.begin(), channels,
                  tileValues.mutable_data() + i * static_cast<std::size_t>(channels));
    }
    py::list background;
    for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c)
      background.append(reader_.offset() + held.background()[c]);
    return py::dict("positions"_a = places, "values"_a = shown(values), "active"_a = active,
                    "tile_positions"_a = corners, "tile_sides"_a = sides,
                    "tile_values"_a = shown(tileValues), "tile_active"_a = tileActive,
                    "background"_a = background);
  }

  /// Which voxels of a frame are active, shape (z, y, x); without topology all are.
  py::array_t<bool> active(int frame) const {
    const VolumeInfo& info = reader_.info();
    py::array_t<bool> active({info.z, info.y, info.x});
    const IndexBox whole{{0, 0, 0}, {info.x, info.y, info.z}};
    const std::span<bool> to(active.mutable_data(), static_cast<std::size_t>(active.size()));
    std::ranges::fill(to, !reader_.hasTopology());
    if (!reader_.hasTopology())
      return active;
    Bricks held;
    run(py::none(),
        [&](Progress&) { return reader_.readBricks(frame, frame + 1, std::span(&held, 1)); });
    const auto mark = [&](const VoxelIndex& origin, std::int64_t side, auto&& isActive) {
      std::array<std::int64_t, 3> begin{}, end{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        begin[axis] = std::max(origin[axis], whole.begin[axis]);
        end[axis] = std::min(origin[axis] + side, whole.end[axis]);
      }
      for (std::int64_t z = begin[2]; z < end[2]; ++z) {
        for (std::int64_t y = begin[1]; y < end[1]; ++y) {
          for (std::int64_t x = begin[0]; x < end[0]; ++x) {
            if (isActive(x - origin[0], y - origin[1], z - origin[2]))
              to[static_cast<std::size_t>((z * info.y + y) * info.x + x)] = true;
          }
        }
      }
    };
    for (const Bricks::Tile& tile : held.tiles()) {
      if (tile.active)
        mark(tile.origin, tile.side, [](auto...) { return true; });
    }
    for (const Bricks::Leaf& leaf : held.leaves()) {
      mark(leaf.origin, Bricks::kSide, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
        return (leaf.active[static_cast<std::size_t>(z)] >> (8 * y + x) & 1) != 0;
      });
    }
    return active;
  }

  /// ((z, y, x), (z, y, x)) of a part of at most so many voxels that holds what the frames hold.
  py::tuple fitting(const Indices& frames, std::uint64_t maxVoxels) const {
    const std::vector<int> positions(frames.data(), frames.data() + frames.size());
    const Region region = fittingRegion(reader_, positions, maxVoxels);
    const auto place = [](const std::array<int, 3>& at) {
      return py::make_tuple(at[2], at[1], at[0]);
    };
    return py::make_tuple(place(region.begin), place(region.end));
  }

  py::array read(const Indices& t, const Indices& z, const Indices& y, const Indices& x,
                 int levels) const {
    const VolumeInfo& info = reader_.info();
    const std::array<const Indices*, 4> asked{&t, &z, &y, &x};
    const std::array<int, 4> sides{info.frames, info.z, info.y, info.x};
    std::array<std::vector<std::int64_t>, 4> indices;
    std::vector<py::ssize_t> shape;
    for (std::size_t axis = 0; axis < 4; ++axis) {
      if (asked[axis]->ndim() != 1)
        throw py::value_error("indices of an axis have one dimension");
      indices[axis].assign(asked[axis]->data(), asked[axis]->data() + asked[axis]->size());
      for (const std::int64_t index : indices[axis]) {
        if (index < 0 || index >= sides[axis]) {
          throw py::index_error(fmt::format("there is no {} on axis {}; it has {}", index,
                                            "tzyx"[axis], sides[axis]));
        }
      }
      shape.push_back(asked[axis]->size());
    }
    shape.push_back(info.channels);
    py::array_t<float> values(shape);
    if (values.size() == 0)
      return shown(values);
    float* to = values.mutable_data();
    const std::span<float> all(to, static_cast<std::size_t>(values.size()));
    run(py::none(), [&](Progress& progress) -> Status {
      if (indices[0].size() == 1 && std::ranges::all_of(indices, isRange)) {
        const auto first = [&](std::size_t axis) {
          return static_cast<int>(indices[axis].front());
        };
        const auto end = [&](std::size_t axis) {
          return static_cast<int>(indices[axis].back()) + 1;
        };
        return reader_.readRegion(first(0), {first(1), first(2), first(3)},
                                  {end(1), end(2), end(3)}, all, levels);
      }
      return Gather(reader_, indices, levels).read(to, progress);
    });
    return shown(values);
  }

  /// (the first fault, how many segments there are, and how many are intact)
  py::tuple verify(const py::object& listener) const {
    const Integrity found =
        run(listener, [&](Progress& progress) { return reader_.verify(progress); });
    return py::make_tuple(pathText(found.firstFault), found.segments, found.intactSegments);
  }

  const VoluteReader& reader() const { return reader_; }

 private:
  /// As doubles, where they are differences.
  py::array shown(const py::array_t<float>& values) const {
    if (reader_.offset() == 0)
      return values;
    py::array_t<double> sums(
        std::vector<py::ssize_t>(values.shape(), values.shape() + values.ndim()));
    std::transform(values.data(), values.data() + values.size(), sums.mutable_data(),
                   [&](float value) { return reader_.offset() + value; });
    return sums;
  }

  VoluteReader reader_;
};

std::string beyondFloat(double value) {
  return fmt::format(
      "the value {:g} is beyond float32, in which values are kept; expected at most 3.4e38: scale "
      "them",
      value);
}

/// Frames that were rounded before.
class RoundedFrames final : public RoundingSource {
 public:
  RoundedFrames(FrameSource& source, double before) : source_(source), before_(before) {}

  const VolumeInfo& info() const override { return source_.info(); }

  Status readFrame(int index, std::span<float> values) override {
    return source_.readFrame(index, values);
  }

  bool readsLayers() const override { return source_.readsLayers(); }

  Status readLayers(int index, int first, int end, std::span<float> values) override {
    return source_.readLayers(index, first, end, values);
  }

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    return source_.readBricks(index, first, end, bricks);
  }

  bool hasTopology() const override { return source_.hasTopology(); }

  double rounding() const override { return roundingOf(source_) + before_; }

  double offset() const override { return offsetOf(source_); }

 private:
  FrameSource& source_;
  double before_;
};

/// Frames that a Python function gives: frame(index) -> real numbers of shape (z, y, x[, c]).
class PythonFrames final : public RoundingSource {
 public:
  /// @param doubles  whether they are doubles
  PythonFrames(VolumeInfo info, py::function frame, bool doubles, PythonProgress& progress)
      : info_(std::move(info)), frame_(std::move(frame)), doubles_(doubles), progress_(progress) {}

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int index, std::span<float> values) override {
    const py::gil_scoped_acquire lock;
    try {
      const py::array frame = py::array::ensure(frame_(index), py::array::c_style);
      if (!frame)
        throw py::error_already_set();
      const auto type = numberTypeOf(frame.dtype().attr("str").cast<std::string>());
      if (!type || static_cast<std::size_t>(frame.size()) != values.size()) {
        return fail(ErrorCode::kInvalidArgument, "frame {} has {} values; expected {} real numbers",
                    index, frame.size(), values.size());
      }
      const auto beyond =
          toFloats(*type, static_cast<const std::byte*>(frame.data()),
                   static_cast<std::ptrdiff_t>(type->size()), values, rounding_, offset_);
      if (beyond)
        return fail(ErrorCode::kInvalidData, "{}", beyondFloat(*beyond));
      return {};
    } catch (py::error_already_set& thrown) {
      progress_.stop(std::move(thrown));
      return fail(ErrorCode::kCancelled, "stopped at frame {}", index);
    }
  }

  double rounding() const override { return rounding_; }

  double offset() const override { return offset_; }

  bool mayRound() const override { return doubles_; }

  bool takesOffset() const override { return true; }

  void takeOffset(double offset) override { offset_ = offset, rounding_ = 0; }

 private:
  VolumeInfo info_;
  py::function frame_;
  bool doubles_;
  PythonProgress& progress_;
  double rounding_ = 0, offset_ = 0;
};

CompressOptions optionsOf(const std::string& target, double value, const std::string& wavelet,
                          int effort, const std::string& access, const std::string& provenance,
                          std::uint64_t maxMemory) {
  using Kind = ErrorTarget::Kind;
  constexpr std::array<std::pair<std::string_view, Kind>, 7> kKinds{
      {{"rms", Kind::kRms},
       {"look", Kind::kLook},
       {"rms_over_all", Kind::kRmsOverAll},
       {"psnr", Kind::kPsnr},
       {"ratio", Kind::kRatio},
       {"size", Kind::kSize},
       {"max_error", Kind::kMaxError}}};
  const auto kind = std::ranges::find(kKinds, target, &std::pair<std::string_view, Kind>::first);
  if (kind == kKinds.end())
    throw py::value_error("target: " + target);
  CompressOptions options;
  options.target = {kind->second, value};
  options.wavelet = wavelet;
  options.effort = effort;
  options.access = access == "frame"  ? Access::kFrame
                   : access == "film" ? Access::kFilm
                                      : Access::kAny;
  options.provenance = provenance;
  options.maxMemory = maxMemory;
  return options;
}

py::dict dictOf(const CompressReport& report) {
  using namespace py::literals;
  return py::dict("raw_bytes"_a = report.rawBytes, "file_bytes"_a = report.fileBytes,
                  "rms"_a = report.relativeRms, "support_rms"_a = report.support.rms,
                  "support_share"_a = report.support.share, "max_error"_a = report.maxError,
                  "value_range"_a = py::make_tuple(report.valueMin, report.valueMax),
                  "seconds"_a = report.seconds);
}

/// @param frames  an array of shape (t, z, y, x, c), or a function as PythonFrames has it
/// @param said  of the volume, as infoOf() takes it, and "source_rms" and "source_max_error" of
/// what is compressed itself
/// @param rounding  of the values of `frames` before they came here
/// @param doubles  what a function gives are such
/// @param holes  values that are not finite are not there
py::dict compressFrames(const py::object& frames, const Shape& shape,
                        const std::filesystem::path& path, const std::string& target, double value,
                        const py::dict& said, double rounding, bool doubles, bool holes,
                        const std::string& wavelet, int effort, const std::string& access,
                        const std::string& provenance, std::uint64_t maxMemory,
                        const py::object& listener) {
  CompressOptions options =
      optionsOf(target, value, wavelet, effort, access, provenance, maxMemory);
  if (said.contains("source_max_error")) {
    options.sourceRms = said["source_rms"].cast<double>();
    options.sourceMaxError = said["source_max_error"].cast<double>();
  }
  VolumeInfo info = infoOf(shape, said);
  take(info.validate(path.string()));
  PythonProgress progress(listener);
  std::unique_ptr<FrameSource> source;
  if (py::isinstance<py::array>(frames))
    source = std::make_unique<ArraySource>(std::move(info), numbersOf(frames));
  else
    source = std::make_unique<PythonFrames>(std::move(info), frames, doubles, progress);
  run(progress, [&](Progress&) { return settleOffset(*source); });
  if (holes)
    source = withoutHoles(std::move(source));
  RoundedFrames rounded(*source, rounding);
  CompressReport report =
      run(progress, [&](Progress& toCaller) { return compress(rounded, path, options, toCaller); });
  report.maxError += options.sourceMaxError;
  return dictOf(report);
}

/// The same of the grid of a file, with all that this says of it.
/// @param said  what is to be said otherwise
py::dict compressFile(const File& file, const std::filesystem::path& path,
                      const std::string& target, double value, const py::dict& said,
                      const std::string& wavelet, int effort, const std::string& access,
                      const std::string& provenance, std::uint64_t maxMemory,
                      const py::object& listener) {
  const CompressOptions options =
      optionsOf(target, value, wavelet, effort, access, provenance, maxMemory);
  VolumeInfo info = file.reader().info();
  restate(info, said);
  take(info.validate(path.string()));
  const std::shared_ptr<const VoluteReader> reader(std::shared_ptr<void>(), &file.reader());
  return dictOf(run(listener, [&](Progress& progress) {
    return recompress(reader, info, path, options, progress);
  }));
}

/// An array of any real numbers as float32 in C order, and how far these are at most from them.
py::tuple toFloat32(const py::array& array) {
  const auto code = array.dtype().attr("str").cast<std::string>();
  const auto type = numberTypeOf(code);
  if (!type)
    throw py::type_error(fmt::format("values of type {}; expected real numbers", code));
  const py::array dense = py::array::ensure(array, py::array::c_style);
  py::array_t<float> values(std::vector<py::ssize_t>(dense.shape(), dense.shape() + dense.ndim()));
  const std::span<float> to(values.mutable_data(), static_cast<std::size_t>(values.size()));
  const auto* from = static_cast<const std::byte*>(dense.data());
  double rounding = 0;
  const auto beyond = unlocked([&] {
    return toFloats(*type, from, static_cast<std::ptrdiff_t>(type->size()), to, rounding);
  });
  if (beyond) {
    throw Failure{Error{ErrorCode::kInvalidData, beyondFloat(*beyond)}};
  }
  return py::make_tuple(values, rounding);
}

/// An FDS case as voxels. One thread at a time reads.
class Fds {
 public:
  Fds(const std::filesystem::path& path, const std::string& quantity, const std::string& source,
      double massExtinction, std::optional<int> mesh, const std::optional<Bounds>& bounds,
      std::uint64_t maxMemory)
      : volume_(take(unlocked([&] {
          FdsVolume::Options options;
          options.read.quantity = quantity;
          options.read.source = source;
          options.read.massExtinction = massExtinction;
          options.read.maxMemory = maxMemory;
          options.mesh = mesh;
          if (bounds)
            options.bounds = boxOf(*bounds);
          return FdsVolume::open(path, options);
        }))) {}

  py::dict info() const { return describe(volume_->info()); }

  py::array_t<float> frame(int index) {
    const VolumeInfo& info = volume_->info();
    if (index < 0 || index >= info.frames)
      throw py::index_error(fmt::format("there is no frame {}; there are {}", index, info.frames));
    py::array_t<float> values({info.z, info.y, info.x});
    const std::span<float> to(values.mutable_data(), static_cast<std::size_t>(values.size()));
    run(py::none(), [&](Progress&) {
      const std::lock_guard lock(mutex_);
      return volume_->readFrame(index, to);
    });
    return values;
  }

  py::list remarks() const {
    py::list sentences;
    for (const Remark& remark : volume_->fdsCase().remarks())
      sentences.append(pathText(remark.sentence));
    return sentences;
  }

  std::vector<std::pair<std::string, std::string>> sources() const {
    std::vector<std::pair<std::string, std::string>> result;
    for (const FdsSource& source : volume_->fdsCase().sources())
      result.emplace_back(source.name, source.description);
    return result;
  }

  std::string source() const { return volume_->fdsCase().source().name; }

 private:
  std::unique_ptr<FdsVolume> volume_;
  std::mutex mutex_;
};

}  // namespace
}  // namespace volute::python

PYBIND11_MODULE(_core, m) {
  using namespace volute::python;
  using namespace py::literals;
  translateFailures();
  CallInProgress::watchEnd();
  m.doc() = "What of Volute reads and writes volumes; use the package `volute`.";
  m.attr("version") = VOLUTE_VERSION;
  m.attr("block") = volute::BlockGrid::kSide;

  py::class_<File>(m, "File")
      .def(py::init<const std::filesystem::path&, bool, std::uint64_t, const std::string&>(),
           "path"_a, "partial"_a, "max_memory"_a, "grid"_a)
      .def_property_readonly("info", &File::info)
      .def_property_readonly("grids", &File::grids)
      .def_property_readonly("header", &File::header)
      .def_property_readonly("block_frames",
                             [](const File& file) { return file.reader().blocks().frames(); })
      .def_property_readonly("bytes_read",
                             [](const File& file) { return file.reader().bytesRead(); })
      .def_property_readonly("blocks_decoded",
                             [](const File& file) { return file.reader().blocksDecoded(); })
      .def("read", &File::read, "t"_a, "z"_a, "y"_a, "x"_a, "levels"_a = 99)
      .def("bricks", &File::bricks, "frame"_a)
      .def("active", &File::active, "frame"_a)
      .def("fitting", &File::fitting, "frames"_a, "max_voxels"_a)
      .def("verify", &File::verify, "listener"_a);

  m.def("compress", &compressFrames, "frames"_a, "shape"_a, "path"_a, "target"_a, "value"_a,
        "said"_a, "rounding"_a, "doubles"_a, "holes"_a, "wavelet"_a, "effort"_a, "access"_a,
        "provenance"_a, "max_memory"_a, "listener"_a);
  m.def("compress_file", &compressFile, "file"_a, "path"_a, "target"_a, "value"_a, "said"_a,
        "wavelet"_a, "effort"_a, "access"_a, "provenance"_a, "max_memory"_a, "listener"_a);
  m.def("to_float32", &toFloat32, "array"_a);
  m.def(
      "set_threads",
      [](int threads) {
        static std::unique_ptr<volute::ThreadLimit> limit;
        const int before = volute::threadCount();
        limit.reset();  // a lower one would hold
        limit = std::make_unique<volute::ThreadLimit>(threads);
        return before;
      },
      "threads"_a);

  py::class_<Fds>(m, "Fds")
      .def(py::init<const std::filesystem::path&, const std::string&, const std::string&, double,
                    std::optional<int>, const std::optional<Bounds>&, std::uint64_t>(),
           "path"_a, "quantity"_a, "source"_a, "mass_extinction"_a, "mesh"_a, "bounds"_a,
           "max_memory"_a)
      .def_property_readonly("info", &Fds::info)
      .def_property_readonly("remarks", &Fds::remarks)
      .def_property_readonly("sources", &Fds::sources)
      .def_property_readonly("source", &Fds::source)
      .def("frame", &Fds::frame, "index"_a);
}
