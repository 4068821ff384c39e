// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/view_picture.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace volute {
namespace {

constexpr double kQuick = 0.04;           ///< [s] that OpenGL may take while something moves
constexpr double kProcessorQuick = 0.15;  ///< [s], and the processor
constexpr double kRefine = 0.012;         ///< [s] of an update that surfaces get, about
constexpr double kCoarsest = 1.0 / 8;     ///< of the window's pixels a side
constexpr std::size_t kHistory = 90;
constexpr double kSamples = 65536;  ///< of the light that is shown

double scaleOf(Quality quality) {
  switch (quality) {
    case Quality::kHalf:
      return 0.5;
    case Quality::kQuarter:
      return 0.25;
    default:
      return 1;
  }
}

int pixels(double scale, int side) {
  return std::max(8, static_cast<int>(std::lround(scale * side)));
}

struct Texels {
  int width = 0, height = 0;
  std::vector<float> rgba{};

  const float* at(int x, int y) const {
    return &rgba[4 * (static_cast<std::size_t>(y) * width + x)];
  }
};

Texels texelsOf(GLuint texture) {
  Texels texels;
  glGetTextureLevelParameteriv(texture, 0, GL_TEXTURE_WIDTH, &texels.width);
  glGetTextureLevelParameteriv(texture, 0, GL_TEXTURE_HEIGHT, &texels.height);
  texels.rgba.resize(4 * static_cast<std::size_t>(texels.width) * texels.height);
  glGetTextureImage(texture, 0, GL_RGBA, GL_FLOAT,
                    static_cast<GLsizei>(texels.rgba.size() * sizeof(float)), texels.rgba.data());
  return texels;
}

bool sameView(const PictureWish& a, const PictureWish& b) {
  return a.camera == b.camera && a.width == b.width && a.height == b.height &&
         a.surfaces == b.surfaces;
}

}  // namespace

ViewPicture::ViewPicture(GlRenderer renderer, SurfaceDrawer surfaces, Display display)
    : renderer_(std::move(renderer)),
      surfaces_(std::move(surfaces)),
      display_(std::move(display)),
      processor_(std::make_unique<ProcessorThread>()) {
  constexpr float kNothing[4] = {};
  blank_ = makeTexture2d(GL_RGBA32F, 1, 1);
  glTextureSubImage2D(blank_.name(), 0, 0, 0, 1, 1, GL_RGBA, GL_FLOAT, kNothing);
}

Result<ViewPicture> ViewPicture::create(const PictureMakers& makers) {
  VOLUTE_ASSIGN(auto renderer, GlRenderer::create());
  VOLUTE_ASSIGN(auto surfaces, SurfaceDrawer::create());
  VOLUTE_ASSIGN(auto display, Display::create());
  ViewPicture picture(std::move(renderer), std::move(surfaces), std::move(display));
  picture.makers_ = makers;
  return picture;
}

std::shared_ptr<const ViewScene> ViewPicture::setScene(std::shared_ptr<const ViewScene> scene) {
  changed_ = true;
  refused_.clear();
  refusedExact_.clear();
  return std::exchange(scene_, std::move(scene));
}

bool ViewPicture::byProcessor(const PictureWish& wish) const {
  if (!scene_->processor || wish.renderer == ViewRenderer::kGl)
    return false;
  return wish.renderer == ViewRenderer::kProcessor || !makers_.hardware || !refused_.empty();
}

std::string ViewPicture::whyProcessor(const PictureWish& wish) const {
  return wish.renderer == ViewRenderer::kProcessor ? "as you chose"
         : !makers_.hardware                       ? "there is no graphics card"
                                                   : refused_;
}

double ViewPicture::quickScale(const PictureWish& wish, double seconds) const {
  const double count = static_cast<double>(wish.width) * wish.height;
  const bool processor = byProcessor(wish);
  const double cost = (processor ? processorAPixel_ : secondsAPixel_) * count;
  return std::clamp(std::sqrt(seconds / cost), kCoarsest, scaleOf(wish.quality));
}

void ViewPicture::noteTime(double seconds, int width, int height, bool processor) {
  times_.milliseconds = 1e3 * seconds;
  times_.width = width, times_.height = height;
  times_.processor = processor;
  times_.history.push_back(static_cast<float>(times_.milliseconds));
  if (times_.history.size() > kHistory)
    times_.history.erase(times_.history.begin());
  (processor ? processorAPixel_ : secondsAPixel_) = seconds / (static_cast<double>(width) * height);
}

/// What is refused once is not tried again before the scene changes.
Status ViewPicture::drawMedia(const PictureWish& wish, const Camera& camera) {
  media_ = false;
  if (!scene_->notByGl.empty() && wish.renderer != ViewRenderer::kGl)
    return fail(ErrorCode::kUnsupported, "{}", scene_->notByGl);
  if (scene_->media.parts.empty() || (wish.renderer == ViewRenderer::kGl && !refused_.empty()))
    return {};
  const auto depth = opaque_ ? surfaces_.depth() : std::span<const float>();
  Progress quiet;
  const Status drawn = renderer_.draw(camera, scene_->media, GlQuantity::kLight, quiet, depth);
  media_ = drawn.has_value();
  return drawn;
}

Status ViewPicture::drawByGl(const PictureWish& wish, double scale) {
  const int width = pixels(scale, wish.width), height = pixels(scale, wish.height);
  const Camera camera = wish.camera.camera(width, height);
  dropExact();
  isExact_ = false;
  const auto begun = std::chrono::steady_clock::now();
  ++version_;
  opaque_ = surfaces_.draw(camera, scene_->surfaces, scene_->quads, wish.surfaces);
  const std::chrono::duration<double> rasterised = std::chrono::steady_clock::now() - begun;
  VOLUTE_TRY(drawMedia(wish, camera));
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begun;
  double onDevice = 0;
  times_.passes = renderer_.takePasses();
  drawnAt_ = std::chrono::steady_clock::now();
  if (opaque_)  // until their depths were read back
    times_.passes.push_back({"rasterise", "opaque things", 1, 1e3 * rasterised.count()});
  for (const GlPassTime& pass : times_.passes) onDevice += 1e-3 * pass.milliseconds;
  // A rasteriser on the processor has computed before its clock looks.
  noteTime(makers_.hardware && onDevice > 0 ? onDevice : spent.count(), width, height, false);
  scale_ = scale;
  processed_ = false;
  return {};
}

bool ViewPicture::mayBeExact(const PictureWish& wish) const {
  return scene_ && scene_->snapshot && wish.surfaces && !wish.moving && refusedExact_.empty() &&
         !byProcessor(wish);
}

void ViewPicture::dropExact() {
  if (!exact_.begun())
    return;
  exact_.drop();
  renderer_.takePasses();  // they are no picture's
}

/// Some tiles of the exact surfaces. Once all are there they are shown; the media before them are
/// drawn again only if surfaces were elsewhere. What is refused stays as it is.
Status ViewPicture::refine(const PictureWish& wish) {
  const std::chrono::duration<double> rested = std::chrono::steady_clock::now() - drawnAt_;
  if (isExact_ || !mayBeExact(wish) || !(rested.count() >= wish.exactAfter))
    return {};
  if (!exact_.begun()) {
    const Camera camera =
        wish.camera.camera(pixels(scale_, wish.width), pixels(scale_, wish.height));
    if (const Status begun = exact_.begin(scene_->snapshot, camera); !begun) {
      refusedExact_ = begun.error().message;
      return {};
    }
  }
  if (const Status drawn = exact_.step(renderer_, kRefine); !drawn) {
    refusedExact_ = drawn.error().message;
    dropExact();
    return {};
  }
  if (!exact_.complete())
    return {};
  ++version_;
  isExact_ = true;
  const Camera camera = exact_.camera();
  const bool elsewhere = surfaces_.drawKnown(camera, scene_->quads, exact_.texels());
  exact_.drop();
  const Status media = elsewhere ? drawMedia(wish, camera) : Status();
  for (GlPassTime& pass : renderer_.takePasses()) times_.passes.push_back(std::move(pass));
  return media;
}

Status ViewPicture::takeFinished() {
  auto done = processor_->take();
  if (!done || done->number != asked_)
    return {};
  if (!done->picture) {
    if (done->picture.error().code == ErrorCode::kCancelled)
      return {};
    return tl::unexpected<Error>(done->picture.error());
  }
  const auto& [width, height, rgba] = *done->picture;
  if (width != pictureWidth_ || height != pictureHeight_)
    picture_ = makeTexture2d(GL_RGBA32F, width, height);
  pictureWidth_ = width, pictureHeight_ = height;
  glTextureSubImage2D(picture_.name(), 0, 0, 0, width, height, GL_RGBA, GL_FLOAT, rgba.data());
  times_.passes.clear();
  noteTime(done->seconds, width, height, true);
  scale_ = finishedScale_ = done->scale;
  processed_ = true;
  ++version_;
  return {};
}

/// First quickly, then, if nothing changes meanwhile, as fine as it gets. What is fine is given up
/// for what is new; what is quick is finished, or a film would never show a frame.
Status ViewPicture::drawByProcessor(const PictureWish& wish) {
  VOLUTE_TRY(takeFinished());
  const double finest = scaleOf(wish.quality);
  const bool another = changed_ || !sameView(wish, drawn_) || (drawn_.renderer != wish.renderer) ||
                       drawn_.quality != wish.quality;
  if (another) {
    if (processor_->busy() && askedQuickly_)
      return {};
    ++asked_;
    processor_->stopUnless(asked_);
    finishedScale_ = 0;
    askedScale_ = quickScale(wish, kProcessorQuick);
    askedQuickly_ = true;
    drawn_ = wish;
    changed_ = false;
  } else if (finishedScale_ > 0 && finishedScale_ < finest && askedScale_ < finest &&
             !wish.moving) {
    askedScale_ = finest;
    askedQuickly_ = false;
  } else {
    return {};
  }
  const Camera camera =
      wish.camera.camera(pixels(askedScale_, wish.width), pixels(askedScale_, wish.height));
  processor_->request({wish.surfaces || !scene_->bare ? scene_->processor : scene_->bare, camera,
                       asked_, askedScale_});
  return {};
}

Status ViewPicture::update(const PictureWish& wish) {
  if (!scene_)
    return {};
  remark_ = refused_.empty()                     ? ""
            : wish.renderer == ViewRenderer::kGl ? "without the media: " + refused_
                                                 : "by the processor: " + refused_;
  if (remark_.empty() && !refusedExact_.empty())
    remark_ = "surfaces with their light at corners alone: " + refusedExact_;
  if (byProcessor(wish)) {
    dropExact();
    times_.why = whyProcessor(wish);
    const Status drawn =
        makers_.processor
            ? drawByProcessor(wish)
            : fail(ErrorCode::kUnsupported,
                   "the processor would draw this ({}), which VOLUTE_CPU_RENDERER=off forbids",
                   times_.why);
    if (!drawn)
      scene_.reset();
    return drawn;
  }
  const double scale = wish.moving && wish.quality != Quality::kFull ? quickScale(wish, kQuick)
                                                                     : scaleOf(wish.quality);
  const bool same = !changed_ && sameView(wish, drawn_) && scale_ == scale && !processed_;
  const Status drawn = same ? refine(wish) : drawByGl(wish, scale);
  changed_ = false;
  drawn_ = wish;
  if (drawn)
    return {};
  if (scene_->processor) {
    refused_ = drawn.error().message;
    changed_ = true;  // the next frame does without
    return {};
  }
  scene_.reset();
  return drawn;
}

bool ViewPicture::settled(const PictureWish& wish) const {
  if (!scene_)
    return true;
  const double finest = scaleOf(wish.quality);
  const bool same = !changed_ && sameView(wish, drawn_) && scale_ == finest && !wish.moving;
  if (byProcessor(wish))
    return same && processed_ && finishedScale_ == finest && drawn_.renderer == wish.renderer;
  return same && !processed_;
}

bool ViewPicture::exact(const PictureWish& wish) const {
  return isExact_ || !mayBeExact(wish);
}

GLuint ViewPicture::texture() const {
  if (processed_)
    return picture_.name();
  return media_ ? renderer_.texture() : blank_.name();
}

void ViewPicture::show(DisplayLook look, int width, int height) {
  look.surfaces = opaque_ && !processed_ ? surfaces_.texture() : 0;
  display_.draw(texture(), version_, look, width, height);
}

Image ViewPicture::sampledLight(const Rgb& background) const {
  const Texels light = texelsOf(texture());  // one for all pixels where there are no media
  const bool opaque = opaque_ && !processed_ && scene_ && scene_->processor;
  const Texels behind = opaque ? texelsOf(surfaces_.texture()) : Texels{light.width, light.height};
  const double pixels = static_cast<double>(behind.width) * behind.height;
  const int step = std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / kSamples))));
  Image image((behind.width + step - 1) / step, (behind.height + step - 1) / step);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float* before = light.at(std::min(x * step, light.width - 1),  //
                                     std::min(y * step, light.height - 1));
      const float* surface = opaque ? behind.at(x * step, y * step) : nullptr;
      const bool met = surface && surface[3] > 0;
      const float passed = std::exp(met ? -surface[3] * before[3] : -before[3]);
      for (int c = 0; c < 3; ++c) {
        const float sent = met ? surface[c] : static_cast<float>(background[c]);
        image.at(x, y, c) = before[c] + passed * sent;
      }
    }
  }
  return image;
}

}  // namespace volute
