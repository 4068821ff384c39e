// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The part of a SceneDocument that is one instant of it.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "volute/gl/gl_billboard.hpp"
#include "volute/gl/gl_fds.hpp"
#include "volute/gl/gl_fog.hpp"
#include "volute/gl/gl_smoke.hpp"
#include "volute/render/scaled_medium.hpp"
#include "volute/render/surfaces.hpp"
#include "volute/tetmesh/tet_medium.hpp"
#include "volute/viewer/scene_document.hpp"
#include "volute/viewer/surface_corners.hpp"
#include "volute/viewer/view_lines.hpp"

namespace volute {
namespace {

const Rgb kOutline(0.45, 0.5, 0.55);
constexpr int kCoarseLevels = 2;  ///< of a block's, the coarsest first

/// Whether the same triangles look the same.
bool alike(const TriangleScene& a, const TriangleScene& b) {
  if (a.triangles().data() == b.triangles().data() && a.materials().data() == b.materials().data())
    return true;  // they share them
  const auto sameTriangle = [](const Triangle& one, const Triangle& other) {
    return one.material == other.material && std::ranges::equal(one.corners, other.corners);
  };
  const auto sameMaterial = [](const Material& one, const Material& other) {
    return (one.baseColor == other.baseColor).all() && (one.emission == other.emission).all();
  };
  return std::ranges::equal(a.triangles(), b.triangles(), sameTriangle) &&
         std::ranges::equal(a.materials(), b.materials(), sameMaterial);
}

/// VolumeLayer::mediumAt() for OpenGL.
GlVolume glVolumeOf(std::shared_ptr<const BrickSlice> slice, const VolumeLayer& layer) {
  const Appearance& look = layer.appearance();
  return {std::move(slice), look.emission, look.extinction, layer.placement().turn,
          layer.placement().offset};
}

/// The power of the picture's transmittance through which a sign is seen: see seenTransmittance().
double powerOf(const PictureLaw& law, double c) {
  return law.mode == PictureMode::kPhotometric ? 1 : std::numbers::ln10 / c / law.factor();
}

GlQuad quadOf(const Sign& sign, const PictureLaw& law) {
  const Vec3 right = sign.width * sign.right(), down = sign.height * sign.down();
  constexpr double kOnWall = 1e-3;  // [m] before it
  return {sign.position - 0.5 * (right + down) + kOnWall * sign.normal.normalized(),
          right,
          down,
          std::make_shared<const Image>(sign.picture),
          powerOf(law, sign.c),
          false};
}

}  // namespace

PictureLaw SceneDocument::law() const {
  return scene_.smokes.empty() ? PictureLaw{} : scene_.smokes.front().law;
}

/// A .volute's block of frames that is not in memory takes its time.
bool SceneDocument::coarseHelps(double time) const {
  return std::ranges::any_of(media_, [&](const Medium& medium) {
    return medium.volume && medium.volume->reader() &&
           medium.volume->positionAt(time) / BlockGrid::kSide != medium.block;
  });
}

Result<std::shared_ptr<const BrickSlice>> SceneDocument::coarseSlice(const VolumeLayer& layer,
                                                                     int position,
                                                                     Progress& progress) const {
  VOLUTE_ASSIGN(
      const Tree4d tree,
      Tree4d::load(*layer.reader(),
                   {.levels = kCoarseLevels, .firstFrame = position, .endFrame = position + 1},
                   progress));
  return std::make_shared<const BrickSlice>(layer.asItLooks(tree.extractSlice(position)));
}

Status SceneDocument::addVolume(Medium& medium, double time, bool coarse, Progress& progress,
                                ViewScene& scene, Still& still) {
  VolumeLayer& layer = *medium.volume;
  const int position = layer.positionAt(time);
  const int block = position / BlockGrid::kSide;
  const bool rough = coarse && layer.reader() && block != medium.block;
  layer.setProgress(progress);
  VOLUTE_ASSIGN(auto slice,
                rough ? coarseSlice(layer, position, progress) : layer.sliceAt(position));
  if (!rough)
    medium.block = block;
  const double factor = still.law.factor();
  const Appearance& look = layer.appearance();
  still.media.push_back(layer.placed(VoxelMedium(slice, look.emission, factor * look.extinction)));
  scene.natural.parts.push_back(glPart(glVolumeOf(std::move(slice), layer)));
  return {};
}

Status SceneDocument::addFog(const Medium& medium, double time, ViewScene& scene,
                             Still& still) const {
  const FogLayer layer = shownFog(medium);
  if (layer.sunlit()) {  // the same for all cameras, and slow to make
    VOLUTE_ASSIGN(auto lit, layer.sunlitAt(time));
    still.media.push_back(seenBy(still.law, AnyMedium(lit)));
    scene.natural.parts.push_back(glPart(GlSunlitFog{std::move(lit)}));
    return {};
  }
  scene.natural.parts.push_back(glPart(GlFog{layer.fogAt(time)}));
  still.viewed.push_back([layer, time, law = still.law](const Camera& camera) -> Result<AnyMedium> {
    VOLUTE_ASSIGN(auto medium, layer.mediumAt(time, camera));
    return seenBy(law, std::move(medium));
  });
  return {};
}

Status SceneDocument::addSmoke(Medium& medium, double time, Progress& progress, ViewScene& scene,
                               Still& still) {
  medium.smoke->setProgress(progress);
  VOLUTE_ASSIGN(auto state, medium.smoke->at(time));
  scene.natural.parts.push_back(
      glPart(GlSmoke{state.locator, state.extinction, state.source, options_.smokeMethod}));
  scene.meshes.push_back(state.locator);
  still.smokes.push_back(std::move(state));
  still.walls.push_back(medium.smoke->description().walls);
  return {};
}

Status SceneDocument::addFds(const Medium& medium, double time, ViewScene& scene, Still& still,
                             TriangleMesh& buildings) const {
  VOLUTE_ASSIGN(const auto smoke, medium.fds->fieldAt(time));  // once: lamps' light is slow
  const double factor = still.law.factor() * medium.fds->description().model.scale;
  still.media.push_back(factor == 1 ? AnyMedium(smoke)
                                    : AnyMedium(ScaledMedium(AnyMedium(smoke), factor)));
  scene.natural.parts.push_back(glPart(GlFds{smoke, medium.fds->description().model.scale}));
  VOLUTE_ASSIGN(auto fire, medium.fds->fireAt(time));
  if (fire) {
    scene.natural.parts.push_back(glPart(GlFds{fire->heat(), 1, fire->colour()}));
    still.media.push_back(AnyMedium(std::move(*fire)));
  }
  return medium.fds->addSurfaces(time, buildings);
}

Status SceneDocument::addBoards(double time, Progress& progress, ViewScene& scene, Still& still) {
  for (Board& board : boards_) {
    board.volume.setProgress(progress);
    const int position = board.volume.positionAt(time);
    const double factor = still.law.factor();
    VOLUTE_ASSIGN(auto slice, board.volume.sliceAt(position));
    scene.natural.parts.push_back(
        glPart(GlBillboard{glVolumeOf(std::move(slice), board.volume), board.options}));
    VOLUTE_ASSIGN(const auto volume, board.volume.mediumAt(position, factor));
    BillboardOptions options = board.options;
    options.shown = board.volume.info().bounds;
    still.viewed.push_back(
        [medium = AnyMedium(volume), options](const Camera& camera) -> Result<AnyMedium> {
          Progress quiet;
          VOLUTE_ASSIGN(auto drawn, Billboard::draw(medium, camera, options, quiet));
          return AnyMedium(std::move(drawn));
        });
  }
  return {};
}

/// Light at the corners is found anew where it may have changed: lamps shine through smoke, and
/// cases of FDS show other doors, devices and slices from instant to instant.
void SceneDocument::addSurfaces(const SceneWish& wish, const Still& still, ViewScene& scene) {
  if (!wish.openGl)
    return;
  const bool walls = std::ranges::any_of(still.walls, [](const auto& wall) { return !!wall; });
  if (still.geometry.empty() && !walls)
    return;
  if (!surfaces_ || !scene_.lights.lamps.empty() || !alike(surfacesOf_, still.geometry)) {
    std::vector<AnyMedium> media;
    const double factor = still.law.factor();
    for (const AnyMedium& medium : still.media)
      media.push_back(factor == 1 ? medium : AnyMedium(ScaledMedium(medium, 1 / factor)));
    for (const SmokeState& smoke : still.smokes)
      media.emplace_back(TetMedium(smoke.locator, smoke.extinction));
    surfaces_ = std::make_shared<const GlSurfaces>(
        surfaceCorners({still.geometry, scene_.lights.lamps, scene_.lights.ambient, media}));
    surfacesOf_ = still.geometry;
  }
  if (!walls) {
    scene.surfaces = surfaces_;
    return;
  }
  auto all = std::make_shared<GlSurfaces>(*surfaces_);
  for (std::size_t i = 0; i < still.smokes.size(); ++i) {
    if (still.walls[i])
      all->add(wallCorners(still.smokes[i], still.lights, *still.walls[i]));
  }
  scene.surfaces = std::move(all);
}

ProcessorPicture SceneDocument::byProcessor(std::shared_ptr<const Still> still) const {
  const RenderOptions options{.background = scene_.background};
  return [still = std::move(still), options, held = drawer_](const Camera& camera,
                                                             Progress& progress) {
    const std::lock_guard lock(held->mutex);
    return still->picture(camera, options, held->drawer, progress);
  };
}

Result<ViewScene> SceneDocument::sceneAt(const SceneWish& wish, Progress& progress) {
  const double time = wish.time;
  ViewScene scene;
  auto still = std::make_shared<Still>();
  still->law = law();
  still->lights = scene_.lights;
  still->signs = scene_.signs;
  TriangleMesh buildings;
  for (Medium& medium : media_) {
    if (medium.volume)
      VOLUTE_TRY(addVolume(medium, time, wish.coarse, progress, scene, *still));
    if (medium.fog)
      VOLUTE_TRY(addFog(medium, time, scene, *still));
    if (medium.smoke)
      VOLUTE_TRY(addSmoke(medium, time, progress, scene, *still));
    if (medium.fds)
      VOLUTE_TRY(addFds(medium, time, scene, *still, buildings));
  }
  VOLUTE_TRY(addBoards(time, progress, scene, *still));
  scene.natural.shade = geometry_;  // fogShadows() of the same
  scene.media = scene.natural.scaled(still->law.factor());
  still->geometry = geometry_;
  if (!buildings.triangles.empty()) {
    VOLUTE_ASSIGN(still->geometry, withBuildings(std::move(buildings)));
  }
  scene.geometry = still->geometry;
  addSurfaces(wish, *still, scene);
  if (scene.surfaces)
    scene.still = still;
  for (const Sign& sign : scene_.signs) scene.quads.push_back(quadOf(sign, still->law));
  if (media_.size() == 1 && (media_[0].smoke || media_[0].fds) && extensionOf(path_) != ".json")
    addBox(bounds_, kOutline, scene.aids);
  scene.processor = byProcessor(still);
  const bool walls = std::ranges::any_of(still->walls, [](const auto& wall) { return !!wall; });
  if (!still->geometry.empty() || walls) {
    auto bare = std::make_shared<Still>(*still);
    bare->geometry = {};
    std::ranges::fill(bare->walls, std::nullopt);
    scene.bare = byProcessor(bare);
  }
  return scene;
}

Result<TriangleScene> SceneDocument::withBuildings(TriangleMesh buildings) const {
  const auto first = static_cast<std::uint32_t>(buildings.materials.size());
  const auto materials = geometry_.materials();
  buildings.materials.insert(buildings.materials.end(), materials.begin(), materials.end());
  for (Triangle triangle : geometry_.triangles()) {
    triangle.material += first;
    buildings.triangles.push_back(triangle);
  }
  return TriangleScene::build(std::move(buildings.triangles), std::move(buildings.materials));
}

}  // namespace volute
