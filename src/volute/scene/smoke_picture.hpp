// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/render/render.hpp"
#include "volute/scene/smoke_layer.hpp"
#include "volute/tetmesh/tet_marcher.hpp"
#include "volute/tetmesh/tet_splat.hpp"

namespace volute {

/// What is in a picture at one instant.
struct SmokeScene {
  std::span<const SmokeState> smokes;
  std::span<const AnyMedium> others;  ///< as the law sees them
  PictureLaw law;
  std::span<const float> opaqueDepth;  ///< as render() takes it
};

/// Pictures of smoke together with other media. A single smoke is splatted (black smoke) or marched
/// (lit smoke) wherever nothing else is on a pixel's ray; rays that meet other media too, pictures
/// of several smokes, and the reference, go through all pieces of all media.
class SmokePictures {
 public:
  /// As render() does it; signs and surfaces are not in it.
  [[nodiscard]] Result<Image> color(const Camera& camera, const SmokeScene& scene,
                                    const RenderOptions& options, Progress& progress,
                                    RenderStats& stats);

  /// The integral of the extinction along each pixel's ray, natural logarithm, whatever the law:
  /// one channel.
  [[nodiscard]] Result<Image> opticalDepth(const Camera& camera, const SmokeScene& scene,
                                           const RenderOptions& options, Progress& progress,
                                           RenderStats& stats);

 private:
  /// What goes fast through one mesh.
  struct Fast {
    explicit Fast(const std::shared_ptr<const TetLocator>& mesh)
        : locator(mesh), marcher(mesh), splat(mesh) {}

    std::shared_ptr<const TetLocator> locator;
    TetMarcher marcher;
    TetSplat splat;
  };

  Fast& fastFor(const std::shared_ptr<const TetLocator>& locator);
  Image smokeAlone(const Camera& camera, const SmokeScene& scene, const RenderOptions& options);

  std::unique_ptr<Fast> fast_;
};

}  // namespace volute
