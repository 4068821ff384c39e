// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/camera/camera.hpp"
#include "volute/image/image.hpp"
#include "volute/image/picture_style.hpp"
#include "volute/render/render.hpp"
#include "volute/render/surfaces.hpp"
#include "volute/scene/scene_signs.hpp"
#include "volute/scene/scene_snapshot.hpp"

namespace volute {

/// Statistics of rendering a picture.
struct PictureCounts {
  RenderStats render;
  std::uint64_t surfacePixels = 0;
  std::uint64_t shadowRays = 0;
  double surfaceMilliseconds = 0;
};

/// Renders pictures of snapshots, one at a time. Keeps data that the next picture can reuse.
class SceneRenderer {
 public:
  virtual ~SceneRenderer() = default;

  /// Linear RGB: the light of all media over surfaces, signs and the background; or the AOV, where
  /// optical depth uses the natural logarithm for every law. kCancelled if `progress` requests it,
  /// kUnsupported for media that this renderer cannot draw.
  /// @param options  of the picture; the background comes from the snapshot
  [[nodiscard]] Result<Image> render(const SceneSnapshot& snapshot, const Camera& camera,
                                     const RenderOptions& options, Progress& progress,
                                     PictureCounts* counts = nullptr);

  /// render(), with `samples` rays in pixels with edges: of surfaces, signs and boxes, and any
  /// other visible steps. No AOVs but kAlpha.
  /// @param shown  how light is displayed, for finding edges
  [[nodiscard]] Result<Image> renderSmooth(const SceneSnapshot& snapshot, const Camera& camera,
                                           const RenderOptions& options, int samples,
                                           const PictureStyle& shown, Progress& progress,
                                           PictureCounts* counts = nullptr);

  /// The same without surfaces and walls; signs stay.
  [[nodiscard]] Result<Image> renderBare(const SceneSnapshot& snapshot, const Camera& camera,
                                         const RenderOptions& options, Progress& progress);

  /// "cpu", "gl", "reference".
  virtual std::string_view name() const = 0;

  /// Statistics for `render --stats`; an empty object: none.
  virtual nlohmann::ordered_json stats();

 protected:
  /// A snapshot and a camera, while a picture is rendered.
  struct View {
    const SceneSnapshot& snapshot;
    const Camera& camera;
    std::span<const float> opaqueDepth{};  ///< depth of what has been drawn so far, as for render()
    bool surfaces = true;                  ///< draw surfaces and walls
    /// Empty, or one value per pixel: pixels with 0 are not needed.
    std::span<const std::uint8_t> only{};
  };

  /// Called before the other functions for a picture.
  [[nodiscard]] virtual Status begin(const View& view) = 0;

  /// The geometry, lit through the media.
  [[nodiscard]] virtual Result<SurfacePicture> surfaces(const View& view, Progress& progress) = 0;

  /// The walls of a medium, given by its index in the snapshot.
  [[nodiscard]] virtual Result<SurfaceView> walls(const View& view, std::size_t medium) = 0;

  [[nodiscard]] virtual Result<std::vector<SignPixel>> findSigns(const View& view) = 0;

  /// The light of the media over options.behind.
  [[nodiscard]] virtual Result<Image> color(const View& view, const RenderOptions& options,
                                            Progress& progress, RenderStats& stats) = 0;

  /// The optical depth of all media, natural logarithm for every law: one channel.
  [[nodiscard]] virtual Result<Image> opticalDepth(const View& view, const RenderOptions& options,
                                                   Progress& progress, RenderStats& stats) = 0;

  /// Adds the visible light of the signs found last.
  [[nodiscard]] virtual Status addSigns(const View& view, std::span<const SignPixel> seen,
                                        const RenderOptions& options, Progress& progress,
                                        Image& image) = 0;

 private:
  class Opaque;

  [[nodiscard]] Result<Image> picture(View view, const RenderOptions& options, Progress& progress,
                                      PictureCounts& counts);

  /// Aov::kDistance, given view.opaqueDepth.
  [[nodiscard]] Result<Image> distances(View view, const RenderOptions& options, Progress& progress,
                                        PictureCounts& counts);
};

/// Renders on the CPU, by the media's fast paths or, as the reference, by their pieces in double. A
/// medium that can draw all pixels at once does so wherever nothing else is on a pixel's ray; rays
/// that also meet other media go through the pieces of all media.
class CpuRenderer final : public SceneRenderer {
 public:
  explicit CpuRenderer(Renderer method = Renderer::kCpu) : method_(method) {}

  std::string_view name() const override {
    return method_ == Renderer::kReference ? "reference" : "cpu";
  }

 protected:
  Status begin(const View& view) override;
  Result<SurfacePicture> surfaces(const View& view, Progress& progress) override;
  Result<SurfaceView> walls(const View& view, std::size_t medium) override;
  Result<std::vector<SignPixel>> findSigns(const View& view) override;
  Result<Image> color(const View& view, const RenderOptions& options, Progress& progress,
                      RenderStats& stats) override;
  Result<Image> opticalDepth(const View& view, const RenderOptions& options, Progress& progress,
                             RenderStats& stats) override;
  Status addSigns(const View& view, std::span<const SignPixel> seen, const RenderOptions& options,
                  Progress& progress, Image& image) override;

 private:
  Renderer method_;
  /// All media for the camera, in the snapshot's order.
  [[nodiscard]] Result<std::vector<AnyMedium>> mediaFor(const View& view) const;
  [[nodiscard]] Result<std::vector<AnyMedium>> wholeFor(const View& view) const;

  std::vector<std::shared_ptr<MediumPicture>> kept_;  ///< for other snapshots
  std::vector<std::shared_ptr<MediumPicture>>
      pictures_;  ///< of each medium of the snapshot; or null
  std::vector<std::vector<AnyMedium>>
      made_;                       ///< of each for the camera; empty for those with a picture
  std::vector<AnyMedium> others_;  ///< all of `made_`
  std::vector<float> rgbt_;        ///< of the last picture: kept for its memory
};

}  // namespace volute
