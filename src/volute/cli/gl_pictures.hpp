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
#include "volute/geometry/triangle_scene.hpp"
#include "volute/gl/gl_smoke.hpp"
#include "volute/gl/gl_volume.hpp"
#include "volute/optics/visibility.hpp"
#include "volute/render/billboard.hpp"
#include "volute/render/render.hpp"
#include "volute/render/sign.hpp"
#include "volute/render/surfaces.hpp"
#include "volute/scene/fds_layer.hpp"
#include "volute/scene/fog_layer.hpp"
#include "volute/scene/scene_lights.hpp"
#include "volute/scene/smoke_layer.hpp"
#include "volute/scene/volume_layer.hpp"

namespace volute::cli {

/// A billboard and the volume that it shows.
struct BillboardLayer {
  VolumeLayer volume;
  BillboardOptions options;
};

/// What a picture by OpenGL shows, and when.
struct GlSubject {
  std::span<VolumeLayer> layers{};
  std::span<const int> positions{};  ///< the frame of each layer
  std::span<const FogLayer> fogs{};
  double time = 0;  ///< [s], of the scene
  std::span<const SmokeState> smokes{};
  double factor = 1;  ///< of all extinctions, as the picture's law has it
  std::span<BillboardLayer> billboards{};
  std::span<const FdsLayer> fdsCases{};
  TriangleScene geometry{};  ///< what throws shadows into fog that suns light
  GlSmokeMethod smokeMethod = GlSmokeMethod::kAuto;
  GlVolumeMethod volumeMethod = GlVolumeMethod::kBricks;  ///< billboards show bricks all the same
};

/// Takes pictures by OpenGL, without a display. In builds without OpenGL there is none.
class GlPictures {
 public:
  /// kUnsupported, in one sentence, where this machine or build has no OpenGL 4.5.
  [[nodiscard]] static Result<std::shared_ptr<GlPictures>> open(bool hardwareOnly);

  virtual ~GlPictures() = default;

  /// As volute::render().
  [[nodiscard]] virtual Result<Image> picture(const Camera& camera, const GlSubject& subject,
                                              const RenderOptions& options, Progress& progress,
                                              RenderStats& stats,
                                              std::span<const float> opaqueDepth = {}) = 0;

  /// As renderSurfaces(); the subject's media take from the lamps' light, by their own extinctions.
  [[nodiscard]] virtual Result<SurfacePicture> surfaces(const Camera& camera,
                                                        const GlSubject& subject,
                                                        const TriangleScene& geometry,
                                                        const SceneLights& lights,
                                                        Progress& progress) = 0;

  /// As lookAtWalls(), with what else stands in the light.
  [[nodiscard]] virtual Result<SurfacePicture> walls(const Camera& camera, const SmokeState& smoke,
                                                     const SceneLights& lights, const Rgb& color,
                                                     const TriangleScene& blocks,
                                                     Progress& progress) = 0;

  /// As signPixels().
  [[nodiscard]] virtual Result<std::vector<SignPixel>> findSigns(
      const Camera& camera, std::span<const Sign> signs, std::span<const float> opaqueDepth) = 0;

  /// What is seen of the signs found last, through the subject up to `opaqueDepth`.
  [[nodiscard]] virtual Result<Image> signLight(const Camera& camera, const GlSubject& subject,
                                                std::span<const Sign> signs, const PictureLaw& law,
                                                Progress& progress,
                                                std::span<const float> opaqueDepth) = 0;

  /// The device's name, and what it did, pass by pass, since it was opened.
  virtual nlohmann::ordered_json stats() = 0;
};

/// What `volute info --gl` says.
[[nodiscard]] Result<Report> describeGl();

/// True where `--renderer auto` may ask for OpenGL: this machine has graphics hardware.
bool glIsLikely();

}  // namespace volute::cli
