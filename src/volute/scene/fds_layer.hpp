// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "volute/fds/fds_case.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/medium/any_medium.hpp"
#include "volute/scene/reading.hpp"
#include "volute/scene/scene_smoke.hpp"

namespace volute {

/// An FDS case that is shown: its smoke and its building at any time. Holds two stored frames.
class FdsLayer {
 public:
  /// `description` says the case, the source (its field; empty: the best that fills meshes), a
  /// scale, Km and the albedo; the case itself says what its files hold, so kInvalidArgument for
  /// another quantity. Smoke scatters `ambient`; lamps do not light it.
  [[nodiscard]] static Result<FdsLayer> open(const SmokeDescription& description,
                                             const Rgb& ambient, Reading& reading);

  const SmokeDescription& description() const { return description_; }

  /// What the extinction is read from, in words.
  const std::string& source() const { return case_->source().description; }

  const Box3& bounds() const { return case_->bounds(); }

  int steps() const { return static_cast<int>(case_->times().size()); }

  /// When a stored frame is shown as it is, in the scene's time [s].
  double timeOf(int step) const;

  /// The smoke at a time of the scene [s], linear between stored frames.
  [[nodiscard]] Result<AnyMedium> mediumAt(double time) const;

  /// How many of the times at which obstructions come or go are past: while it stays, so does the
  /// building.
  std::size_t changesUntil(double time) const;

  /// Adds the obstructions and vents of that time, coloured as the case says; ambient light alone
  /// would show no edges, so faces along x reflect 0.7 and along y 0.85 of their colour.
  void addBuilding(double time, TriangleMesh& to) const;

 private:
  FdsLayer() = default;

  double caseTime(double time) const;

  SmokeDescription description_;
  Rgb ambient_ = Rgb::Zero();
  std::shared_ptr<FdsCase> case_;
  std::vector<double> events_;
};

}  // namespace volute
