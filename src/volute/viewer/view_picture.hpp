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
#include "volute/viewer/cpu_thread.hpp"
#include "volute/viewer/display.hpp"
#include "volute/viewer/exact_surfaces.hpp"
#include "volute/viewer/view_camera.hpp"

namespace volute {

/// How finely a picture is drawn.
enum class Quality { kAuto, kFull, kHalf, kQuarter };

/// The renderers that may draw.
struct PictureMakers {
  bool hardware = false;  ///< OpenGL is a graphics card, not a rasteriser on the CPU
  std::string device{};   ///< OpenGL's name of it
  bool cpu = true;        ///< else what it would have drawn is an error
  /// A rasteriser may be chosen for OpenGL: its pictures can take a minute, in which nothing
  /// answers.
  bool rasteriser = false;
};

/// The renderer of a picture.
enum class ViewRenderer {
  kAuto,  ///< OpenGL on a graphics card, where it can; else the CPU
  kGl,    ///< what it can, and nothing else; where OpenGL may not be chosen as kAuto
  kCpu,   ///< as `volute render --renderer cpu`
};

/// Camera, size, quality and renderer of a picture.
struct PictureRequest {
  ViewCamera camera;
  int width = 0, height = 0;  ///< [pixels] of the window
  Quality quality = Quality::kAuto;
  ViewRenderer renderer = ViewRenderer::kAuto;
  bool surfaces = true;  ///< opaque things are shown, signs and screens in any case
  bool moving = false;   ///< it changes soon: quick is better than fine
  /// The CPU's time limit for a quick picture [s].
  double budget = 0.1;
  bool single = false;  ///< it is wanted as fine as it gets, nothing before that
  /// After how much rest OpenGL begins to draw surfaces pixel by pixel [s].
  double exactAfter = std::numeric_limits<double>::infinity();
};

/// Times that the last pictures took.
struct FrameTimes {
  double milliseconds = 0;    ///< the last picture, on the device or the CPU
  int width = 0, height = 0;  ///< that it had [pixels]
  bool cpu = false;           ///< who drew it
  std::string why{};          ///< it was the CPU
  /// Times of OpenGL's passes.
  std::vector<GlPassTime> passes{};
  std::vector<float> history{};  ///< the last pictures [ms]
};

/// The picture of a scene, kept up to date: by OpenGL at once, and once it rests with surfaces and
/// walls that are exact, which take several updates; by the CPU in a thread of its own,
/// coarse first. Needs the context that it was made in.
class ViewPicture {
 public:
  [[nodiscard]] static Result<ViewPicture> create(const PictureMakers& makers);

  const PictureMakers& makers() const { return makers_; }

  /// @returns what was shown before: to free it may take longer than a frame
  std::shared_ptr<const ViewScene> setScene(std::shared_ptr<const ViewScene> scene);

  const ViewScene* scene() const { return scene_.get(); }

  /// Draws what has to be drawn, or takes what the CPU has finished. An error is that of the
  /// scene, which then is no longer shown.
  [[nodiscard]] Status update(const PictureRequest& request);

  /// Whether OpenGL can be chosen.
  bool offersGl() const { return makers_.hardware || makers_.rasteriser; }

  /// Whether OpenGL may draw what is requested for.
  bool mayUseGl(ViewRenderer renderer) const {
    return makesOnlyGl(renderer) || (renderer != ViewRenderer::kCpu && makers_.hardware);
  }

  /// Whether it is as fine as it will be, but that surfaces may become exact.
  bool settled(const PictureRequest& request) const;

  /// Whether these are, or will not be.
  bool exact(const PictureRequest& request) const;

  /// Whether the next update() goes on with that.
  bool refining() const { return exact_.begun(); }

  /// How far a picture by the CPU has come; not busy where OpenGL draws.
  CpuProgress progress() const { return fromCpu_ || !shown() ? cpu_->progress() : CpuProgress(); }

  /// The CPU's picture is fine enough, until something changes.
  void stopRefining();

  bool stopped() const { return stopped_; }

  /// State of the picture that is shown.
  struct Shown {
    int version = 0;     ///< counts them
    double time = 0;     ///< [s], may lag behind scene()'s
    double scale = 0;    ///< of the window's pixels a side
    bool stale = false;  ///< of an older camera or snapshot than the last request
  };

  Shown state() const {
    return {version_, shownTime_, scale_, shown() && fromCpu_ && shownNumber_ != asked_};
  }

  /// Whether update() would take over something.
  bool hasNews() const { return cpu_->has(); }

  /// Another document: what pictures of the last one took says nothing.
  void forgetCosts();

  /// Is called, in another thread, when there is news.
  void onNews(std::function<void()> wake) { cpu_->onDelivery(std::move(wake)); }

  bool shown() const { return scale_ > 0; }

  /// Before the first show(), while there is nothing to be shown.
  void prepareShow() { display_.prepare(); }

  /// Into the framebuffer that is bound; `look.surfaces` is its own.
  void show(DisplayLook look, int width, int height);

  /// The other picture of a comparison, in linear light.
  DisplayLook::Other shownLight() const;

  /// The light that is shown, before the exposure, at every n-th pixel of every n-th row: as many
  /// as an exposure can be told from. A document without a picture by the CPU (a capture)
  /// shows its screens as they are: they do not count.
  Image sampledLight(const Rgb& background) const;

  const FrameTimes& times() const { return times_; }

  /// What OpenGL would not draw, and what became of it; empty: nothing to be said.
  const std::string& remark() const { return remark_; }

 private:
  ViewPicture(GlRenderer renderer, SurfaceDrawer surfaces, Display display);

  bool makesOnlyGl(ViewRenderer renderer) const {
    return renderer == ViewRenderer::kGl && offersGl();
  }

  bool byCpu(const PictureRequest& request) const;
  std::string whyCpu(const PictureRequest& request) const;
  Status drawMedia(const PictureRequest& request, const Camera& camera);
  double quickScale(const PictureRequest& request, double seconds) const;
  double cpuScale(const PictureRequest& request, bool& preview) const;
  void askCpu(const PictureRequest& request, double first, double finest, bool preview);
  void show(const CpuPart& part);
  Status drawByGl(const PictureRequest& request, double scale);
  bool mayBeExact(const PictureRequest& request) const;
  Status refine(const PictureRequest& request);
  void dropExact();
  Status drawByCpu(const PictureRequest& request);
  Status takeFinished();
  void noteTime(double seconds, int width, int height, bool cpu);
  GLuint texture() const;

  GlRenderer renderer_;
  SurfaceDrawer surfaces_;
  ExactSurfaces exact_;  ///< while they are being drawn
  Display display_;
  GlTexture blank_;    ///< no light, nothing in the way
  GlTexture picture_;  ///< the CPU's
  int pictureWidth_ = 0, pictureHeight_ = 0;
  std::unique_ptr<CpuThread> cpu_;
  std::shared_ptr<const ViewScene> scene_;
  FrameTimes times_;
  std::string remark_;
  std::string refused_;                            ///< why OpenGL would not draw this scene
  std::string refusedExact_;                       ///< and why not its surfaces
  std::chrono::steady_clock::time_point drawnAt_;  ///< OpenGL's picture
  bool isExact_ = false;
  double scale_ = 0;      ///< of the window's pixels a side, of the picture that is shown; 0: none
  PictureRequest drawn_;  ///< that the picture answers
  bool changed_ = true;   ///< another scene since
  PictureMakers makers_;
  bool opaque_ = false;       ///< OpenGL's picture has surfaces
  bool media_ = false;        ///< and media
  bool fromCpu_ = false;      ///< the CPU took it
  bool stopped_ = false;      ///< a person wants it no finer
  int version_ = 0;           ///< of the picture that is shown
  int asked_ = 0;             ///< number of the last request to the CPU,
  int shownNumber_ = 0;       ///< and of the picture that is shown
  bool asksForAll_ = false;   ///< it goes on by itself until the picture is as fine as it gets
  bool shownFinest_ = false;  ///< which it is
  bool shownPreview_ = false;
  double shownTime_ = 0;  ///< [s] of the document
  double glSecondsAPixel_ = 2e-8, cpuSecondsAPixel_ = 0,
         previewSecondsAPixel_ = 0;  ///< what pictures have cost; 0: nobody knows
};

}  // namespace volute
