// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/view_picture.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace volute {
namespace {

constexpr double kQuick = 0.04;        ///< [s] that OpenGL may take while something moves
constexpr double kRefine = 0.012;      ///< [s] of an update that surfaces get, about
constexpr double kCoarsest = 1.0 / 8;  ///< of the window's pixels a side
/// That the CPU's quick pictures may have, of the window's pixels a side.
constexpr double kScales[] = {1, 0.75, 0.5, 0.375, 0.25, 0.1875, 0.125, 0.0625};
constexpr double kUnknown = 1.0 / 8;  ///< where nobody knows what pixels cost
constexpr double kPoor = 0.3;         ///< below that a preview says more
constexpr double kCoarse = 0.375;     ///< below that a picture may take
constexpr double kSlowest = 0.1;      ///< [s], whatever the budget is
constexpr std::size_t kHistory = 90;
constexpr double kLightSamples = 65536;  ///< of the light that is shown

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

bool sameView(const PictureRequest& a, const PictureRequest& b) {
  return a.camera == b.camera && a.width == b.width && a.height == b.height &&
         a.surfaces == b.surfaces;
}

}  // namespace

ViewPicture::ViewPicture(GlRenderer renderer, SurfaceDrawer surfaces, Display display)
    : renderer_(std::move(renderer)),
      surfaces_(std::move(surfaces)),
      display_(std::move(display)),
      cpu_(std::make_unique<CpuThread>()) {
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

bool ViewPicture::byCpu(const PictureRequest& request) const {
  if (!scene_->cpu || makesOnlyGl(request.renderer))
    return false;
  return request.renderer == ViewRenderer::kCpu || !makers_.hardware || !refused_.empty();
}

std::string ViewPicture::whyCpu(const PictureRequest& request) const {
  return request.renderer == ViewRenderer::kCpu ? "as you chose"
         : !makers_.hardware                    ? "there is no graphics card"
                                                : refused_;
}

double ViewPicture::quickScale(const PictureRequest& request, double seconds) const {
  const double count = static_cast<double>(request.width) * request.height;
  const double cost = glSecondsAPixel_ * count;
  return std::clamp(std::sqrt(seconds / cost), kCoarsest, scaleOf(request.quality));
}

void ViewPicture::noteTime(double seconds, int width, int height, bool cpu) {
  times_.milliseconds = 1e3 * seconds;
  times_.width = width, times_.height = height;
  times_.cpu = cpu;
  times_.history.push_back(static_cast<float>(times_.milliseconds));
  if (times_.history.size() > kHistory)
    times_.history.erase(times_.history.begin());
  if (!cpu)
    glSecondsAPixel_ = seconds / (static_cast<double>(width) * height);
}

/// What is refused once is not tried again before the scene changes.
Status ViewPicture::drawMedia(const PictureRequest& request, const Camera& camera) {
  media_ = false;
  if (!scene_->notByGl.empty() && !makesOnlyGl(request.renderer))
    return fail(ErrorCode::kUnsupported, "{}", scene_->notByGl);
  if (scene_->media.parts.empty() || (makesOnlyGl(request.renderer) && !refused_.empty()))
    return {};
  const auto depth = opaque_ ? surfaces_.depth() : std::span<const float>();
  Progress quiet;
  const Status drawn = renderer_.draw(camera, scene_->media, GlQuantity::kLight, quiet, depth);
  media_ = drawn.has_value();
  return drawn;
}

Status ViewPicture::drawByGl(const PictureRequest& request, double scale) {
  const int width = pixels(scale, request.width), height = pixels(scale, request.height);
  const Camera camera = request.camera.camera(width, height);
  dropExact();
  isExact_ = false;
  const auto begun = std::chrono::steady_clock::now();
  ++version_;
  opaque_ = surfaces_.draw(camera, scene_->surfaces, scene_->quads, request.surfaces);
  const std::chrono::duration<double> rasterised = std::chrono::steady_clock::now() - begun;
  VOLUTE_TRY(drawMedia(request, camera));
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begun;
  double onDevice = 0;
  times_.passes = renderer_.takePasses();
  drawnAt_ = std::chrono::steady_clock::now();
  if (opaque_)  // until their depths were read back
    times_.passes.push_back({"rasterise", "opaque things", 1, 1e3 * rasterised.count()});
  for (const GlPassTime& pass : times_.passes) onDevice += 1e-3 * pass.milliseconds;
  // A rasteriser on the CPU has computed before its clock looks.
  noteTime(makers_.hardware && onDevice > 0 ? onDevice : spent.count(), width, height, false);
  scale_ = scale;
  shownTime_ = scene_->time;
  fromCpu_ = false;
  return {};
}

bool ViewPicture::mayBeExact(const PictureRequest& request) const {
  return scene_ && scene_->snapshot && request.surfaces && !request.moving &&
         refusedExact_.empty() && !byCpu(request);
}

void ViewPicture::dropExact() {
  if (!exact_.begun())
    return;
  exact_.drop();
  renderer_.takePasses();  // they are no picture's
}

/// Some tiles of the exact surfaces. Once all are there they are shown; the media before them are
/// drawn again only if surfaces were elsewhere. What is refused stays as it is.
Status ViewPicture::refine(const PictureRequest& request) {
  const std::chrono::duration<double> rested = std::chrono::steady_clock::now() - drawnAt_;
  if (isExact_ || !mayBeExact(request) || !(rested.count() >= request.exactAfter))
    return {};
  if (!exact_.begun()) {
    const Camera camera =
        request.camera.camera(pixels(scale_, request.width), pixels(scale_, request.height));
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
  const Status media = elsewhere ? drawMedia(request, camera) : Status();
  for (GlPassTime& pass : renderer_.takePasses()) times_.passes.push_back(std::move(pass));
  return media;
}

/// Into the texture that is shown; a part of a picture fits into what the one before it left there.
void ViewPicture::show(const CpuPart& part) {
  const bool whole = part.partWidth == part.width && part.partHeight == part.height;
  if (!whole && (part.width != pictureWidth_ || part.height != pictureHeight_))
    return;
  if (part.width != pictureWidth_ || part.height != pictureHeight_)
    picture_ = makeTexture2d(GL_RGBA32F, part.width, part.height);
  pictureWidth_ = part.width, pictureHeight_ = part.height;
  glTextureSubImage2D(picture_.name(), 0, part.left, part.top, part.partWidth, part.partHeight,
                      GL_RGBA, GL_FLOAT, part.rgba.data());
  scale_ = part.scale;
  shownNumber_ = part.number;
  shownTime_ = part.time;
  shownFinest_ = part.complete && !part.preview && part.scale >= scaleOf(drawn_.quality);
  shownPreview_ = part.preview;
  fromCpu_ = true;
  ++version_;
  if (!part.complete)
    return;
  times_.passes.clear();
  noteTime(part.seconds, part.width, part.height, true);
  const double cost = part.seconds / (static_cast<double>(part.width) * part.height);
  double& known = part.preview ? previewSecondsAPixel_ : cpuSecondsAPixel_;
  known = known > 0 ? 0.5 * (known + cost) : cost;
}

Status ViewPicture::takeFinished() {
  for (const auto& part : cpu_->take()) {
    if (!part)
      return tl::unexpected<Error>(part.error());
    if (part->number >= shownNumber_)
      show(*part);
  }
  return {};
}

void ViewPicture::forgetCosts() {
  cpuSecondsAPixel_ = previewSecondsAPixel_ = 0;
}

void ViewPicture::stopRefining() {
  cpu_->stop();
  stopped_ = true;
}

/// Of the first picture, so that it is there within the request's budget. Scales are few, and the
/// last one stays while it nearly serves: a film whose pictures change size all the time flickers.
double ViewPicture::cpuScale(const PictureRequest& request, bool& preview) const {
  const double finest = scaleOf(request.quality);
  preview = false;
  if (request.single)
    return finest;
  const double count = static_cast<double>(request.width) * request.height;
  const auto affordable = [&](double cost) {
    if (cost <= 0)
      return kUnknown;
    // Rather fewer pictures than such that hardly show anything.
    const double slow = std::min(std::sqrt(kSlowest / (cost * count)), kCoarse);
    const double exact = std::max(std::sqrt(request.budget / (cost * count)), slow);
    const bool serves = scale_ <= 1.15 * exact && scale_ >= 0.6 * exact;
    if (fromCpu_ && serves && std::ranges::find(kScales, scale_) != std::end(kScales))
      return scale_;
    const auto fits = std::ranges::find_if(kScales, [&](double scale) { return scale <= exact; });
    return fits == std::end(kScales) ? kScales[std::size(kScales) - 1] : *fits;
  };
  double scale = affordable(cpuSecondsAPixel_);
  const bool surfaces = request.surfaces || !scene_->bare;
  if (surfaces && scene_->preview && (cpuSecondsAPixel_ <= 0 || scale < kPoor)) {
    preview = true;
    scale = affordable(previewSecondsAPixel_);
  }
  return std::min(scale, finest);
}

void ViewPicture::askCpu(const PictureRequest& request, double first, double finest, bool preview) {
  const bool surfaces = request.surfaces || !scene_->bare;
  cpu_->request({.take = surfaces ? scene_->cpu : scene_->bare,
                 .preview = surfaces ? scene_->preview : CpuPicture(),
                 .camera = request.camera,
                 .width = request.width,
                 .height = request.height,
                 .first = first,
                 .finest = finest,
                 .refines = !request.moving,
                 .newCosts = cpuSecondsAPixel_ <= 0 && previewSecondsAPixel_ <= 0,
                 .previewFirst = preview,
                 .inTiles = scene_->inTiles,
                 .continues = shownNumber_ == asked_ && fromCpu_,
                 .number = asked_,
                 .time = scene_->time});
  asksForAll_ = !request.moving;
}

/// First quickly, then, if nothing changes meanwhile, as fine as it gets. What is fine is given up
/// for what is new; what is quick is finished, or a film would never show a frame.
Status ViewPicture::drawByCpu(const PictureRequest& request) {
  VOLUTE_TRY(takeFinished());
  const double finest = scaleOf(request.quality);
  const bool another = changed_ || !sameView(request, drawn_) ||
                       drawn_.renderer != request.renderer || drawn_.quality != request.quality;
  if (another) {
    ++asked_;
    stopped_ = false;
    bool preview = false;
    const double first = cpuScale(request, preview);
    askCpu(request, first, finest, preview);
    drawn_ = request;
    changed_ = false;
  } else if (!request.moving && !stopped_ && !asksForAll_ && shownNumber_ == asked_) {
    const double next =
        shownPreview_ ? scale_ : std::min(2 * scale_, finest);  // it has come to rest
    askCpu(request, next, finest, false);
  }
  return {};
}

Status ViewPicture::update(const PictureRequest& request) {
  if (!scene_)
    return {};
  remark_ = refused_.empty()                ? ""
            : makesOnlyGl(request.renderer) ? "without the media: " + refused_
                                            : "by the CPU: " + refused_;
  if (remark_.empty() && !refusedExact_.empty())
    remark_ = "surfaces lit only at corners: " + refusedExact_;
  if (byCpu(request)) {
    dropExact();
    times_.why = whyCpu(request);
    const Status drawn =
        makers_.cpu
            ? drawByCpu(request)
            : fail(ErrorCode::kUnsupported,
                   "the CPU would have to draw this ({}), but VOLUTE_CPU_RENDERER=off", times_.why);
    if (!drawn)
      scene_.reset();
    return drawn;
  }
  const double scale = request.moving && request.quality != Quality::kFull
                           ? quickScale(request, kQuick)
                           : scaleOf(request.quality);
  const bool same = !changed_ && sameView(request, drawn_) && scale_ == scale && !fromCpu_;
  const Status drawn = same ? refine(request) : drawByGl(request, scale);
  changed_ = false;
  drawn_ = request;
  if (drawn)
    return {};
  if (scene_->cpu) {
    refused_ = drawn.error().message;
    changed_ = true;  // the next frame does without
    return {};
  }
  scene_.reset();
  return drawn;
}

bool ViewPicture::settled(const PictureRequest& request) const {
  if (!scene_)
    return true;
  const double finest = scaleOf(request.quality);
  const bool sameScale = scale_ == finest || (stopped_ && byCpu(request));
  const bool same = !changed_ && sameView(request, drawn_) && sameScale && !request.moving;
  if (byCpu(request))
    return same && fromCpu_ && shownNumber_ == asked_ && (shownFinest_ || stopped_) &&
           drawn_.renderer == request.renderer;
  return same && !fromCpu_;
}

bool ViewPicture::exact(const PictureRequest& request) const {
  return isExact_ || !mayBeExact(request);
}

GLuint ViewPicture::texture() const {
  if (fromCpu_)
    return picture_.name();
  return media_ ? renderer_.texture() : blank_.name();
}

void ViewPicture::show(DisplayLook look, int width, int height) {
  look.surfaces = opaque_ && !fromCpu_ ? surfaces_.texture() : 0;
  const DisplaySize window{width, height};
  DisplaySize own = window;
  if (drawn_.moving)
    own = fromCpu_ ? DisplaySize{pictureWidth_, pictureHeight_}
                   : DisplaySize{pixels(scale_, drawn_.width), pixels(scale_, drawn_.height)};
  const bool smaller = own.width <= width && own.height <= height;
  display_.draw(texture(), version_, look, smaller ? own : window, window);
}

DisplayLook::Other ViewPicture::shownLight() const {
  return {texture(), opaque_ && !fromCpu_ ? surfaces_.texture() : 0, version_};
}

Image ViewPicture::sampledLight(const Rgb& background) const {
  const Texels light = texelsOf(texture());  // one for all pixels where there are no media
  const bool opaque = opaque_ && !fromCpu_ && scene_ && scene_->cpu;
  const Texels behind = opaque ? texelsOf(surfaces_.texture()) : Texels{light.width, light.height};
  const double pixels = static_cast<double>(behind.width) * behind.height;
  const int step = std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / kLightSamples))));
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
