// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_renderer.hpp"

#include <chrono>
#include <cmath>
#include <map>

#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_medium.hpp"
#include "volute/gl/smoke_passes.hpp"

namespace volute {
namespace {

constexpr float kFarthest = 3e38F;
constexpr int kGroup = 8;      // pixels a side of a work group
constexpr int kBandRows = 64;  // of one dispatch, between which the caller may stop
constexpr int kOpaqueUnit = 0, kLensUnit = 1;

/// What is on the device as long as pictures need it.
template <class Source, class Made>
class Kept {
 public:
  template <class Make>
  Result<std::shared_ptr<const Made>> get(const std::shared_ptr<const Source>& source,
                                          Make&& make) {
    Entry& entry = entries_[source.get()];
    entry.used = true;
    if (!entry.made) {
      VOLUTE_ASSIGN(entry.made, make());
      entry.source = source;
    }
    return entry.made;
  }

  /// Drops what has not been asked for since the last call.
  void sweep() {
    std::erase_if(entries_, [](const auto& item) { return !item.second.used; });
    for (auto& [source, entry] : entries_) entry.used = false;
  }

 private:
  struct Entry {
    std::shared_ptr<const Source> source;  // so that no other one gets its address
    std::shared_ptr<const Made> made;
    bool used = false;
  };

  std::map<const Source*, Entry> entries_;
};

std::vector<float> lensDirections(const Camera& camera) {
  std::vector<float> texels;
  texels.reserve(4 * static_cast<std::size_t>(camera.width()) * camera.height());
  for (int y = 0; y < camera.height(); ++y) {
    for (int x = 0; x < camera.width(); ++x) {
      const Segment ray = camera.ray(x + 0.5, y + 0.5);
      for (int axis = 0; axis < 3; ++axis)
        texels.push_back(static_cast<float>(ray.direction[axis]));
      texels.push_back(ray.empty() ? 0.0F : 1.0F);
    }
  }
  return texels;
}

/// The step from one row of pixels to the next, which skew turns.
Vec3 rowStep(const Camera& camera) {
  const Vec3 down = camera.down() * camera.pixelSize();
  if (camera.isOrthographic())
    return down;
  const double skew = camera.intrinsics()(0, 1) * camera.pixelSize();
  return down - camera.right() * (skew * camera.pixelWidth());
}

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

/// "volume + fog".
std::string mediaNames(const GlScene& scene) {
  std::string name;
  const auto add = [&](const char* medium, bool there) {
    if (there)
      name += (name.empty() ? "" : " + ") + std::string(medium);
  };
  add("volume", !scene.volumes.empty());
  add("tree", !scene.trees.empty());
  add("fog", !scene.fogs.empty());
  add("smoke", !scene.smokes.empty());
  return name;
}

}  // namespace

struct GlRenderer::State {
  GlDevice device;
  GlPasses passes;
  std::map<std::string, GlProgram> programs;
  Kept<BrickSlice, GlVolumeAtlas> atlases;
  Kept<Tree4d, GlTreeData> trees;
  Kept<TetLocator, GlMesh> meshes;
  GlTexture picture, opaque, lens;
  SmokePasses smokePasses;
  int width = 0, height = 0;

  Result<const GlProgram*> programFor(std::span<const std::unique_ptr<GlMedium>> media,
                                      GlQuantity quantity);
  Result<std::vector<std::unique_ptr<GlMedium>>> mediaOf(const GlScene& scene);
  Status resize(const Camera& camera);
  void bindCamera(const GlProgram& program, const Camera& camera,
                  std::span<const float> opaqueDepth);
  void setOpaque(std::span<const float> opaqueDepth);
  Status dispatch(const GlProgram& program, const std::string& media, Progress& progress);
  Status march(const Camera& camera, const GlScene& scene, GlQuantity quantity, Progress& progress,
               std::span<const float> opaqueDepth);
};

Result<const GlProgram*> GlRenderer::State::programFor(
    std::span<const std::unique_ptr<GlMedium>> media, GlQuantity quantity) {
  std::string key = sceneShaderKey(media, quantity);
  const auto found = programs.find(key);
  if (found != programs.end())
    return &found->second;
  const ShaderStage stage{GL_COMPUTE_SHADER, sceneShader(media, quantity)};
  VOLUTE_ASSIGN(auto program, GlProgram::link({&stage, 1}));
  return &programs.emplace(std::move(key), std::move(program)).first->second;
}

Result<std::vector<std::unique_ptr<GlMedium>>> GlRenderer::State::mediaOf(const GlScene& scene) {
  std::vector<std::unique_ptr<GlMedium>> media;
  for (const GlVolume& volume : scene.volumes) {
    VOLUTE_ASSIGN(auto atlas,
                  atlases.get(volume.slice, [&] { return makeVolumeAtlas(*volume.slice); }));
    media.push_back(makeGlVolume(volume, std::move(atlas)));
  }
  for (const GlTreeVolume& volume : scene.trees) {
    VOLUTE_ASSIGN(auto tree, trees.get(volume.tree, [&] { return makeTreeData(*volume.tree); }));
    VOLUTE_ASSIGN(auto medium, makeGlTreeVolume(volume, std::move(tree), device.hardware));
    media.push_back(std::move(medium));
  }
  for (const FogMedium& fog : scene.fogs) {
    VOLUTE_ASSIGN(auto medium, makeGlFog(fog));
    media.push_back(std::move(medium));
  }
  for (const GlSmoke& smoke : scene.smokes) {
    VOLUTE_ASSIGN(auto mesh,
                  meshes.get(smoke.locator, [&] { return makeGlMesh(smoke.locator->mesh()); }));
    media.push_back(makeGlSmoke(smoke, std::move(mesh)));
  }
  meshes.sweep();
  atlases.sweep();
  trees.sweep();
  return media;
}

Status GlRenderer::State::resize(const Camera& camera) {
  if (camera.width() == width && camera.height() == height)
    return {};
  if (camera.width() > device.largestTexture || camera.height() > device.largestTexture) {
    return fail(ErrorCode::kTooLarge,
                "a picture of {} x {} pixels is larger than the {} a side that the graphics device "
                "has; use --renderer cpu",
                camera.width(), camera.height(), device.largestTexture);
  }
  width = camera.width(), height = camera.height();
  picture = makeTexture2d(GL_RGBA32F, width, height);
  opaque = {};
  return {};
}

void GlRenderer::State::bindCamera(const GlProgram& program, const Camera& camera,
                                   std::span<const float> opaqueDepth) {
  program.set("size", std::array{width, height});
  program.set("forward", camera.forward());
  program.set("right", Vec3(camera.right() * camera.pixelWidth()));
  program.set("down", rowStep(camera));
  program.set("principal", std::array{static_cast<float>(camera.principalPoint().x()),
                                      static_cast<float>(camera.principalPoint().y())});
  program.set("orthographic", camera.isOrthographic() ? 1 : 0);
  program.set("opaque", kOpaqueUnit);
  program.set("lens", kLensUnit);
  program.set("opaqueGiven", opaqueDepth.empty() ? 0 : 1);
  program.set("lensGiven", camera.distortion().none() ? 0 : 1);
  if (!opaqueDepth.empty())
    glBindTextureUnit(kOpaqueUnit, opaque.name());
  if (!camera.distortion().none()) {
    lens = makeTexture2d(GL_RGBA32F, width, height);
    const std::vector<float> texels = lensDirections(camera);
    glTextureSubImage2D(lens.name(), 0, 0, 0, width, height, GL_RGBA, GL_FLOAT, texels.data());
    glBindTextureUnit(kLensUnit, lens.name());
  }
}

void GlRenderer::State::setOpaque(std::span<const float> opaqueDepth) {
  std::vector<float> texels(opaqueDepth.begin(), opaqueDepth.end());
  for (float& depth : texels) depth = depth < kFarthest ? depth : kFarthest;
  if (!opaque)
    opaque = makeTexture2d(GL_R32F, width, height);
  glTextureSubImage2D(opaque.name(), 0, 0, 0, width, height, GL_RED, GL_FLOAT, texels.data());
}

Status GlRenderer::State::dispatch(const GlProgram& program, const std::string& media,
                                   Progress& progress) {
  program.use();
  glBindImageTexture(0, picture.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  for (int row = 0; row < height; row += kBandRows) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: {} of {} rows were rendered", row, height);
    program.set("firstRow", row);
    const int rows = std::min(kBandRows, height - row);
    passes.run("march", media, [&] {
      glDispatchCompute(static_cast<GLuint>((width + kGroup - 1) / kGroup),
                        static_cast<GLuint>((rows + kGroup - 1) / kGroup), 1);
    });
    glFlush();
    progress.report("rendering", row + rows, height);
  }
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  return {};
}

GlRenderer::GlRenderer(std::unique_ptr<State> state) : state_(std::move(state)) {}

GlRenderer::GlRenderer(GlRenderer&&) noexcept = default;
GlRenderer& GlRenderer::operator=(GlRenderer&&) noexcept = default;
GlRenderer::~GlRenderer() = default;

Result<GlRenderer> GlRenderer::create() {
  auto state = std::make_unique<State>();
  VOLUTE_ASSIGN(state->device, currentGlDevice());
  return GlRenderer(std::move(state));
}

Status GlRenderer::State::march(const Camera& camera, const GlScene& scene, GlQuantity quantity,
                                Progress& progress, std::span<const float> opaqueDepth) {
  std::vector<std::unique_ptr<GlMedium>> media;
  Status uploaded;
  passes.run("upload", mediaNames(scene), [&] {
    auto made = mediaOf(scene);
    if (made)
      media = std::move(*made);
    else
      uploaded = tl::unexpected(std::move(made).error());
  });
  VOLUTE_TRY(std::move(uploaded));
  VOLUTE_ASSIGN(const GlProgram* program, programFor(media, quantity));
  bindCamera(*program, camera, opaqueDepth);
  GlBindings bindings;
  for (std::size_t i = 0; i < media.size(); ++i)
    media[i]->bind(*program, mediumPrefix(i), camera.eye(), !camera.isOrthographic(), bindings);
  return dispatch(*program, mediaNames(scene), progress);
}

Status GlRenderer::draw(const Camera& camera, const GlScene& scene, GlQuantity quantity,
                        Progress& progress, std::span<const float> opaqueDepth) {
  VOLUTE_TRY(checkInput(camera, {}, opaqueDepth));
  VOLUTE_TRY(state_->resize(camera));
  if (!opaqueDepth.empty())
    state_->setOpaque(opaqueDepth);
  const GlSmokeMethod method = smokeMethod(scene, camera, quantity);
  if (method == GlSmokeMethod::kMarch)
    return state_->march(camera, scene, quantity, progress, opaqueDepth);
  return state_->smokePasses.draw(camera, scene.smokes[0], method, opaqueDepth,
                                  state_->opaque.name(), state_->picture.name(), state_->passes);
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
  state_->passes.run("read back", [&] {
    glGetTextureImage(state_->picture.name(), 0, GL_RGBA, GL_FLOAT,
                      static_cast<GLsizei>(texels.size() * sizeof(float)), texels.data());
  });
  if (const GLenum error = glGetError(); error != GL_NO_ERROR)
    return fail(ErrorCode::kIo, "the graphics device failed with error 0x{:x}; try --renderer cpu",
                error);
  for (std::size_t i = 0; i < pixels; ++i) {
    const float* texel = &texels[4 * i];
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
    *stats = {pixels, pixels * scene.media(), 0, elapsed.count()};
  }
  return image;
}

GLuint GlRenderer::texture() const {
  return state_->picture.name();
}

std::vector<GlPassTime> GlRenderer::takePasses() {
  return state_->passes.take();
}

}  // namespace volute
