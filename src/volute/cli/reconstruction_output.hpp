// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "volute/cli/context.hpp"
#include "volute/grid/frame_source.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/report/report.hpp"

namespace volute::cli {

/// Where a reconstruction goes, and what of it.
struct ReconstructionOutput {
  std::string target;  ///< .volute, or what openSink() takes
  double rms = 1e-3;   ///< of a .volute
  std::string provenance;
};

/// Whether light and velocity can both be written to `target`: a .volute, .vdb files, or names with
/// {grid} in them.
[[nodiscard]] Status checkVelocityTarget(const std::string& target);

/// Writes the light, or whatever else, of reconstructed frames, and their velocity unless it is
/// null. The velocity of a .volute has a relative RMS error of .005, or of `rms` where that is
/// more.
class ReconstructionWriter {
 public:
  /// Before the long work: a target that cannot be written is told now. The sources must outlive
  /// it.
  [[nodiscard]] static Result<ReconstructionWriter> open(FrameSource& frames, FrameSource* velocity,
                                                         ReconstructionOutput output,
                                                         Context& context);

  /// Adds what is to be said of the files. Collective.
  [[nodiscard]] Status write(Report& report, Context& context);

 private:
  [[nodiscard]] Status writeVolute(Report& report, Context& context);
  [[nodiscard]] Status writeVoluteOfBoth(Report& report, Context& context);
  [[nodiscard]] Status writeCache(Context& context);

  std::vector<FrameSource*> sources_;
  ReconstructionOutput output_;
  std::vector<std::unique_ptr<FrameSink>> sinks_;  // of each source, where it has a file of its own
  std::unique_ptr<CacheSink> cache_;               // of both
};

}  // namespace volute::cli
