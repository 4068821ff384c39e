// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bench/smoke_views.hpp"
#include "volute/base/process_usage.hpp"
#include "volute/base/result.hpp"
#include "volute/tetmesh/tet_locator.hpp"

// What `volute bench smoke` compares.

namespace volute::bench {

/// Of one frame [s], with what new smoke takes.
struct DrawTimes {
  double wall = 0, cpu = 0;
};

/// What a drawer is for: what is asked of it, and how much of its pictures is worth the time.
enum class SmokeRole {
  kBaseline,  ///< VTK's projected tetrahedra: what all ratios are to
  kDepth,     ///< transmittance
  kLit,       ///< lit colour
  kOther,     ///< other peers
};

class SmokeDrawer {
 public:
  virtual ~SmokeDrawer() = default;
  virtual std::string_view name() const = 0;
  virtual SmokeRole role() const = 0;

  /// The opacity of each pixel.
  [[nodiscard]] virtual Result<DrawTimes> draw(const SmokeView& view, std::span<float> opacity) = 0;
};

/// VTK's projected tetrahedra first, then Volute's, then slower ones of VTK. Hold the case alive.
std::vector<std::unique_ptr<SmokeDrawer>> smokeDrawers(
    const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator, bool quick);

}  // namespace volute::bench
