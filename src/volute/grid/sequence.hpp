// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/base/view.hpp"
#include "volute/grid/frame_source.hpp"

namespace volute {

/// A whole sequence in memory, shape (t, z, y, x, c), C order. For tests, examples and small data.
struct Sequence {
  VolumeInfo info;
  std::vector<float> values;

  View<const float, 5> view() const;
  View<float, 5> view();
  std::span<const float> frame(int index) const;
  std::span<float> frame(int index);
};

/// A zero sequence with default bounds and times.
Sequence makeSequence(int frames, int z, int y, int x, int channels = 1);

/// Reads all frames; kTooLarge when the values need more than `maxBytes`.
[[nodiscard]] Result<Sequence> readAll(FrameSource& source, std::uint64_t maxBytes);

/// A sequence as a source; `sequence` must outlive it.
class SequenceSource final : public FrameSource {
 public:
  explicit SequenceSource(const Sequence& sequence) : sequence_(sequence) {}

  const VolumeInfo& info() const override { return sequence_.info; }

  [[nodiscard]] Status readFrame(int index, std::span<float> values) override;

 private:
  const Sequence& sequence_;
};

}  // namespace volute
