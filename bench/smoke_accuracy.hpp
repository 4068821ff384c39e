// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "bench/smoke_targets.hpp"
#include "volute/base/progress.hpp"
#include "volute/tetmesh/tet_reference.hpp"

// What `volute bench smoke` holds against the references in double, by samples.

namespace volute::bench {

/// Opacities of some pixels of a view, by the reference: always the same ones.
class SampledOpacity {
 public:
  SampledOpacity(const TetMedium& medium, const SmokeView& view, std::size_t pixels);

  /// Of CPU time.
  double secondsPerPixel() const { return secondsPerPixel_; }

  std::size_t pixels() const { return pixels_.size(); }

  /// Of a whole picture: the largest error, and the share of these pixels that are off by more than
  /// one step of 8 bits.
  std::pair<double, double> errors(std::span<const float> opacity) const;

 private:
  double secondsPerPixel_ = 0;
  std::vector<std::size_t> pixels_;
  std::vector<double> alpha_;
};

/// What reaches vertices of a lamp's light, shadows included, against a reference ray for each of
/// `samples` of them (all, if that is more than there are).
void judgeLight(const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator,
                const Vec3& lamp, std::size_t samples, BenchRows& rows, SmokeTargets& targets);

/// Light at some vertices, and some pixels' opacities with the eye on a vertex, an edge and a face
/// of the mesh. Takes seconds.
[[nodiscard]] Status judgeSamples(const SmokeCase& smoke,
                                  const std::shared_ptr<const TetLocator>& locator, BenchRows& rows,
                                  SmokeTargets& targets, Progress& progress);

}  // namespace volute::bench
