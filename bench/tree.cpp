// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench tree`: the compact tree in memory against a dense array, the paper's layout,
// libzfp's const_array4 and NanoVDB, all at the same error, one thread, in one run.
#include <nanovdb/util/GridBuilder.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <zfp/constarray4.hpp>

#include "bench/baselines/paper_tree.hpp"
#include "bench/benchmark.hpp"
#include "bench/timing.hpp"
#include "volute/base/parallel.hpp"
#include "volute/tree4d/tree4d.hpp"

namespace volute::bench {
namespace {

constexpr double kRelativeRms = 3e-3;
constexpr std::size_t kRandomReads = 1 << 20;

using Voxel = std::array<int, 4>;  // t, z, y, x

/// Keeps the optimiser from dropping reads whose values nobody wants.
volatile float sink;

/// The largest `parameter` whose error(parameter) is at most kRelativeRms, to 2 %; error grows with
/// it.
template <class Error>
double parameterForTarget(double low, double high, Error&& error) {
  for (int i = 0; i < 30 && high / low > 1.02; ++i) {
    const double middle = std::sqrt(low * high);
    (error(middle) <= kRelativeRms ? low : high) = middle;
  }
  return low;
}

template <class Read>
double relativeRms(const Sequence& sequence, Read&& read) {
  const VolumeInfo& info = sequence.info;
  double sum = 0;
  std::size_t i = 0;
  for (int t = 0; t < info.frames; ++t)
    for (int z = 0; z < info.z; ++z)
      for (int y = 0; y < info.y; ++y)
        for (int x = 0; x < info.x; ++x, ++i) {
          const double e = static_cast<double>(read(Voxel{t, z, y, x})) - sequence.values[i];
          sum += e * e;
        }
  return std::sqrt(sum / static_cast<double>(sequence.values.size())) / valueRange(sequence);
}

struct ZfpArray {
  zfp::const_array4f array;

  static ZfpArray make(const Sequence& sequence, double tolerance) {
    const VolumeInfo& i = sequence.info;
    return {zfp::const_array4f(i.x, i.y, i.z, i.frames, zfp_config_accuracy(tolerance),
                               sequence.values.data())};
  }

  float operator()(const Voxel& v) const { return array(v[3], v[2], v[1], v[0]); }
};

struct NanoFrames {
  std::vector<nanovdb::GridHandle<>> handles;
  std::vector<const nanovdb::NanoGrid<nanovdb::FpN>*> grids;

  static NanoFrames make(const Sequence& sequence, double tolerance) {
    const VolumeInfo& info = sequence.info;
    NanoFrames frames;
    for (int t = 0; t < info.frames; ++t) {
      nanovdb::GridBuilder<float, nanovdb::FpN> builder(0.0f);
      auto accessor = builder.getAccessor();
      std::size_t i = t * info.frameValues();
      for (int z = 0; z < info.z; ++z)
        for (int y = 0; y < info.y; ++y)
          for (int x = 0; x < info.x; ++x, ++i)
            if (sequence.values[i] != 0)
              accessor.setValue(nanovdb::Coord(x, y, z), sequence.values[i]);
      frames.handles.push_back(builder.getHandle(1.0, nanovdb::Vec3d(0), "",
                                                 nanovdb::AbsDiff(static_cast<float>(tolerance))));
      frames.grids.push_back(frames.handles.back().grid<nanovdb::FpN>());
    }
    return frames;
  }

  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const auto& handle : handles) sum += handle.size();
    return sum;
  }

  float operator()(const Voxel& v) const {
    return grids[v[0]]->tree().getValue(nanovdb::Coord(v[3], v[2], v[1]));
  }
};

template <class Read>
double randomReads(std::span<const Voxel> voxels, Read&& read) {
  const double seconds = medianSeconds([&] {
    float sum = 0;
    for (const Voxel& v : voxels) sum += read(v);
    sink = sum;
  });
  return static_cast<double>(voxels.size()) / seconds / 1e6;
}

/// All voxels of one frame, along z: rays that cross the rows of memory.
template <class Read>
double rayReads(const VolumeInfo& info, int frame, Read&& read) {
  const double seconds = medianSeconds([&] {
    float sum = 0;
    for (int y = 0; y < info.y; ++y)
      for (int x = 0; x < info.x; ++x)
        for (int z = 0; z < info.z; ++z) sum += read(Voxel{frame, z, y, x});
    sink = sum;
  });
  return static_cast<double>(info.voxels()) / seconds / 1e6;
}

/// Whole frames one after the other.
template <class Extract>
double frameReads(const VolumeInfo& info, Extract&& extract) {
  const double seconds = medianSeconds([&] {
    for (int t = 0; t < info.frames; ++t) extract(t);
  });
  return static_cast<double>(info.voxels()) * info.frames / seconds / 1e6;
}

struct Names {
  std::string prefix;

  std::string operator()(std::string_view what, std::string_view whose) const {
    return fmt::format("{}: {}, {}", prefix, what, whose);
  }
};

Status measure(const std::string& prefix, const Sequence& sequence, BenchRows& rows,
               Progress& progress) {
  const VolumeInfo& info = sequence.info;
  const Names name{prefix};
  const auto raw = static_cast<double>(info.rawBytes());
  SequenceSource source(sequence);
  VOLUTE_ASSIGN(const Tree4d tree, Tree4d::build(source, {.relativeRms = kRelativeRms}, progress));
  const PaperTransform transform(sequence);
  const PaperTree paper = transform.build(transform.thresholdForRms(kRelativeRms));

  const double tolerance = valueRange(sequence);
  const double zfpTolerance = parameterForTarget(1e-5 * tolerance, tolerance, [&](double t) {
    return relativeRms(sequence, ZfpArray::make(sequence, t));
  });
  const ZfpArray zfp = ZfpArray::make(sequence, zfpTolerance);
  const double nanoTolerance = parameterForTarget(1e-4 * tolerance, 0.1 * tolerance, [&](double t) {
    return relativeRms(sequence, NanoFrames::make(sequence, t));
  });
  const NanoFrames nano = NanoFrames::make(sequence, nanoTolerance);

  auto add = [&](std::string row, double value, std::string unit, std::optional<double> ratio) {
    rows.add({std::move(row), value, std::move(unit), ratio});
  };
  const double treeSize = static_cast<double>(tree.memoryBytes()) / raw;
  auto size = [&](std::string_view whose, double bytes) {
    add(name("size in memory", whose), bytes / raw, "of raw", bytes / raw / treeSize);
  };
  size("compact tree", static_cast<double>(tree.memoryBytes()));
  size("paper's layout", static_cast<double>(paper.bytes().size()));
  size("zfp const_array4", static_cast<double>(zfp.array.size_bytes()));
  size("NanoVDB FpN", static_cast<double>(nano.bytes()));
  auto rms = [&](std::string_view whose, double value) {
    add(name("relative RMS", whose), value, "", std::nullopt);
  };
  rms("compact tree",
      relativeRms(sequence, [&](const Voxel& v) { return tree.value(v[0], v[1], v[2], v[3]); }));
  rms("paper's layout", transform.relativeRmsAt(transform.thresholdForRms(kRelativeRms)));
  rms("zfp const_array4", relativeRms(sequence, zfp));
  rms("NanoVDB FpN", relativeRms(sequence, nano));

  const ThreadLimit one(1);
  std::mt19937 random(1);
  std::vector<Voxel> voxels(kRandomReads);
  const Voxel sides{info.frames, info.z, info.y, info.x};
  for (Voxel& v : voxels)
    for (int a = 0; a < 4; ++a) v[a] = static_cast<int>(random() % static_cast<unsigned>(sides[a]));
  auto dense = [&](const Voxel& v) {
    return sequence
        .values[((static_cast<std::size_t>(v[0]) * info.z + v[1]) * info.y + v[2]) * info.x + v[3]];
  };
  std::vector<float> values(voxels.size());
  const double zfpRandom = randomReads(std::span(voxels).first(kRandomReads / 16), zfp);
  auto rate = [&](std::string_view what, std::string_view whose, double megaReads,
                  double baseline) {
    add(name(what, whose), megaReads, "M/s", megaReads / baseline);
  };
  rate("random reads", "zfp const_array4", zfpRandom, zfpRandom);
  const double treeRandom = static_cast<double>(voxels.size()) /
                            medianSeconds([&] { tree.values(voxels, values); }) / 1e6;
  rate("random reads", "compact tree", treeRandom, zfpRandom);
  rate("random reads", "paper's layout",
       randomReads(voxels, [&](const Voxel& v) { return paper.value(v[0], v[1], v[2], v[3]); }),
       zfpRandom);
  rate("random reads", "NanoVDB FpN", randomReads(voxels, nano), zfpRandom);
  rate("random reads", "dense array", randomReads(voxels, dense), zfpRandom);

  const int middle = info.frames / 2;
  const double zfpRays = rayReads(info, middle, zfp);
  rate("reads along rays", "zfp const_array4", zfpRays, zfpRays);
  std::vector<float> line(info.z);
  const double raySeconds = medianSeconds([&] {
    for (int y = 0; y < info.y; ++y)
      for (int x = 0; x < info.x; ++x) tree.valuesAlong({middle, 0, y, x}, {0, 1, 0, 0}, line);
  });
  rate("reads along rays", "compact tree", static_cast<double>(info.voxels()) / raySeconds / 1e6,
       zfpRays);
  const auto accessor = nano.grids[middle]->getAccessor();
  rate(
      "reads along rays", "NanoVDB FpN",
      rayReads(info, middle,
               [&](const Voxel& v) { return accessor.getValue(nanovdb::Coord(v[3], v[2], v[1])); }),
      zfpRays);
  rate("reads along rays", "dense array", rayReads(info, middle, dense), zfpRays);

  std::vector<float> frame(info.frameValues());
  const double copying =
      frameReads(info, [&](int t) { std::ranges::copy(sequence.frame(t), frame.begin()); });
  rate("whole frames", "copying a dense frame", copying, copying);
  rate("whole frames", "compact tree",
       frameReads(info, [&](int t) { tree.extractFrame(t, frame); }), copying);
  rate("whole frames", "compact tree, into bricks",
       frameReads(info, [&](int t) { tree.extractSlice(t); }), copying);
  rate("whole frames", "zfp const_array4",
       frameReads(info,
                  [&](int t) {
                    std::size_t i = 0;
                    for (int z = 0; z < info.z; ++z)
                      for (int y = 0; y < info.y; ++y)
                        for (int x = 0; x < info.x; ++x) frame[i++] = zfp(Voxel{t, z, y, x});
                  }),
       copying);
  return {};
}

/// The brightest channel of RGB: the peers hold scalars.
Sequence scalar(Sequence sequence) {
  if (sequence.info.channels == 1)
    return sequence;
  Sequence out{sequence.info, {}};
  out.info.channels = 1;
  out.values.resize(out.info.values());
  for (std::size_t i = 0; i < out.values.size(); ++i)
    out.values[i] =
        std::max({sequence.values[3 * i], sequence.values[3 * i + 1], sequence.values[3 * i + 2]});
  return out;
}

}  // namespace

Status benchTree(const BenchInput& input, BenchRows& rows, Progress& progress) {
  VOLUTE_ASSIGN(auto sequences, benchSequences(input, progress));
  for (auto& [name, sequence] : sequences)
    VOLUTE_TRY(measure(name, scalar(std::move(sequence)), rows, progress));
  return {};
}

}  // namespace volute::bench
