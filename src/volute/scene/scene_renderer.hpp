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
#include "volute/scene/snapshot.hpp"

namespace volute {

/// What taking a picture came to.
struct PictureCounts {
  RenderStats render;
  std::uint64_t surfacePixels = 0;
  std::uint64_t shadowRays = 0;
  double surfaceMilliseconds = 0;
};

/// Takes pictures of snapshots. Keeps what serves the next picture; takes one at a time.
class SceneRenderer {
 public:
  virtual ~SceneRenderer() = default;

  /// Linear RGB: the light of all media over surfaces, signs and the background; or the AOV, of
  /// which an optical depth is natural whatever the law. kCancelled when `progress` said so,
  /// kUnsupported for media that this renderer does not draw.
  /// @param options  of the picture; what is behind the media comes from the snapshot
  [[nodiscard]] Result<Image> render(const Snapshot& snapshot, const Camera& camera,
                                     const RenderOptions& options, Progress& progress,
                                     PictureCounts* counts = nullptr);

  /// render(), with `samples` rays in the pixels where it has edges: those of surfaces, signs and
  /// boxes, and whatever else a display would show as a step. No AOVs.
  /// @param shown  how light is shown: by that edges are found
  [[nodiscard]] Result<Image> renderSmooth(const Snapshot& snapshot, const Camera& camera,
                                           const RenderOptions& options, int samples,
                                           const PictureStyle& shown, Progress& progress,
                                           PictureCounts* counts = nullptr);

  /// The same without surfaces and walls; signs stay.
  [[nodiscard]] Result<Image> renderBare(const Snapshot& snapshot, const Camera& camera,
                                         const RenderOptions& options, Progress& progress);

  /// "cpu", "gl", "reference".
  virtual std::string_view name() const = 0;

  /// What it is and did, for `render --stats`; an empty object: nothing to be said.
  virtual nlohmann::ordered_json stats() { return nlohmann::ordered_json::object(); }

 protected:
  /// A snapshot as one camera sees it, while its picture is taken.
  struct View {
    const Snapshot& snapshot;
    const Camera& camera;
    std::span<const float> opaqueDepth{};  ///< of what has been drawn so far, as render() takes it
    bool surfaces = true;                  ///< are shown, and walls
    /// Empty, or one for each pixel: of the others nothing is asked.
    std::span<const std::uint8_t> only{};
  };

  /// Before the first of the others for a picture.
  [[nodiscard]] virtual Status begin(const View& view) = 0;

  /// The geometry, lit through the media.
  [[nodiscard]] virtual Result<SurfacePicture> surfaces(const View& view, Progress& progress) = 0;

  /// The walls of a medium that has some: its place in the snapshot.
  [[nodiscard]] virtual Result<SurfaceView> walls(const View& view, std::size_t medium) = 0;

  [[nodiscard]] virtual Result<std::vector<SignPixel>> findSigns(const View& view) = 0;

  /// The light of the media over what options.behind says.
  [[nodiscard]] virtual Result<Image> color(const View& view, const RenderOptions& options,
                                            Progress& progress, RenderStats& stats) = 0;

  /// Of all media, natural logarithm, whatever the law: one channel.
  [[nodiscard]] virtual Result<Image> opticalDepth(const View& view, const RenderOptions& options,
                                                   Progress& progress, RenderStats& stats) = 0;

  /// Adds what is seen of the signs found last.
  [[nodiscard]] virtual Status addSigns(const View& view, std::span<const SignPixel> seen,
                                        const RenderOptions& options, Progress& progress,
                                        Image& image) = 0;

 private:
  class Opaque;

  [[nodiscard]] Result<Image> picture(View view, const RenderOptions& options, Progress& progress,
                                      PictureCounts& counts);

  /// Aov::kDistance, of what is behind view.opaqueDepth.
  [[nodiscard]] Result<Image> distances(View view, const RenderOptions& options, Progress& progress,
                                        PictureCounts& counts);
};

/// The CPU, by the media's fast paths or, as the reference, by their pieces in double. A single
/// medium that draws itself at all pixels at once does so wherever nothing else is on a pixel's
/// ray; rays that meet other media too go through all pieces of all media.
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

  std::vector<std::shared_ptr<MediumPicture>> kept_;      ///< for other instants
  std::vector<std::shared_ptr<MediumPicture>> pictures_;  ///< of each medium of the snapshot; or null
  std::vector<std::vector<AnyMedium>> made_;  ///< of each for the camera; empty for those with a picture
  std::vector<AnyMedium> others_;             ///< all of `made_`
};

}  // namespace volute
