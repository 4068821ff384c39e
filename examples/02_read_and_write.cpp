// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// Writes a .volute from frames generated one at a time, and reads a region of one frame back.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "volute/codec/compress.hpp"
#include "volute/codec/volute_reader.hpp"

namespace {

/// A rising round cloud: 20 frames of 32 x 32 x 48 voxels.
class Cloud final : public volute::FrameSource {
 public:
  Cloud() {
    info_.name = "density";
    info_.unit = "1/m";
    info_.frames = 20;
    info_.x = info_.y = 32, info_.z = 48;
    info_.bounds = {volute::Vec3(-1, -1, 0), volute::Vec3(1, 1, 3)};  // [m]
    info_.fillDefaults();  // frame numbers, and times at 25 frames a second
  }

  const volute::VolumeInfo& info() const override { return info_; }

  float value(int frame, int z, int y, int x) const {
    const volute::Vec3 voxel = info_.voxelSize();
    const volute::Vec3 point =
        info_.bounds.min + voxel.cwiseProduct(volute::Vec3(x + 0.5, y + 0.5, z + 0.5));
    const volute::Vec3 centre(0, 0, 0.8 + 0.07 * frame);
    return static_cast<float>(std::max(0.0, 1 - (point - centre).squaredNorm() / 0.5));
  }

  volute::Status readFrame(int frame, std::span<float> values) override {
    std::size_t i = 0;
    for (int z = 0; z < info_.z; ++z)
      for (int y = 0; y < info_.y; ++y)
        for (int x = 0; x < info_.x; ++x) values[i++] = value(frame, z, y, x);
    return {};
  }

 private:
  volute::VolumeInfo info_;
};

volute::Status writeAndRead() {
  Cloud cloud;
  volute::Progress quiet;
  volute::CompressOptions options;
  options.target = {volute::ErrorTarget::Kind::kMaxError, 0.01};  // at every voxel
  VOLUTE_ASSIGN(const auto report, volute::compress(cloud, "cloud.volute", options, quiet));
  fmt::print("{} bytes became {}; no voxel is off by more than {:.4f}\n", report.rawBytes,
             report.fileBytes, report.maxError);

  VOLUTE_ASSIGN(const auto reader, volute::VoluteReader::open("cloud.volute"));
  const int frame = reader.info().frameAt(0.4);               // [s]
  const std::array<int, 3> begin{16, 8, 8}, end{32, 24, 24};  // z, y, x
  std::vector<float> part(16 * 16 * 16);
  VOLUTE_TRY(reader.readRegion(frame, begin, end, part));

  double worst = 0;
  for (int z = 0; z < 16; ++z)
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x)
        worst = std::max(worst, std::abs(part[(z * 16 + y) * 16 + x] -
                                         double{cloud.value(frame, 16 + z, 8 + y, 8 + x)}));
  fmt::print("a part of frame {} is off by {:.4f} at most; {} of {} blocks were decoded\n", frame,
             worst, reader.blocksDecoded(), reader.blocks().count());
  if (worst > 0.01)
    return volute::fail(volute::ErrorCode::kInvalidData, "the file is off by {}", worst);
  return {};
}

}  // namespace

int main() {
  if (const auto done = writeAndRead(); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
}
