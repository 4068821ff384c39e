// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <chrono>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "volute/gl/gl_renderer.hpp"
#include "volute/gl/surface_drawer.hpp"
#include "volute/viewer/display.hpp"
#include "volute/viewer/exact_surfaces.hpp"
#include "volute/viewer/processor_thread.hpp"
#include "volute/viewer/view_camera.hpp"

namespace volute {

/// How finely a picture is drawn.
enum class Quality { kAuto, kFull, kHalf, kQuarter };

/// Who may draw.
struct PictureMakers {
  bool hardware = false;  ///< OpenGL is a graphics card, not a rasteriser on the processor
  bool processor = true;  ///< else what it would have drawn is an error
};

/// Who draws it.
enum class ViewRenderer {
  kAuto,       ///< OpenGL on a graphics card, where it can; else the processor
  kGl,         ///< what it can, and nothing else
  kProcessor,  ///< as `volute render --renderer cpu`
};

/// What a picture is to be.
struct PictureWish {
  ViewCamera camera;
  int width = 0, height = 0;  ///< [pixels] of the window
  Quality quality = Quality::kAuto;
  ViewRenderer renderer = ViewRenderer::kAuto;
  bool surfaces = true;  ///< opaque things are shown, signs and screens in any case
  bool moving = false;   ///< it changes soon: quick is better than fine
  /// After how much rest OpenGL begins to draw surfaces pixel by pixel [s].
  double exactAfter = std::numeric_limits<double>::infinity();
};

/// What the last pictures took.
struct FrameTimes {
  double milliseconds = 0;    ///< the last picture, on the device or the processor
  int width = 0, height = 0;  ///< that it had [pixels]
  bool processor = false;     ///< who drew it
  std::string why{};          ///< it was the processor
  /// What OpenGL did for it.
  std::vector<GlPassTime> passes{};
  std::vector<float> history{};  ///< the last pictures [ms]
};

/// The picture of a scene, kept up to date: by OpenGL at once, and once it rests with surfaces and
/// walls that are exact, which take several updates; by the processor in a thread of its own,
/// coarse first. Needs the context that it was made in.
class ViewPicture {
 public:
  [[nodiscard]] static Result<ViewPicture> create(const PictureMakers& makers);

  const PictureMakers& makers() const { return makers_; }

  /// @returns what was shown before: to free it may take longer than a frame
  std::shared_ptr<const ViewScene> setScene(std::shared_ptr<const ViewScene> scene);

  const ViewScene* scene() const { return scene_.get(); }

  /// Draws what has to be drawn, or takes what the processor has finished. An error is that of the
  /// scene, which then is no longer shown.
  [[nodiscard]] Status update(const PictureWish& wish);

  /// Whether OpenGL may draw what is wished for.
  bool mayUseGl(ViewRenderer renderer) const {
    return renderer == ViewRenderer::kGl || (renderer == ViewRenderer::kAuto && makers_.hardware);
  }

  /// Whether it is as fine as it will be, but that surfaces may become exact.
  bool settled(const PictureWish& wish) const;

  /// Whether these are, or will not be.
  bool exact(const PictureWish& wish) const;

  /// Whether the next update() goes on with that.
  bool refining() const { return exact_.begun(); }

  bool shown() const { return scale_ > 0; }

  /// Into the framebuffer that is bound; `look.surfaces` is its own.
  void show(DisplayLook look, int width, int height);

  /// The light that is shown, before the exposure, at every n-th pixel of every n-th row: as many
  /// as an exposure can be told from. A document without a picture by the processor (a capture)
  /// shows its screens as they are: they do not count.
  Image sampledLight(const Rgb& background) const;

  const FrameTimes& times() const { return times_; }

  /// What OpenGL would not draw, and what became of it; empty: nothing to be said.
  const std::string& remark() const { return remark_; }

 private:
  ViewPicture(GlRenderer renderer, SurfaceDrawer surfaces, Display display);

  bool byProcessor(const PictureWish& wish) const;
  std::string whyProcessor(const PictureWish& wish) const;
  Status drawMedia(const PictureWish& wish, const Camera& camera);
  double quickScale(const PictureWish& wish, double seconds) const;
  Status drawByGl(const PictureWish& wish, double scale);
  bool mayBeExact(const PictureWish& wish) const;
  Status refine(const PictureWish& wish);
  void dropExact();
  Status drawByProcessor(const PictureWish& wish);
  Status takeFinished();
  void noteTime(double seconds, int width, int height, bool processor);
  GLuint texture() const;

  GlRenderer renderer_;
  SurfaceDrawer surfaces_;
  ExactSurfaces exact_;  ///< while they are being drawn
  Display display_;
  GlTexture blank_;    ///< no light, nothing in the way
  GlTexture picture_;  ///< the processor's
  int pictureWidth_ = 0, pictureHeight_ = 0;
  std::unique_ptr<ProcessorThread> processor_;
  std::shared_ptr<const ViewScene> scene_;
  FrameTimes times_;
  std::string remark_;
  std::string refused_;                            ///< why OpenGL would not draw this scene
  std::string refusedExact_;                       ///< and why not its surfaces
  std::chrono::steady_clock::time_point drawnAt_;  ///< OpenGL's picture
  bool isExact_ = false;
  double scale_ = 0;     ///< of the window's pixels a side, of the picture that is shown; 0: none
  PictureWish drawn_;    ///< that the picture answers
  bool changed_ = true;  ///< another scene since
  PictureMakers makers_;
  bool opaque_ = false;     ///< OpenGL's picture has surfaces
  bool media_ = false;      ///< and media
  bool processed_ = false;  ///< the processor took it
  int version_ = 0;         ///< of the picture that is shown
  int asked_ = 0;           ///< number of the wish that the processor works on
  double askedScale_ = 0, finishedScale_ = 0;
  bool askedQuickly_ = false;
  double secondsAPixel_ = 2e-8, processorAPixel_ = 1e-6;  ///< what pictures have cost
};

}  // namespace volute
