// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/copy_frames.hpp"

#include "volute/grid/bricks.hpp"

namespace volute {

Status copyFrames(FrameSource& source, FrameSink& sink, const std::string& stage,
                  Progress& progress) {
  const VolumeInfo& info = source.info();
  const bool bricks = sink.takesBricks();
  std::vector<float> frame(bricks ? 0 : info.frameValues());
  Bricks sparse;
  for (int i = 0; i < info.frames; ++i) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: {} frame {}", stage, info.frameText(i));
    if (bricks) {
      VOLUTE_TRY(source.readBricks(i, sparse));
      VOLUTE_TRY(sink.writeBricks(sparse));
    } else {
      VOLUTE_TRY(source.readFrame(i, frame));
      VOLUTE_TRY(sink.writeFrame(frame));
    }
    progress.report(stage, i + 1, info.frames);
  }
  return sink.finish();
}

}  // namespace volute
