// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#define NANOVDB_USE_ZIP
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>

#include <cmath>

#include "bench/file_codec.hpp"
#include "volute/base/parallel.hpp"

namespace volute::bench {
namespace {

using Handle = nanovdb::GridHandle<>;

/// Voxels up to this share of the tolerance are not stored. Of 0, 0.4, 0.7 and 1 it makes the
/// smallest files at equal error, on smoke and on fire.
constexpr float kEmpty = 0.7f;

/// Channel `channel` of one frame.
Handle makeGrid(const VolumeInfo& info, std::span<const float> frame, int channel,
                float tolerance) {
  nanovdb::GridBuilder<float, nanovdb::FpN> builder(0.0f);
  auto accessor = builder.getAccessor();
  const float* value = frame.data() + channel;
  for (int z = 0; z < info.z; ++z) {
    for (int y = 0; y < info.y; ++y) {
      for (int x = 0; x < info.x; ++x, value += info.channels) {
        if (std::fabs(*value) > kEmpty * tolerance)
          accessor.setValue(nanovdb::Coord(x, y, z), *value);
      }
    }
  }
  builder.setStats(nanovdb::StatsMode::Disable);  // nobody reads them here, and they take bytes
  return builder.getHandle(1.0, nanovdb::Vec3d(0), "", nanovdb::AbsDiff(tolerance));
}

void fillChannel(const VolumeInfo& info, const nanovdb::NanoGrid<nanovdb::FpN>& grid,
                 float* values) {
  const auto accessor = grid.getAccessor();
  for (int z = 0; z < info.z; ++z) {
    for (int y = 0; y < info.y; ++y) {
      for (int x = 0; x < info.x; ++x, values += info.channels)
        *values = accessor.getValue(nanovdb::Coord(x, y, z));
    }
  }
}

class NanoVdbCodec final : public FileCodec {
 public:
  Setting setting() const override { return Setting::kTolerance; }

  Result<float> encode(const Sequence& sequence, double setting,
                       const std::filesystem::path& folder) const override {
    return guarded([&]() -> Result<float> {
      for (int c = 0; c < sequence.info.channels; ++c) {
        std::vector<Handle> grids(sequence.info.frames);
        parallelFor(grids.size(), [&](std::size_t t) {
          grids[t] = makeGrid(sequence.info, sequence.frame(static_cast<int>(t)), c,
                              static_cast<float>(setting));
        });
        nanovdb::io::writeGrids(file(folder, c), grids, nanovdb::io::Codec::ZIP);
      }
      return 1.0f;
    });
  }

  Status decode(const VolumeInfo& info, const std::filesystem::path& folder,
                std::span<float> values) const override {
    return guarded([&]() -> Status {
      for (int c = 0; c < info.channels; ++c) {
        const auto grids = nanovdb::io::readGrids(file(folder, c));
        for (std::size_t t = 0; t < grids.size(); ++t)
          fillChannel(info, *grids[t].grid<nanovdb::FpN>(), &values[t * info.frameValues() + c]);
      }
      return {};
    });
  }

 private:
  static std::string file(const std::filesystem::path& folder, int channel) {
    return folder / fmt::format("{}.nvdb", channel);
  }

  template <class Function>
  static auto guarded(Function&& function) -> decltype(function()) {
    try {
      return function();
    } catch (const std::exception& error) {
      return fail(ErrorCode::kIo, "NanoVDB: {}", error.what());
    }
  }
};

}  // namespace

MadeCodec makeNanoVdbCodec() {
  return std::make_unique<NanoVdbCodec>();
}

}  // namespace volute::bench
