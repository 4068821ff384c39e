// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <span>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/camera/camera.hpp"
#include "volute/cli/report.hpp"
#include "volute/render/render.hpp"
#include "volute/scene/fog_layer.hpp"
#include "volute/scene/smoke_layer.hpp"
#include "volute/scene/volume_layer.hpp"

namespace volute::cli {

/// What a picture by OpenGL shows, and when.
struct GlSubject {
  std::span<VolumeLayer> layers{};
  std::span<const int> positions{};  ///< the frame of each layer
  std::span<const FogLayer> fogs{};
  double time = 0;  ///< [s], of the scene
  std::span<const SmokeState> smokes{};
  double factor = 1;  ///< of all extinctions, as the picture's law has it
};

/// Takes pictures by OpenGL, without a display. In builds without OpenGL there is none.
class GlPictures {
 public:
  /// kUnsupported, in one sentence, where this machine or build has no OpenGL 4.5.
  [[nodiscard]] static Result<std::shared_ptr<GlPictures>> open(bool hardwareOnly);

  virtual ~GlPictures() = default;

  /// As volute::render(). kUnsupported for fog that suns light, that has a top, or
  /// under a law whose factor is not 1.
  [[nodiscard]] virtual Result<Image> picture(const Camera& camera, const GlSubject& subject,
                                              const RenderOptions& options, Progress& progress,
                                              RenderStats& stats,
                                              std::span<const float> opaqueDepth = {}) = 0;

  /// The device's name, and what it did, pass by pass, since it was opened.
  virtual nlohmann::ordered_json stats() = 0;
};

/// What `volute info --gl` says.
[[nodiscard]] Result<Report> describeGl();

/// True where `--renderer auto` may ask for OpenGL: this machine has graphics hardware.
bool glIsLikely();

}  // namespace volute::cli
