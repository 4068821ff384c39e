// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <memory>

#include "volute/base/output_file.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {

/// A NumPy array as a sequence: axes (z, y, x), (t, z, y, x) or (t, z, y, x, c) with c = 1 or 3, of
/// floats, integers or bool, in either order of bytes and of axes, versions 1 to 3 of the format. A
/// .npz has several, options.grid names one. The file's size must be what its header says.
[[nodiscard]] Result<std::unique_ptr<FrameSource>> openNpy(const std::filesystem::path& path,
                                                           const SourceOptions& options);

/// Numbered arrays as a sequence, a frame each: (z, y, x), or with one frame as above. All must
/// have the same size.
[[nodiscard]] Result<std::unique_ptr<FrameSource>> openNpySequence(
    const std::vector<NumberedFile>& files, const SourceOptions& options);

/// Writes float32 (t, z, y, x), or (t, z, y, x, c) when there are 3 channels, as numpy.save would.
/// "-" is standard output.
class NpySink final : public FrameSink {
 public:
  [[nodiscard]] static Result<std::unique_ptr<NpySink>> create(const std::filesystem::path& path,
                                                               const VolumeInfo& info,
                                                               double offset = 0);

  [[nodiscard]] Status writeFrame(std::span<const float> values) override;
  [[nodiscard]] Status finish() override;

 private:
  NpySink(OutputFile file, const VolumeInfo& info, double offset)
      : file_(std::move(file)),
        frames_(info.frames),
        frameValues_(info.frameValues()),
        offset_(offset) {}

  OutputFile file_;
  int frames_;
  int written_ = 0;
  std::size_t frameValues_;
  double offset_;
};

}  // namespace volute
