// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "volute/gl/sign_passes.hpp"
#include "volute/gl/surface_passes.hpp"

namespace volute {
namespace {

constexpr float kFarthestDepth = 3e38F;

Status checkInput(const Camera& camera, const RenderOptions& options,
                  std::span<const float> opaqueDepth) {
  const std::size_t pixels = static_cast<std::size_t>(camera.width()) * camera.height();
  if (!opaqueDepth.empty() && opaqueDepth.size() != pixels) {
    return fail(ErrorCode::kInvalidArgument,
                "the opaque depth has {} values for an image of {} x {} pixels", opaqueDepth.size(),
                camera.width(), camera.height());
  }
  if (const Image* behind = options.behind;
      behind && (behind->width != camera.width() || behind->height != camera.height() ||
                 behind->channels != 3)) {
    return fail(ErrorCode::kInvalidArgument,
                "the picture behind has {} x {} x {} values for an image of {} x {} pixels",
                behind->width, behind->height, behind->channels, camera.width(), camera.height());
  }
  return {};
}

Rgb behindPixel(const RenderOptions& options, std::span<const float> opaqueDepth, int x, int y,
                int width) {
  if (const Image* behind = options.behind)
    return {behind->at(x, y, 0), behind->at(x, y, 1), behind->at(x, y, 2)};
  const bool opaque =
      !opaqueDepth.empty() && std::isfinite(opaqueDepth[static_cast<std::size_t>(y) * width + x]);
  return opaque ? Rgb(Rgb::Zero()) : options.background;
}

/// "volume + fog": each once.
std::string mediaNames(const GlScene& scene) {
  std::vector<std::string> names;
  for (const auto& part : scene.parts) {
    if (std::ranges::find(names, part->name()) == names.end())
      names.push_back(part->name());
  }
  return fmt::format("{}", fmt::join(names, " + "));
}

}  // namespace

struct GlRenderer::State {
  GlResources resources;
  GlTexture picture, opaque, passed;
  GlLens lens;
  SurfacePasses surfacePasses;
  SignPasses signPasses;
  int width = 0, height = 0;  ///< of `picture` and `opaque`
  int passedWidth = 0, passedHeight = 0;

  using Media = std::vector<std::unique_ptr<GlMedium>>;
  Result<Media> mediaOf(const GlScene& scene, const Camera& camera, Progress& progress);
  Status resize(const Camera& camera);
  void setOpaque(std::span<const float> opaqueDepth);
  GlRays raysOf(const Camera& camera, std::span<const float> opaqueDepth);
  Status draw(const Camera& camera, const GlScene& scene, const GlTarget& target,
              Progress& progress);
  Result<SurfacePasses::Attenuate> attenuationBy(const GlScene& media, std::span<const Lamp> lamps,
                                                 const Camera& camera, Progress& progress);
};

Result<GlRenderer::State::Media> GlRenderer::State::mediaOf(const GlScene& scene,
                                                            const Camera& camera,
                                                            Progress& progress) {
  const GlPicture made{camera, scene.shade, resources, progress};
  Media media;
  for (const auto& part : scene.parts) {
    VOLUTE_ASSIGN(auto medium, part->medium(made));
    media.push_back(std::move(medium));
  }
  return media;
}

Status GlRenderer::State::resize(const Camera& camera) {
  if (camera.width() == width && camera.height() == height)
    return {};
  VOLUTE_TRY(checkPictureSize(camera, resources.device));
  width = camera.width(), height = camera.height();
  picture = makeTexture2d(GL_RGBA32F, width, height);
  opaque = {};
  return {};
}

void GlRenderer::State::setOpaque(std::span<const float> opaqueDepth) {
  std::vector<float> texels(opaqueDepth.begin(), opaqueDepth.end());
  for (float& depth : texels) depth = depth < kFarthestDepth ? depth : kFarthestDepth;
  if (!opaque)
    opaque = makeTexture2d(GL_R32F, width, height);
  glTextureSubImage2D(opaque.name(), 0, 0, 0, width, height, GL_RED, GL_FLOAT, texels.data());
}

GlRays GlRenderer::State::raysOf(const Camera& camera, std::span<const float> opaqueDepth) {
  GlRays rays;
  if (!opaqueDepth.empty()) {
    setOpaque(opaqueDepth);
    rays.opaque = opaque.name();
  }
  if (!camera.distortion().none()) {
    lens = lensDirections(camera);
    rays.lens = lens.directions.name();
    rays.rest = lens.rest.name();
  }
  return rays;
}

/// What no picture has needed since the last one is dropped, nor surfaces and walls before it.
Status GlRenderer::State::draw(const Camera& camera, const GlScene& scene, const GlTarget& target,
                               Progress& progress) {
  if (scene.parts.size() == 1 && scene.cuts.empty()) {
    const Status alone =
        scene.parts[0]->drawAlone({camera, scene.shade, resources, progress}, target);
    if (alone || alone.error().code != ErrorCode::kUnsupported) {
      resources.store.sweep();
      return alone;
    }
  }
  VOLUTE_ASSIGN(const Media media, mediaOf(scene, camera, progress));
  resources.store.sweep();
  GlTarget cut = target;
  cut.cuts = scene.cuts;
  return march(camera, media, cut, mediaNames(scene), resources, progress);
}

/// The optical depths of media along rays; null where no lamp shines through any.
Result<SurfacePasses::Attenuate> GlRenderer::State::attenuationBy(const GlScene& media,
                                                                  std::span<const Lamp> lamps,
                                                                  const Camera& camera,
                                                                  Progress& progress) {
  VOLUTE_TRY(checkPictureSize(camera, resources.device));
  if (media.parts.empty() || lamps.empty())
    return SurfacePasses::Attenuate();
  VOLUTE_ASSIGN(auto made, mediaOf(media, camera, progress));
  return [this, &camera, &progress, names = mediaNames(media),
          made = std::make_shared<const Media>(std::move(made))](
             const GlRays& rays) -> Result<GLuint> {
    if (passedWidth < camera.width() || passedHeight < camera.height()) {
      passedWidth = camera.width(), passedHeight = camera.height();
      passed = makeTexture2d(GL_RGBA32F, passedWidth, passedHeight);
    }
    VOLUTE_TRY(
        march(camera, *made,
              {.quantity = GlQuantity::kOpticalDepth, .rays = rays, .picture = passed.name()},
              names, resources, progress));
    return passed.name();
  };
}

GlRenderer::GlRenderer(std::unique_ptr<State> state) : state_(std::move(state)) {}

GlRenderer::GlRenderer(GlRenderer&&) noexcept = default;
GlRenderer& GlRenderer::operator=(GlRenderer&&) noexcept = default;
GlRenderer::~GlRenderer() = default;

Result<GlRenderer> GlRenderer::create() {
  auto state = std::make_unique<State>();
  VOLUTE_ASSIGN(state->resources.device, currentGlDevice());
  return GlRenderer(std::move(state));
}

Status GlRenderer::draw(const Camera& camera, const GlScene& scene, GlQuantity quantity,
                        Progress& progress, std::span<const float> opaqueDepth) {
  State& state = *state_;
  VOLUTE_TRY(checkInput(camera, {}, opaqueDepth));
  VOLUTE_TRY(state.resize(camera));
  state.resources.programs.pictureDone();  // the one before
  return state.draw(camera, scene,
                    {.quantity = quantity,
                     .rays = state.raysOf(camera, opaqueDepth),
                     .opaqueDepth = opaqueDepth,
                     .picture = state.picture.name()},
                    progress);
}

Result<SurfacePicture> GlRenderer::surfaces(const Camera& camera, const SurfaceScene& scene,
                                            const GlScene& media, const Rgb& background,
                                            Progress& progress) {
  VOLUTE_ASSIGN(const auto attenuate, state_->attenuationBy(media, scene.lamps, camera, progress));
  return state_->surfacePasses.draw(camera, scene, background, attenuate, state_->resources.passes);
}

Result<SurfacePicture> GlRenderer::walls(const Camera& camera, const GlWalls& walls,
                                         Progress& progress) {
  VOLUTE_ASSIGN(const auto attenuate,
                state_->attenuationBy(walls.media, walls.lamps, camera, progress));
  return state_->surfacePasses.drawWalls(camera, walls, attenuate, state_->resources.passes);
}

Result<std::vector<SignPixel>> GlRenderer::findSigns(const Camera& camera,
                                                     std::span<const Sign> signs,
                                                     std::span<const float> opaqueDepth) {
  VOLUTE_TRY(state_->resize(camera));
  return state_->signPasses.find(camera, signs, opaqueDepth, state_->resources.passes);
}

Result<Image> GlRenderer::signLight(std::span<const float> powers) {
  return state_->signPasses.light(powers, state_->picture.name(), state_->resources.passes);
}

Result<Image> GlRenderer::render(const Camera& camera, const GlScene& scene,
                                 const RenderOptions& options, Progress& progress,
                                 RenderStats* stats, std::span<const float> opaqueDepth) {
  const auto start = std::chrono::steady_clock::now();
  VOLUTE_TRY(checkInput(camera, options, opaqueDepth));
  const bool colors = options.aov == Aov::kNone;
  VOLUTE_TRY(draw(camera, scene, colors ? GlQuantity::kLight : GlQuantity::kOpticalDepth, progress,
                  opaqueDepth));
  Image image(camera.width(), camera.height(), colors ? 3 : 1);
  const std::size_t pixels = static_cast<std::size_t>(image.width) * image.height;
  std::vector<float> texels(4 * pixels);
  state_->resources.passes.run("read back", [&] {
    glGetTextureImage(state_->picture.name(), 0, GL_RGBA, GL_FLOAT,
                      static_cast<GLsizei>(texels.size() * sizeof(float)), texels.data());
  });
  if (const GLenum error = glGetError(); error != GL_NO_ERROR)
    return fail(ErrorCode::kIo, Hint::set("renderer", "cpu"),
                "the graphics device failed with error 0x{:x}", error);
  for (std::size_t i = 0; i < pixels; ++i) {
    const float* texel = &texels[4 * i];
    if (std::isnan(texel[3])) {
      return fail(ErrorCode::kTooLarge, Hint::set("renderer", "cpu"),
                  "the software rasteriser '{}' ends rays before they are through these media",
                  state_->resources.device.renderer);
    }
    if (!colors) {
      image.pixels[i] = options.aov == Aov::kTransmittance ? std::exp(-texel[3]) : texel[3];
      continue;
    }
    const auto x = static_cast<int>(i % image.width), y = static_cast<int>(i / image.width);
    const Rgb behind = behindPixel(options, opaqueDepth, x, y, image.width);
    for (int c = 0; c < 3; ++c)
      image.pixels[3 * i + c] = static_cast<float>(texel[c] + std::exp(-texel[3]) * behind[c]);
  }
  if (stats) {
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - start;
    *stats = {pixels, pixels * scene.parts.size(), 0, elapsed.count()};
  }
  return image;
}

GLuint GlRenderer::texture() const {
  return state_->picture.name();
}

const std::map<std::string, GlCounts>& GlRenderer::counts() const {
  return state_->resources.counts;
}

std::vector<GlPassTime> GlRenderer::takePasses() {
  return state_->resources.passes.take();
}

}  // namespace volute
