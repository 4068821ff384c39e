// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench sparse`: a cache that is nearly empty, from .vdb files of halves to the files of
// Volute, OpenVDB and NanoVDB, and from these to bricks. Each step runs in a process of its own;
// the confined processes that read .vdb files for it are left out, for all alike.
#define NANOVDB_USE_ZIP
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>
#include <nanovdb/util/NodeManager.h>

#include <cmath>
#include <functional>
#include <limits>

#include "bench/benchmark.hpp"
#include "bench/own_process.hpp"
#include "bench/scratch.hpp"
#include "bench/tolerance_search.hpp"
#include "volute/codec/compress.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/volume_source.hpp"
#include "volute/synth/puffs.hpp"

namespace volute::bench {
namespace {

namespace fs = std::filesystem;

using Visit = std::function<Status(int frame, const Bricks& bricks)>;

constexpr int kPuffSize = 256, kQuickPuffs = 128, kPuffFrames = 4;

Result<std::unique_ptr<FrameSource>> openCache(const std::string& cache) {
  SourceOptions options;
  return openSource(cache, options);
}

/// A codec of sparse frames.
class SparseCodec {
 public:
  explicit SparseCodec(std::string name) : name_(std::move(name)) {}

  virtual ~SparseCodec() = default;

  const std::string& name() const { return name_; }

  /// Whether encode() wants an absolute tolerance, which somebody has to search.
  virtual bool wantsTolerance() const { return false; }

  /// Whether a confined process reads its files.
  virtual bool readsElsewhere() const { return false; }

  /// Where its files have a leaf that begins here.
  virtual VoxelIndex placeOf(const VoxelIndex& leaf) const { return leaf; }

  [[nodiscard]] virtual Status encode(FrameSource& source, double setting,
                                      const fs::path& folder) const = 0;
  [[nodiscard]] virtual Status decode(FrameSource& source, const fs::path& folder,
                                      const Visit& visit) const = 0;

 private:
  std::string name_;
};

/// Settings are relative errors over the support; 0 is the default.
class VoluteFile final : public SparseCodec {
 public:
  using SparseCodec::SparseCodec;

  Status encode(FrameSource& source, double setting, const fs::path& folder) const override {
    CompressOptions options;
    options.halves = true;
    if (setting > 0)
      options.target = {ErrorTarget::Kind::kRms, setting};
    Progress quiet;
    VOLUTE_TRY(compress(source, folder / "x.volute", options, quiet));
    return {};
  }

  Status decode(FrameSource&, const fs::path& folder, const Visit& visit) const override {
    VOLUTE_ASSIGN(auto reader, VoluteReader::open(folder / "x.volute"));
    const auto source = frameSource(std::make_shared<const VoluteReader>(std::move(reader)));
    for (int t = 0; t < source->info().frames; ++t) {
      Bricks bricks;
      VOLUTE_TRY(source->readBricks(t, bricks));
      VOLUTE_TRY(visit(t, bricks));
    }
    return {};
  }
};

class VdbFiles final : public SparseCodec {
 public:
  VdbFiles(std::string name, bool zip) : SparseCodec(std::move(name)), zip_(zip) {}

  bool readsElsewhere() const override { return true; }

  Status encode(FrameSource& source, double, const fs::path& folder) const override {
    VOLUTE_ASSIGN(const LatticePlugin* plugin, loadVdbPlugin());
    const auto writer = plugin->makeWriter({.half = true, .zip = zip_});
    for (int t = 0; t < source.info().frames; ++t) {
      Bricks bricks;
      VOLUTE_TRY(source.readBricks(t, bricks));
      const fs::path path = folder / fmt::format("x_{:04}.vdb", t);
      VOLUTE_TRY(writer->writeBricks(path, path, source.info(), t, bricks));
    }
    return {};
  }

  Status decode(FrameSource&, const fs::path& folder, const Visit& visit) const override {
    VOLUTE_ASSIGN(const auto source, openCache((folder / "x_####.vdb").string()));
    for (int t = 0; t < source->info().frames; ++t) {
      Bricks bricks;
      VOLUTE_TRY(source->readBricks(t, bricks));
      VOLUTE_TRY(visit(t, bricks));
    }
    return {};
  }

 private:
  bool zip_;
};

class NanoVdbFiles final : public SparseCodec {
 public:
  using SparseCodec::SparseCodec;

  bool wantsTolerance() const override { return true; }

  /// Leaves of NanoVDB begin at multiples of 8; those of a frame are off by the same.
  VoxelIndex placeOf(const VoxelIndex& leaf) const override {
    return {leaf[0] & ~7, leaf[1] & ~7, leaf[2] & ~7};
  }

  Status encode(FrameSource& source, double setting, const fs::path& folder) const override {
    return guarded([&]() -> Status {
      for (int t = 0; t < source.info().frames; ++t) {
        Bricks bricks;
        VOLUTE_TRY(source.readBricks(t, bricks));
        nanovdb::GridBuilder<float, nanovdb::FpN> builder(bricks.background()[0]);
        auto accessor = builder.getAccessor();
        for (std::size_t i = 0; i < bricks.leaves().size(); ++i) {
          const Bricks::Leaf& leaf = bricks.leaves()[i];
          const VoxelIndex place = placeOf(leaf.origin);
          const nanovdb::Coord at(static_cast<int>(place[0]), static_cast<int>(place[1]),
                                  static_cast<int>(place[2]));
          for (int n = 0; n < Bricks::kVoxels; ++n) {
            if ((leaf.valued[static_cast<std::size_t>(n / 64)] >> n % 64 & 1) != 0)
              accessor.setValue(at.offsetBy(n % 8, n / 8 % 8, n / 64),
                                bricks.values(i)[static_cast<std::size_t>(n)]);
          }
        }
        builder.setStats(nanovdb::StatsMode::Disable);
        const auto handle = builder.getHandle(1.0, nanovdb::Vec3d(0), "",
                                              nanovdb::AbsDiff(static_cast<float>(setting)));
        nanovdb::io::writeGrid(file(folder, t), handle, nanovdb::io::Codec::ZIP);
      }
      return {};
    });
  }

  Status decode(FrameSource& source, const fs::path& folder, const Visit& visit) const override {
    return guarded([&]() -> Status {
      for (int t = 0; t < source.info().frames; ++t) {
        const auto handle = nanovdb::io::readGrid(file(folder, t));
        const auto* grid = handle.grid<nanovdb::FpN>();
        if (!grid)
          return fail(ErrorCode::kInvalidData, "NanoVDB: no grid was read back");
        const auto nodes = nanovdb::createNodeManager(*grid);
        const auto* manager = nodes.mgr<nanovdb::FpN>();
        Bricks bricks(1, {grid->tree().background(), 0, 0});
        for (std::uint32_t i = 0; i < manager->nodeCount(0); ++i) {
          const auto& from = manager->leaf(i);
          const auto at = from.origin();
          Bricks::Leaf leaf{{at[0], at[1], at[2]}};
          for (std::uint32_t n = 0; n < Bricks::kVoxels; ++n) {  // z fastest
            const std::uint64_t active = from.isActive(n) ? 1 : 0;
            leaf.valued[n & 7] |= active << ((n >> 3 & 7) * 8 + (n >> 6));
          }
          leaf.active = leaf.valued;
          const auto to = bricks.addLeaf(leaf);
          for (std::uint32_t n = 0; n < Bricks::kVoxels; ++n)
            to[64 * (n & 7) + (n >> 3 & 7) * 8 + (n >> 6)] = from.getValue(n);
        }
        bricks.sort();
        VOLUTE_TRY(visit(t, bricks));
      }
      return {};
    });
  }

 private:
  static std::string file(const fs::path& folder, int frame) {
    return folder / fmt::format("x_{:04}.nvdb", frame);
  }

  template <class Function>
  static Status guarded(Function&& function) {
    try {
      return function();
    } catch (const std::exception& error) {
      return fail(ErrorCode::kIo, "NanoVDB: {}", error.what());
    }
  }
};

/// Values of a frame at any voxel.
class VoxelLookup {
 public:
  explicit VoxelLookup(const Bricks& frame) : frame_(frame) {
    if (!frame.leaves().empty())
      for (std::size_t axis = 0; axis < 3; ++axis)
        begin_[axis] = frame.leaves()[0].origin[axis] & 7;
  }

  float at(const VoxelIndex& voxel) {
    VoxelIndex origin;
    for (std::size_t axis = 0; axis < 3; ++axis)
      origin[axis] = ((voxel[axis] - begin_[axis]) & ~std::int64_t{7}) + begin_[axis];
    if (!known_ || origin != origin_) {
      known_ = true;
      origin_ = origin;
      leaf_ = frame_.find(origin);
    }
    if (leaf_ == frame_.leaves().size())
      return frame_.background()[0];
    return frame_.values(leaf_)[static_cast<std::size_t>(
        ((voxel[2] - origin[2]) * 8 + voxel[1] - origin[1]) * 8 + voxel[0] - origin[0])];
  }

 private:
  const Bricks& frame_;
  VoxelIndex begin_{}, origin_{};  // of all leaves, and of the last one
  std::size_t leaf_ = 0;
  bool known_ = false;
};

/// RMS over what is in use in the original, as a part of its range there.
Result<double> supportRms(const std::string& cache, const SparseCodec& codec,
                          const fs::path& folder) {
  VOLUTE_ASSIGN(const auto original, openCache(cache));
  double squares = 0, count = 0;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  VOLUTE_TRY(codec.decode(*original, folder, [&](int frame, const Bricks& decoded) -> Status {
    Bricks truth;
    VOLUTE_TRY(original->readBricks(frame, truth));
    VoxelLookup lookup(decoded);
    for (std::size_t i = 0; i < truth.leaves().size(); ++i) {
      const Bricks::Leaf& leaf = truth.leaves()[i];
      const VoxelIndex first = codec.placeOf(leaf.origin);
      for (std::size_t n = 0; n < Bricks::kVoxels; ++n) {
        if ((leaf.valued[n / 64] >> n % 64 & 1) == 0)
          continue;
        const auto at = static_cast<std::int64_t>(n);
        const double value = truth.values(i)[n];
        const double error =
            value - lookup.at({first[0] + at % 8, first[1] + at / 8 % 8, first[2] + at / 64});
        squares += error * error;
        low = std::min(low, value), high = std::max(high, value), ++count;
      }
    }
    return {};
  }));
  if (!(high > low))
    return fail(ErrorCode::kInvalidData, "{}: nothing varies in it; expected a volume", cache);
  return std::sqrt(squares / count) / (high - low);
}

std::uint64_t sparseBytesIn(const fs::path& folder) {
  std::uint64_t sum = 0;
  for (const auto& entry : fs::directory_iterator(folder)) sum += entry.file_size();
  return sum;
}

/// One codec's files at one setting, and what making and reading them takes.
struct SparseFiles {
  Outcome encoding;
  double rms = 0;
};

Result<SparseFiles> encodeAt(const std::string& cache, const SparseCodec& codec, double setting,
                             const fs::path& folder) {
  std::error_code error;
  fs::remove_all(folder, error);
  fs::create_directories(folder, error);
  SparseFiles files;
  VOLUTE_ASSIGN(files.encoding, measured([&]() -> Result<double> {
                  VOLUTE_ASSIGN(const auto source, openCache(cache));
                  VOLUTE_TRY(codec.encode(*source, setting, folder));
                  return 0;
                }));
  VOLUTE_ASSIGN(const Outcome found, measured([&] { return supportRms(cache, codec, folder); }));
  files.rms = found.value;
  return files;
}

/// The rows of one codec at one error.
/// @param baseline  bytes of the cache
Status addRows(const std::string& cache, const SparseCodec& codec, double target,
               const fs::path& folder, double baseline, BenchRows& rows) {
  SparseFiles files;
  if (codec.wantsTolerance()) {
    VOLUTE_TRY(searchTolerance(target, 0.01, [&](double tolerance) -> Result<double> {
      VOLUTE_ASSIGN(files, encodeAt(cache, codec, tolerance, folder));
      return files.rms;
    }));
  } else {
    VOLUTE_ASSIGN(files, encodeAt(cache, codec, target, folder));
  }
  const auto bytes = static_cast<double>(sparseBytesIn(folder));
  const std::string at = target > 0 ? fmt::format(" at {}", target) : "";
  const auto add = [&](std::string_view figure, double value, std::string unit,
                       std::optional<double> ratio = std::nullopt) {
    BenchRow row{fmt::format("{}{}: {}", codec.name(), at, figure), value, std::move(unit), ratio};
    row.labels = {{"figure", std::string(figure)},
                  {"codec", codec.name()},
                  {"target", target > 0 ? fmt::format("{}", target) : "its own"}};
    rows.add(std::move(row));
  };
  add("size", bytes / 1e6, "MB", bytes / baseline);
  add("error over what is in use", files.rms, "");
  add("compressing, CPU time", files.encoding.seconds, "s");
  add("compressing, memory", files.encoding.megabytes, "MB");
  if (codec.readsElsewhere())
    return {};
  VOLUTE_ASSIGN(
      const Outcome decoding, measured([&]() -> Result<double> {
        VOLUTE_ASSIGN(const auto source, openCache(cache));
        VOLUTE_TRY(codec.decode(*source, folder, [](int, const Bricks&) -> Status { return {}; }));
        return 0;
      }));
  add("reading all frames, CPU time", decoding.seconds, "s");
  add("reading, memory", decoding.megabytes, "MB");
  return {};
}

/// Frames of puffs as .vdb files of halves; their pattern.
Result<std::string> makeCache(const fs::path& folder, bool quick) {
  std::error_code error;
  fs::create_directories(folder, error);
  VOLUTE_TRY(measured([&]() -> Result<double> {
    PuffSource puffs({.size = quick ? kQuickPuffs : kPuffSize, .frames = kPuffFrames, .seed = 1});
    VOLUTE_TRY(VdbFiles("", false).encode(puffs, 0, folder));
    return 0;
  }));
  return (folder / "x_####.vdb").string();
}

}  // namespace

Status benchSparse(const BenchInput& input, BenchRows& rows, Progress& progress) {
  VOLUTE_ASSIGN(const auto scratch, ScratchFolder::create());
  std::string cache = input.volume;
  if (cache.empty()) {
    VOLUTE_ASSIGN(cache, makeCache(scratch.path() / "cache", input.quick));
  }
  const fs::path folder = scratch.path() / "files";
  const VdbFiles blosc("OpenVDB half, Blosc", false), zip("OpenVDB half, zip", true);
  const VoluteFile volute("Volute");
  const NanoVdbFiles nano("NanoVDB FpN, zip");
  // What the others are compared with: the same values, written as the cache was.
  VOLUTE_TRY(encodeAt(cache, blosc, 0, folder));
  const auto baseline = static_cast<double>(sparseBytesIn(folder));

  struct Turn {
    const SparseCodec& codec;
    double target;
  };

  double done = 0;
  const std::vector<Turn> turns{{blosc, 0},     {zip, 0},     {volute, 0}, {volute, 1e-3},
                                {volute, 3e-3}, {nano, 1e-3}, {nano, 3e-3}};
  for (const auto& [codec, target] : turns) {
    progress.report(fmt::format("{} at {}", codec.name(), target), done++,
                    static_cast<double>(turns.size()));
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before {}", codec.name());
    VOLUTE_TRY(addRows(cache, codec, target, folder, baseline, rows));
  }
  return {};
}

}  // namespace volute::bench
