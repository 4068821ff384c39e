// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_renderer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "volute/gl/fog_passes.hpp"
#include "volute/gl/gl_billboard.hpp"
#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_medium.hpp"
#include "volute/gl/gl_programs.hpp"
#include "volute/gl/gl_rays.hpp"
#include "volute/gl/sign_passes.hpp"
#include "volute/gl/smoke_passes.hpp"
#include "volute/gl/surface_passes.hpp"

namespace volute {
namespace {

constexpr float kFarthestDepth = 3e38F;

/// What is on the device as long as pictures need it.
template <class Source, class Made>
class Kept {
 public:
  template <class Make>
  Result<std::shared_ptr<const Made>> get(const std::shared_ptr<const Source>& source,
                                          Make&& make) {
    return get(source, make, [](const Made&) { return true; });
  }

  /// @param holds  whether what was made is still of what the source is now
  template <class Make, class Holds>
  Result<std::shared_ptr<const Made>> get(const std::shared_ptr<const Source>& source, Make&& make,
                                          Holds&& holds) {
    Entry& entry = entries_[source.get()];
    entry.used = true;
    if (!entry.made || !holds(*entry.made)) {
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

/// VoxelMedium::bounds(): between voxels there is something half a voxel further out.
Box3 boundsOf(const BrickSlice& slice) {
  Box3 bounds = slice.bounds();
  if (slice.basis() == Basis::kBox)
    return bounds;
  const Vec3 half = 0.5 * bounds.size().cwiseQuotient(Vec3(slice.x(), slice.y(), slice.z()));
  bounds.min -= half, bounds.max += half;
  return bounds;
}

GlView viewOf(const Camera& camera, std::span<const std::unique_ptr<GlMedium>> media,
              const GlRays& rays) {
  if (rays.origins != 0)
    return {rays.from, std::nullopt};
  std::vector<Box3> bounds;
  for (const auto& medium : media) bounds.push_back(medium->bounds());
  GlView view{pictureOrigin(camera, bounds), std::nullopt};
  if (!camera.isOrthographic())
    view.eye = camera.eye();
  return view;
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
  add("fog", !scene.fogs.empty() || !scene.sunlitFogs.empty());
  add("smoke", !scene.smokes.empty());
  add("FDS smoke", std::ranges::any_of(scene.fds, [](const GlFds& fds) { return !fds.glow; }));
  add("fire",
      std::ranges::any_of(scene.fds, [](const GlFds& fds) { return fds.glow.has_value(); }));
  add("billboard", !scene.billboards.empty());
  return name;
}

}  // namespace

struct GlRenderer::State {
  GlDevice device;
  GlPasses passes;
  GlPrograms programs;
  Kept<BrickSlice, GlVolumeAtlas> atlases;
  Kept<Tree4d, GlTreeData> trees;
  Kept<TetLocator, GlMesh> meshes;
  Kept<TetLocator, GlSmokeFields> smokeFields;
  Kept<FogLevels, GlFogMap> fogMaps;
  Kept<FdsValues, GlFdsData> fdsData;
  GlTexture picture, opaque, passed;
  GlLens lens;
  SmokePasses smokePasses;
  FogPasses fogPasses;
  BillboardPass billboardPass;
  SurfacePasses surfacePasses;
  SignPasses signPasses;
  int width = 0, height = 0;  ///< of `picture` and `opaque`
  int passedWidth = 0, passedHeight = 0;

  /// The last surfaces in a sun's light.
  struct {
    TriangleScene scene;
    std::shared_ptr<const GlTriangles> triangles;
  } shade;

  Status prepareShade(const TriangleScene& scene);
  /// Drops what no picture has needed since the last call, nor surfaces and walls before it.
  void sweep();
  using Media = std::vector<std::unique_ptr<GlMedium>>;
  Result<Media> mediaOf(const GlScene& scene, const Camera& camera, Progress& progress);
  Result<std::shared_ptr<const GlFogMap>> mapOf(const FogMedium& fog);
  Result<std::unique_ptr<GlMedium>> mediumOf(const GlVolume& volume);
  Result<std::unique_ptr<GlMedium>> mediumOf(const GlFds& fds);
  Result<std::unique_ptr<GlMedium>> mediumOf(const GlBillboard& board, const Camera& camera,
                                             Progress& progress);
  bool mayWalk(const FogMedium& fog) const;
  Status checkNeeds(std::span<const std::unique_ptr<GlMedium>> media) const;
  Status checkSize(const Camera& camera) const;
  Status resize(const Camera& camera);
  void setOpaque(std::span<const float> opaqueDepth);
  GlRays raysOf(const Camera& camera, std::span<const float> opaqueDepth);
  /// Rays from the eye and no others may begin inside of a mesh.
  Status march(const Camera& camera, std::span<const std::unique_ptr<GlMedium>> media,
               GlQuantity quantity, const GlRays& rays, const GlTexture& target,
               const std::string& names, Progress& progress);
  /// A texture with the optical depths of media along rays in its fourth channel.
  Result<GLuint> depthOf(const Camera& camera, const GlScene& scene, const Media& media,
                         const GlRays& rays, Progress& progress);
  Status drawAlone(const Camera& camera, const GlScene& scene, GlQuantity quantity,
                   std::span<const float> opaqueDepth, const GlRays& rays, Progress& progress);
};

/// FogMedium does not give its levels away, but a copy holds them.
Result<std::shared_ptr<const GlFogMap>> GlRenderer::State::mapOf(const FogMedium& fog) {
  const auto held = std::make_shared<const FogMedium>(fog);
  return fogMaps.get({held, &held->levels()}, [&] {
    return passes.run("upload", "fog", [&] { return makeGlFogMap(fog); });
  });
}

Status GlRenderer::State::prepareShade(const TriangleScene& scene) {
  if (scene.empty()) {
    shade = {};
    return {};
  }
  if (shade.triangles && shade.scene.triangles().data() == scene.triangles().data())
    return {};
  VOLUTE_ASSIGN(auto made, GlTriangles::make(scene.triangles()));
  shade = {scene, std::make_shared<const GlTriangles>(std::move(made))};
  return {};
}

Result<std::unique_ptr<GlMedium>> GlRenderer::State::mediumOf(const GlVolume& volume) {
  VOLUTE_ASSIGN(auto atlas, atlases.get(volume.slice, [&] {
    return passes.run("upload", "volume", [&] { return makeVolumeAtlas(*volume.slice); });
  }));
  return makeGlVolume(volume, std::move(atlas));
}

Result<std::unique_ptr<GlMedium>> GlRenderer::State::mediumOf(const GlFds& fds) {
  const auto held = std::make_shared<const FdsField>(fds.field);
  VOLUTE_ASSIGN(auto data, fdsData.get(
                               {held, &held->values(0)},
                               [&] {
                                 return passes.run("upload", fds.glow ? "fire" : "FDS smoke",
                                                   [&] { return makeGlFdsData(fds); });
                               },
                               [&](const GlFdsData& made) { return holds(made, fds); }));
  return makeGlFds(fds, std::move(data));
}

Result<std::unique_ptr<GlMedium>> GlRenderer::State::mediumOf(const GlBillboard& board,
                                                              const Camera& camera,
                                                              Progress& progress) {
  const BillboardOptions& options = board.options;
  if (!(options.width > 0) || !(options.height > 0) || options.rows < 1) {
    return fail(ErrorCode::kInvalidArgument,
                "a billboard of {} x {} m with {} rows; expected a size of more than 0",
                options.width, options.height, options.rows);
  }
  Media shown;
  VOLUTE_ASSIGN(auto medium, mediumOf(board.volume));
  shown.push_back(std::move(medium));
  const Camera view = billboardView(boundsOf(*board.volume.slice), camera, options);
  VOLUTE_TRY(checkSize(view));
  const GlTexture drawn = makeTexture2d(GL_RGBA32F, view.width(), view.height());
  VOLUTE_TRY(march(view, shown, GlQuantity::kLight, {}, drawn, "billboard", progress));
  return billboardPass.make(options, view, drawn.name(), passes);
}

Result<GlRenderer::State::Media> GlRenderer::State::mediaOf(const GlScene& scene,
                                                            const Camera& camera,
                                                            Progress& progress) {
  Media media;
  for (const GlVolume& volume : scene.volumes) {
    VOLUTE_ASSIGN(auto medium, mediumOf(volume));
    media.push_back(std::move(medium));
  }
  for (const GlTreeVolume& volume : scene.trees) {
    VOLUTE_ASSIGN(auto tree, trees.get(volume.tree, [&] {
      return passes.run("upload", "tree", [&] { return makeTreeData(*volume.tree); });
    }));
    media.push_back(makeGlTreeVolume(volume, std::move(tree)));
  }
  for (const FogMedium& fog : scene.fogs) {
    VOLUTE_ASSIGN(auto map, mapOf(fog));
    media.push_back(makeGlFog(fog, scene.fogFactor, std::move(map)));
  }
  if (!scene.sunlitFogs.empty())
    VOLUTE_TRY(prepareShade(scene.shade));
  for (const SunlitFog& fog : scene.sunlitFogs) {
    VOLUTE_ASSIGN(auto map, mapOf(fog.fog()));
    VOLUTE_ASSIGN(auto medium, passes.run("upload", "fog", [&] {
      return makeGlFog(fog, scene.fogFactor, std::move(map), shade.triangles);
    }));
    media.push_back(std::move(medium));
  }
  for (const GlSmoke& smoke : scene.smokes) {
    VOLUTE_ASSIGN(auto mesh, meshes.get(smoke.locator, [&] {
      return passes.run("upload", "smoke", [&] { return makeGlMesh(smoke.locator->mesh()); });
    }));
    VOLUTE_ASSIGN(auto fields, smokeFields.get(
                                   smoke.locator,
                                   [&]() -> Result<std::shared_ptr<const GlSmokeFields>> {
                                     return passes.run("upload", "smoke",
                                                       [&] { return makeGlSmokeFields(smoke); });
                                   },
                                   [&](const GlSmokeFields& made) { return holds(made, smoke); }));
    media.push_back(makeGlSmoke(smoke, std::move(mesh), std::move(fields)));
  }
  for (const GlFds& fds : scene.fds) {
    VOLUTE_ASSIGN(auto medium, mediumOf(fds));
    media.push_back(std::move(medium));
  }
  for (const GlBillboard& board : scene.billboards) {
    VOLUTE_ASSIGN(auto medium, mediumOf(board, camera, progress));
    media.push_back(std::move(medium));
  }
  return media;
}

void GlRenderer::State::sweep() {
  meshes.sweep();
  atlases.sweep();
  trees.sweep();
  smokeFields.sweep();
  fogMaps.sweep();
  fdsData.sweep();
  fogPasses.sweep();
}

bool GlRenderer::State::mayWalk(const FogMedium& fog) const {
  const GlNeeds needs = fogNeeds(fogCells(fog));
  return needs.cells * needs.roundsPerCell <= device.loopRounds();
}

/// Beforehand, since drivers' own words are of no help, and one of them draws a wrong picture.
Status GlRenderer::State::checkNeeds(std::span<const std::unique_ptr<GlMedium>> media) const {
  constexpr std::int64_t kRayTextures = GlBindings{}.texture;
  constexpr double kRoundsOfMixtures = 6;
  GlNeeds all;
  double rounds = 0;
  for (const auto& medium : media) {
    const GlNeeds needs = medium->needs();
    all.textures += needs.textures;
    all.storage += needs.storage;
    all.cells += needs.cells;
    rounds += needs.cells * (needs.roundsPerCell + (media.size() > 1 ? kRoundsOfMixtures : 0));
  }
  if (kRayTextures + all.textures > device.textureUnits || all.storage > device.storageBindings) {
    return fail(
        ErrorCode::kTooLarge,
        "{} media need {} textures and {} buffers at a time, the graphics device has {} and "
        "{}; render fewer, or with --renderer cpu",
        media.size(), kRayTextures + all.textures, all.storage, device.textureUnits,
        device.storageBindings);
  }
  if (rounds > device.loopRounds()) {
    return fail(
        ErrorCode::kTooLarge,
        "rays pass up to {:.0f} cells of these media, more than the software rasteriser '{}' "
        "can go through; render with --renderer cpu",
        all.cells, device.renderer);
  }
  return {};
}

Status GlRenderer::State::checkSize(const Camera& camera) const {
  if (camera.width() <= device.largestTexture && camera.height() <= device.largestTexture)
    return {};
  return fail(ErrorCode::kTooLarge,
              "a picture of {} x {} pixels is larger than the {} a side that the graphics device "
              "has; use --renderer cpu",
              camera.width(), camera.height(), device.largestTexture);
}

Status GlRenderer::State::resize(const Camera& camera) {
  if (camera.width() == width && camera.height() == height)
    return {};
  VOLUTE_TRY(checkSize(camera));
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

Status GlRenderer::State::march(const Camera& camera,
                                std::span<const std::unique_ptr<GlMedium>> media,
                                GlQuantity quantity, const GlRays& rays, const GlTexture& target,
                                const std::string& names, Progress& progress) {
  VOLUTE_TRY(checkNeeds(media));
  VOLUTE_ASSIGN(const GlProgram* program,
                programs.get(sceneShaderKey(media, quantity), names, passes,
                             [&] { return sceneShader(media, quantity); }));
  const GlView view = viewOf(camera, media, rays);
  bindRays(*program, camera, view.origin, rays);
  program->set("marchColor", Vec3(marchColor(media)));
  GlBindings bindings;
  for (std::size_t i = 0; i < media.size(); ++i)
    media[i]->bind(*program, mediumPrefix(i), view, bindings);
  glBindImageTexture(0, target.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  return passes.run("march", names, [&] {
    return runInBands(*program, camera, device.rowsAtOnce(camera.width()), progress);
  });
}

Result<GLuint> GlRenderer::State::depthOf(const Camera& camera, const GlScene& scene,
                                          const Media& media, const GlRays& rays,
                                          Progress& progress) {
  if (passedWidth < camera.width() || passedHeight < camera.height()) {
    passedWidth = camera.width(), passedHeight = camera.height();
    passed = makeTexture2d(GL_RGBA32F, passedWidth, passedHeight);
  }
  VOLUTE_TRY(
      march(camera, media, GlQuantity::kOpticalDepth, rays, passed, mediaNames(scene), progress));
  return passed.name();
}

/// What is alone in its picture and has a way of its own; kUnsupported where that does not serve.
Status GlRenderer::State::drawAlone(const Camera& camera, const GlScene& scene, GlQuantity quantity,
                                    std::span<const float> opaqueDepth, const GlRays& rays,
                                    Progress& progress) {
  const GlSmokeMethod method = smokeMethod(scene, camera, quantity);
  if (method != GlSmokeMethod::kMarch)
    return smokePasses.draw(camera, scene.smokes[0], method, opaqueDepth, rays.opaque,
                            picture.name(), passes);
  if (scene.fogs.size() == 1 && scene.media() == 1 && mayWalk(scene.fogs[0]))
    return fogPasses.draw(
        scene.fogs[0], scene.fogFactor, scene.polarFog, quantity,
        [&] { return mapOf(scene.fogs[0]); }, camera, rays, picture.name(),
        device.rowsAtOnce(camera.width()), programs, passes, progress);
  return fail(ErrorCode::kUnsupported, "nothing is alone");
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

Status GlRenderer::draw(const Camera& camera, const GlScene& scene, GlQuantity quantity,
                        Progress& progress, std::span<const float> opaqueDepth) {
  State& state = *state_;
  VOLUTE_TRY(checkInput(camera, {}, opaqueDepth));
  VOLUTE_TRY(state.resize(camera));
  state.programs.pictureDone();  // the one before
  const GlRays rays = state.raysOf(camera, opaqueDepth);
  const auto alone = state.drawAlone(camera, scene, quantity, opaqueDepth, rays, progress);
  if (alone || alone.error().code != ErrorCode::kUnsupported) {
    state.sweep();
    return alone;
  }
  VOLUTE_ASSIGN(const State::Media media, state.mediaOf(scene, camera, progress));
  state.sweep();
  return state.march(camera, media, quantity, rays, state.picture, mediaNames(scene), progress);
}

Result<SurfacePicture> GlRenderer::surfaces(const Camera& camera, const SurfaceScene& scene,
                                            const GlScene& media, const Rgb& background,
                                            Progress& progress) {
  State& state = *state_;
  VOLUTE_TRY(state.checkSize(camera));
  State::Media made;
  SurfacePasses::Attenuate attenuate;
  if (media.media() > 0 && !scene.lamps.empty()) {
    VOLUTE_ASSIGN(made, state.mediaOf(media, camera, progress));
    attenuate = [&](const GlRays& rays) {
      return state.depthOf(camera, media, made, rays, progress);
    };
  }
  return state.surfacePasses.draw(camera, scene, background, attenuate, state.passes);
}

Result<SurfacePicture> GlRenderer::walls(const Camera& camera, const GlWalls& walls,
                                         Progress& progress) {
  State& state = *state_;
  VOLUTE_TRY(state.checkSize(camera));
  const GlScene smoke{.smokes = {walls.smoke}};
  State::Media made;
  if (!walls.lamps.empty()) {
    VOLUTE_ASSIGN(made, state.mediaOf(smoke, camera, progress));
  }
  const auto attenuate = [&](const GlRays& rays) {
    return state.depthOf(camera, smoke, made, rays, progress);
  };
  return state.surfacePasses.drawWalls(camera, walls, attenuate, state.passes);
}

Result<std::vector<SignPixel>> GlRenderer::findSigns(const Camera& camera,
                                                     std::span<const Sign> signs,
                                                     std::span<const float> opaqueDepth) {
  VOLUTE_TRY(state_->resize(camera));
  return state_->signPasses.find(camera, signs, opaqueDepth, state_->passes);
}

Result<Image> GlRenderer::signLight(std::span<const float> powers) {
  return state_->signPasses.light(powers, state_->picture.name(), state_->passes);
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

std::optional<TetProjectorCounts> GlRenderer::projectedTets() const {
  return state_->smokePasses.projected();
}

std::vector<GlPassTime> GlRenderer::takePasses() {
  return state_->passes.take();
}

}  // namespace volute
