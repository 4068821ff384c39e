// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "volute/io/mesh_source.hpp"
#include "volute/lighting/light_cache.hpp"
#include "volute/lighting/vertex_light.hpp"
#include "volute/scene/reading.hpp"
#include "volute/scene/scene_lights.hpp"
#include "volute/scene/scene_smoke.hpp"

namespace volute {

/// Smoke at one instant, on its mesh.
struct SmokeState {
  std::shared_ptr<const TetLocator> locator;
  std::vector<float> extinction;               ///< [1/m], natural logarithm, one for each vertex
  std::vector<float> source;                   ///< see TetMedium; empty: black
  std::vector<std::vector<float>> lampShares;  ///< of each lamp, at each vertex
};

/// What lights smoke, and where computed light is kept.
struct SmokeLighting {
  SceneLights lights;
  std::optional<LightCache> cache;
  Blocks blocks;          ///< other opaque things; may be empty
  std::string blocksKey;  ///< stands for them in the cache
};

/// What was done, summed over all pictures.
struct SmokeCounts {
  std::uint64_t stepsRead = 0;
  std::uint64_t lightsComputed = 0;  ///< one for each lamp and step
  std::uint64_t lightsReused = 0;    ///< read from the cache
  std::uint64_t clamped = 0;         ///< negative values taken as 0
  double lightMilliseconds = 0;
};

/// A case of smoke that is shown: gives the smoke at any time. Holds two steps of it at most.
class SmokeLayer {
 public:
  /// Reads the first step.
  [[nodiscard]] static Result<SmokeLayer> open(const SmokeDescription& description,
                                               std::shared_ptr<const SmokeLighting> lighting,
                                               Reading& reading);

  const SmokeDescription& description() const { return description_; }

  const SceneLights& lights() const { return lighting_->lights; }

  const Box3& bounds() const { return bounds_; }

  int steps() const { return static_cast<int>(source_.times().size()); }

  /// When a step is shown as it is, in the scene's time [s].
  double timeOf(int step) const;

  /// At a time of the scene [s]. Between two steps extinction, and what reaches each vertex of a
  /// lamp's light, is linear in time; meshes that differ are held until the next. Before the first
  /// and after the last step it is theirs.
  [[nodiscard]] Result<SmokeState> at(double time);

  /// Who hears of later reads, instead of the reading that it was opened in.
  void setProgress(Progress& progress) { progress_ = &progress; }

  const SmokeCounts& counts() const { return counts_; }

 private:
  struct Step {
    std::size_t index = 0;
    std::shared_ptr<const LampPaths> paths;
    std::shared_ptr<const TetMesh> mesh;
    std::vector<float> extinction;
    std::vector<std::vector<float>> lampShares;
  };

  SmokeLayer(SmokeDescription description, MeshSource source)
      : description_(std::move(description)), source_(std::move(source)) {}

  [[nodiscard]] Result<std::shared_ptr<const Step>> step(std::size_t index);
  [[nodiscard]] Result<Step> readStep(std::size_t index);
  [[nodiscard]] Result<std::vector<float>> extinctionOf(const MeshFrame& frame, std::size_t index);
  void light(Step& step);
  std::string lightKey(const Step& step, const Lamp& lamp) const;
  void remarkOn(const MeshFrame& frame, std::span<const float> extinction);

  SmokeDescription description_;
  MeshSource source_;
  std::optional<MeshSource> densitySource_;
  std::shared_ptr<const SmokeLighting> lighting_;
  Box3 bounds_;
  Progress* progress_ = nullptr;
  std::vector<std::shared_ptr<const Step>> steps_;  ///< the last two
  SmokeCounts counts_;
  bool remarked_ = false;
};

}  // namespace volute
