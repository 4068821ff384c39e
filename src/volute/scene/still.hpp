// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/camera/camera.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/medium/any_medium.hpp"
#include "volute/render/billboard.hpp"
#include "volute/render/render.hpp"
#include "volute/render/surfaces.hpp"
#include "volute/scene/scene_lights.hpp"
#include "volute/scene/scene_signs.hpp"
#include "volute/scene/smoke_layer.hpp"
#include "volute/scene/smoke_picture.hpp"
#include "volute/scene/smoke_walls.hpp"

namespace volute {

class StillDrawer;

/// A medium as the law of a picture sees it.
AnyMedium seenBy(const PictureLaw& law, AnyMedium medium);

/// A medium that depends on the eye, as a camera sees it.
using MediumForCamera = std::function<Result<AnyMedium>(const Camera& camera)>;

/// What taking a picture of a Still came to.
struct StillCounts {
  RenderStats render;
  std::uint64_t surfacePixels = 0;
  std::uint64_t shadowRays = 0;
  double surfaceMilliseconds = 0;
};

/// One instant of a scene with all that pictures of it need. Nothing in it changes, so that threads
/// may take pictures while others go on to the next instant.
struct Still {
  std::vector<AnyMedium> media;         ///< as the law sees them; smoke on meshes is not in it
  std::vector<MediumForCamera> viewed;  ///< likewise, for each camera anew
  std::vector<SmokeState> smokes;
  std::vector<std::optional<Rgb>> walls;  ///< of each smoke's mesh; nothing: not shown
  PictureLaw law;
  TriangleScene geometry;
  SceneLights lights;
  std::vector<Sign> signs;

  /// Linear RGB: the light of all media over surfaces, signs and the background, as `volute render`
  /// shows it; or the AOV, of which an optical depth is natural whatever the law. kCancelled when
  /// `progress` said so.
  /// @param options  of the picture; what is behind the media comes from the still
  [[nodiscard]] Result<Image> picture(const Camera& camera, const RenderOptions& options,
                                      StillDrawer& drawer, Progress& progress,
                                      StillCounts* counts = nullptr) const;
};

/// A still, as one camera sees it, while its picture is taken.
struct StillView {
  const Camera& camera;
  const Still& still;
  std::span<const AnyMedium> media;      ///< the still's, and those made for the camera
  std::span<const float> opaqueDepth{};  ///< of what has been drawn so far, as render() takes it

  SmokeScene smokeScene() const { return {still.smokes, media, still.law, opaqueDepth}; }
};

/// Who draws the parts of a still's picture.
class StillDrawer {
 public:
  virtual ~StillDrawer() = default;

  /// Whether the still's media are drawn as AnyMedium, so that those for a camera are made.
  virtual bool drawsMedia() const { return true; }

  /// The geometry, lit through the media.
  [[nodiscard]] virtual Result<SurfacePicture> surfaces(const StillView& view,
                                                        Progress& progress) = 0;

  /// The walls of a smoke's mesh.
  [[nodiscard]] virtual Result<SurfaceView> walls(const StillView& view, std::size_t smoke) = 0;

  [[nodiscard]] virtual Result<std::vector<SignPixel>> findSigns(const StillView& view) = 0;

  /// The light of the media over what options.behind says.
  [[nodiscard]] virtual Result<Image> color(const StillView& view, const RenderOptions& options,
                                            Progress& progress, RenderStats& stats) = 0;

  /// Of all media, natural logarithm, whatever the law: one channel.
  [[nodiscard]] virtual Result<Image> opticalDepth(const StillView& view,
                                                   const RenderOptions& options, Progress& progress,
                                                   RenderStats& stats) = 0;

  /// Adds what is seen of the signs found last.
  [[nodiscard]] virtual Status addSigns(const StillView& view, std::span<const SignPixel> seen,
                                        const RenderOptions& options, Progress& progress,
                                        Image& image) = 0;
};

/// The processor. Keeps what serves the next picture of the same mesh; takes one at a time.
class ProcessorDrawer final : public StillDrawer {
 public:
  Result<SurfacePicture> surfaces(const StillView& view, Progress& progress) override;
  Result<SurfaceView> walls(const StillView& view, std::size_t smoke) override;
  Result<std::vector<SignPixel>> findSigns(const StillView& view) override;
  Result<Image> color(const StillView& view, const RenderOptions& options, Progress& progress,
                      RenderStats& stats) override;
  Result<Image> opticalDepth(const StillView& view, const RenderOptions& options,
                             Progress& progress, RenderStats& stats) override;
  Status addSigns(const StillView& view, std::span<const SignPixel> seen,
                  const RenderOptions& options, Progress& progress, Image& image) override;

 private:
  SmokePictures smoke_;
};

}  // namespace volute
