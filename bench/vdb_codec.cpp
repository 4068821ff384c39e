// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cmath>

#include "bench/file_codec.hpp"
#include "volute/io/plugin.hpp"

namespace volute::bench {
namespace {

/// Through the plug-in that reads and writes .vdb files, in this process: the files are our own.
class VdbCodec final : public FileCodec {
 public:
  explicit VdbCodec(const LatticePlugin& plugin) : plugin_(plugin) {}

  Setting setting() const override { return Setting::kTolerance; }

  /// Values up to the tolerance become background, which is how OpenVDB saves space.
  Result<float> encode(const Sequence& sequence, double setting,
                       const std::filesystem::path& folder) const override {
    const auto writer = plugin_.makeWriter({.half = true, .zip = true});
    VolumeInfo info = sequence.info;
    info.channels = 1;
    std::vector<float> values(info.frameValues());
    for (int c = 0; c < sequence.info.channels; ++c) {
      for (int t = 0; t < info.frames; ++t) {
        const float* from = sequence.frame(t).data() + c;
        for (float& value : values) {
          value = std::fabs(*from) <= setting ? 0.0f : *from;
          from += sequence.info.channels;
        }
        const auto path = file(folder, c, t);
        VOLUTE_TRY(writer->write(path, path, info, t, values));
      }
    }
    return 1.0f;
  }

  Status decode(const VolumeInfo& info, const std::filesystem::path& folder,
                std::span<float> values) const override {
    const auto reader = plugin_.makeReader();
    const IndexBox box{{0, 0, 0}, {info.x, info.y, info.z}};
    std::vector<float> plane(info.channels == 1 ? 0 : info.voxels());
    double rounding = 0;
    for (int c = 0; c < info.channels; ++c) {
      for (int t = 0; t < info.frames; ++t) {
        const auto frame = values.subspan(t * info.frameValues(), info.frameValues());
        const auto path = file(folder, c, t);
        if (info.channels == 1) {
          VOLUTE_TRY(reader->read(path, info.name, box, box, /*crop=*/false, frame, rounding));
          continue;
        }
        VOLUTE_TRY(reader->read(path, info.name, box, box, /*crop=*/false, plane, rounding));
        for (std::size_t i = 0; i < plane.size(); ++i) frame[i * info.channels + c] = plane[i];
      }
    }
    return {};
  }

 private:
  static std::filesystem::path file(const std::filesystem::path& folder, int channel, int frame) {
    return folder / fmt::format("{}_{:04}.vdb", channel, frame);
  }

  const LatticePlugin& plugin_;
};

}  // namespace

MadeCodec makeVdbCodec() {
  VOLUTE_ASSIGN(const LatticePlugin* plugin, loadVdbPlugin());
  return std::make_unique<VdbCodec>(*plugin);
}

}  // namespace volute::bench
