// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_kinds.hpp"

#include <typeinfo>

#include "volute/gl/gl_billboard.hpp"
#include "volute/gl/gl_fds.hpp"
#include "volute/gl/gl_fog.hpp"
#include "volute/gl/gl_part.hpp"
#include "volute/gl/gl_shaded_volume.hpp"
#include "volute/gl/gl_smoke.hpp"
#include "volute/gl/gl_snapshot.hpp"
#include "volute/gl/gl_volume.hpp"
#include "volute/media/fds/fds_medium.hpp"
#include "volute/media/fog/fog_scene_medium.hpp"
#include "volute/media/smoke/smoke_medium.hpp"
#include "volute/media/volume/volume_medium.hpp"

namespace volute {
namespace {

GlVolume glVolumeOf(const VolumeSnapshot& volume) {
  return {volume.slice(), volume.emission(), volume.extinction(), volume.placement().turn,
          volume.placement().offset};
}

/// The part holds on to what the volume's light is computed from, not to the volume.
GlShadedVolume glShadedOf(const VolumeSnapshot& volume) {
  return {[light = volume.light()](const Camera& camera) { return seenFrom(*light, camera); },
          [light = volume.light()] { light->prepare(); }, volume.factor(), volume.placement().turn,
          volume.placement().offset};
}

GlParts partsOf(const VolumeSnapshot& volume, const GlSnapshotOptions&) {
  if (volume.light())
    return {glPart(glShadedOf(volume))};
  if (!volume.tree())
    return {glPart(glVolumeOf(volume))};
  const VolumeInfo& info = volume.info();
  GlTreeVolume tree{volume.tree(), volume.position(), info.basis,
                    info.bounds,   volume.emission(), volume.extinction()};
  tree.turn = volume.placement().turn, tree.offset = volume.placement().offset;
  return {glPart(std::move(tree))};
}

GlParts partsOf(const BillboardSnapshot& board, const GlSnapshotOptions&) {
  return {glPart(GlBillboard{glVolumeOf(board.volume()), board.options()})};
}

GlParts partsOf(const FogSnapshot& fog, const GlSnapshotOptions& options) {
  if (fog.lit())
    return {glPart(GlLitFog{fog.fog(), *fog.lit(), fog.factor()})};
  GlFog part{fog.fog(), fog.factor()};
  if (options.tables)
    part.polar = [fog = fog.map(), map = fog.fog()](const Camera& camera) {
      return fog->polarFor(camera, map);
    };
  return {glPart(std::move(part))};
}

GlParts partsOf(const SmokeSnapshot& smoke, const GlSnapshotOptions& options) {
  return {glPart(GlSmoke{smoke.state().locator, smoke.extinction(), smoke.state().source,
                         options.smokeMethod})};
}

GlWalls wallsOf(const SmokeSnapshot& smoke, const TriangleScene& others) {
  const SmokeState& state = smoke.state();
  return {{state.locator, &state.locator->mesh()},
          {{glPart(GlSmoke{state.locator, state.extinction, state.source})}},
          smoke.lights().lamps,
          *smoke.walls(),
          smoke.lights().ambient,
          others};
}

GlParts partsOf(const FdsSnapshot& fds, const GlSnapshotOptions&) {
  const FdsSnapshot::Lit& lit = fds.lit();
  GlParts parts{glPart(GlFds{fds.smoke(), fds.factor(), {}, lit.smoke, lit.surfaces})};
  if (fds.fire()) {
    for (const FdsFlame::Light& light : fds.fire()->lights())
      parts.push_back(glPart(GlFds{light.field, 1, light.colour}));
  }
  return parts;
}

/// What OpenGL cannot draw yet; nothing: it can.
Status drawable(const MediumSnapshot&) {
  return {};
}

Status drawable(const VolumeSnapshot& volume) {
  const Basis basis = volume.light()  ? volume.light()->slice().basis()
                      : volume.tree() ? volume.info().basis
                                      : volume.slice()->basis();
  if (basis == Basis::kCubic)
    return fail(ErrorCode::kUnsupported, "a volume that is measured over the cubic basis");
  return {};
}

Status drawable(const BillboardSnapshot& board) {
  return drawable(board.volume());
}

Status drawable(const FdsSnapshot& fds) {
  if (fds.sheets().empty())
    return {};
  return fail(ErrorCode::kUnsupported, "isosurfaces of an FDS case");
}

template <class M>
void addRow() {
  glMedia().add<M>([](const M& medium, const GlSnapshotOptions& options) -> Result<GlParts> {
    VOLUTE_TRY(drawable(medium));
    return Result<GlParts>(partsOf(medium, options));
  });
}

bool registerAll() {
  addRow<VolumeSnapshot>();
  addRow<BillboardSnapshot>();
  addRow<FogSnapshot>();
  addRow<FdsSnapshot>();
  addRow<SmokeSnapshot>();
  registerGlWalls(typeid(SmokeSnapshot),
                  [](const MediumSnapshot& medium, const TriangleScene& others) {
                    return wallsOf(static_cast<const SmokeSnapshot&>(medium), others);
                  });
  return true;
}

}  // namespace

void registerUsualGlMedia() {
  static const bool once = registerAll();
  (void)once;
}

}  // namespace volute
