// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/sequence.hpp"

#include <algorithm>

namespace volute {

View<const float, 5> Sequence::view() const {
  return {std::span(values), {info.frames, info.z, info.y, info.x, info.channels}};
}

View<float, 5> Sequence::view() {
  return {std::span(values), {info.frames, info.z, info.y, info.x, info.channels}};
}

std::span<const float> Sequence::frame(int index) const {
  return std::span(values).subspan(index * info.frameValues(), info.frameValues());
}

std::span<float> Sequence::frame(int index) {
  return std::span(values).subspan(index * info.frameValues(), info.frameValues());
}

Sequence makeSequence(int frames, int z, int y, int x, int channels) {
  Sequence sequence;
  sequence.info.frames = frames;
  sequence.info.z = z;
  sequence.info.y = y;
  sequence.info.x = x;
  sequence.info.channels = channels;
  sequence.info.fillDefaults();
  sequence.values.resize(sequence.info.values());
  return sequence;
}

Result<Sequence> readAll(FrameSource& source, std::uint64_t maxBytes) {
  const VolumeInfo& info = source.info();
  if (info.rawBytes() > maxBytes) {
    return fail(
        ErrorCode::kTooLarge,
        "{} frames of {} x {} x {} voxels need {} MiB of memory, more than the {} MiB allowed",
        info.frames, info.x, info.y, info.z, info.rawBytes() >> 20, maxBytes >> 20);
  }
  Sequence sequence{info, std::vector<float>(info.values())};
  for (int frame = 0; frame < info.frames; ++frame)
    VOLUTE_TRY(source.readFrame(frame, sequence.frame(frame)));
  return sequence;
}

Status SequenceSource::readFrame(int index, std::span<float> values) {
  std::ranges::copy(sequence_.frame(index), values.begin());
  return {};
}

}  // namespace volute
