// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The part of SceneDocument that makes snapshots ready to be drawn.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "volute/gl/gl_part.hpp"
#include "volute/gl/gl_snapshot.hpp"
#include "volute/render/scaled_medium.hpp"
#include "volute/render/surfaces.hpp"
#include "volute/scene/clip.hpp"
#include "volute/viewer/scene_document.hpp"
#include "volute/viewer/surface_corners.hpp"
#include "volute/viewer/view_lines.hpp"

namespace volute {
namespace {

const Rgb kOutline(0.30, 0.33, 0.37), kGround(0.16, 0.18, 0.21), kMarked(0.85, 0.65, 0.25);

/// A level grid under what there is to see, in steps of 1, 2 or 5 times a power of ten [m].
void addGround(const Box3& content, std::vector<ViewLine>& lines) {
  constexpr double kSteps = 8, kAround = 0.6;
  const double wide = content.size().head<2>().maxCoeff();
  if (!(wide > 0) || !std::isfinite(wide))
    return;
  const double power = std::pow(10, std::floor(std::log10(wide / kSteps)));
  double step = power;
  for (const double times : {2.0, 5.0, 10.0}) {
    if (step * kSteps < wide)
      step = times * power;
  }
  const auto reach = static_cast<int>(std::ceil((0.5 + kAround) * wide / step));
  const Vec3 centre = content.centre();
  const Vec3 middle(step * std::round(centre.x() / step), step * std::round(centre.y() / step),
                    content.min.z());
  for (int i = -reach; i <= reach; ++i) {
    const Vec3 along = reach * step * Vec3::UnitX(), across = i * step * Vec3::UnitY();
    const Vec3 turnedAlong = reach * step * Vec3::UnitY(), turnedAcross = i * step * Vec3::UnitX();
    lines.push_back({middle - along + across, middle + along + across, kGround});
    lines.push_back(
        {middle - turnedAlong + turnedAcross, middle + turnedAlong + turnedAcross, kGround});
  }
}

/// A star with a line the way that it shines.
void markLamp(const Lamp& lamp, double size, std::vector<ViewLine>& lines) {
  if (lamp.kind != Lamp::Kind::kSpot)
    return;
  for (const Vec3& axis : {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()})
    lines.push_back(
        {lamp.position - 0.4 * size * axis, lamp.position + 0.4 * size * axis, kMarked});
  if (lamp.coneCosine > -1)
    lines.push_back({lamp.position, lamp.position + 2 * size * lamp.direction, kMarked});
}

/// A square with a line to the side that is left out.
void markPlane(const ClipPlane& plane, double size, std::vector<ViewLine>& lines) {
  const Vec3 normal = plane.normal.normalized();
  const Vec3 aside = size * normal.unitOrthogonal(), along = normal.cross(aside);
  const Vec3 corners[] = {plane.point + aside + along, plane.point - aside + along,
                          plane.point - aside - along, plane.point + aside - along};
  for (std::size_t i = 0; i < 4; ++i) lines.push_back({corners[i], corners[(i + 1) % 4], kMarked});
  lines.push_back({plane.point, plane.point + 0.5 * size * normal, kMarked});
}

std::string nameOf(const MediumInfo& info) {
  return fmt::format("{}: {}", info.kind, std::filesystem::path(info.file).filename().string());
}

/// Of what is in colours, the line that says what they are.
void describeMedia(const Scene& from, const std::optional<Vec3>& eye, ViewScene& scene) {
  scene.law = from.law();
  for (const auto& medium : from.media()) {
    scene.names.push_back(nameOf(medium->info()));
    const MediumText text = medium->text(eye);
    if (!text.scale)
      continue;
    std::string name;
    for (const std::string& line : text.legend) {
      for (const char* begin : {"slice:", "surface:", "particles:", "values:"}) {
        if (line.starts_with(begin))
          name = line;
      }
    }
    scene.scales.push_back({name, *text.scale});
  }
}

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

Result<std::vector<PlaceFields>> SceneDocument::fieldsAt(double time, const Vec3& place) {
  const auto media = scene_.media();
  probes_.resize(media.size());
  std::vector<PlaceFields> all;
  for (std::size_t i = 0; i < media.size(); ++i) {
    if (probes_[i].medium.lock() != media[i]) {
      const auto* probed = dynamic_cast<const ProbedMedium*>(media[i].get());
      probes_[i] = {media[i], probed ? probed->fieldProbe() : nullptr};
    }
    if (!probes_[i].probe)
      continue;
    VOLUTE_ASSIGN(auto fields, probes_[i].probe->at(time, place));
    all.push_back({nameOf(media[i]->info()), std::move(fields)});
  }
  return all;
}

/// A block of frames that is not in memory takes its time.
bool SceneDocument::coarseHelps(double time) const {
  return !std::ranges::all_of(scene_.media(),
                              [&](const auto& medium) { return medium->inMemory(time); });
}

/// Light at the corners is found anew where it may have changed: lamps shine through media, and
/// surfaces of media change from snapshot to snapshot.
void SceneDocument::addSurfaces(const SceneRequest& request,
                                const std::shared_ptr<const SceneSnapshot>& snapshot,
                                ViewScene& scene) {
  const SceneSnapshot& now = *snapshot;
  if (!request.openGl || (now.geometry.empty() && !now.hasWalls()))
    return;
  const nlohmann::ordered_json lights = scene_.json().value("lights", nlohmann::ordered_json());
  if (!surfaces_ || !now.lights.lamps.empty() || surfacesIn_ != lights ||
      !alike(surfacesOf_, now.geometry)) {
    std::vector<AnyMedium> media, natural;
    for (const auto& medium : now.media) medium->addMedia(media);
    for (const AnyMedium& medium : media) natural.push_back(scaledBy(1 / now.law.factor(), medium));
    surfaces_ = std::make_shared<const GlSurfaces>(
        surfaceCorners({now.geometry, now.lights.lamps, now.lights.ambient, natural}));
    surfacesOf_ = now.geometry;
    surfacesIn_ = lights;
  }
  scene.surfaces = surfaces_;
  scene.snapshot = snapshot;
  if (!now.hasWalls())
    return;
  auto all = std::make_shared<GlSurfaces>(*surfaces_);
  for (const auto& medium : now.media) {
    if (medium->hasWalls())
      all->add(wallCorners(unclipped(*medium)));
  }
  scene.surfaces = std::move(all);
}

/// @param surfaces  and walls are in it
CpuPicture SceneDocument::byCpu(std::shared_ptr<const SceneSnapshot> snapshot,
                                bool surfaces) const {
  RenderOptions options{.background = snapshot->background};
  return [snapshot = std::move(snapshot), options, surfaces, held = drawer_](const Camera& camera,
                                                                             Progress& progress) {
    const std::lock_guard lock(held->mutex);
    if (surfaces)
      return held->renderer.render(*snapshot, camera, options, progress);
    return held->renderer.renderBare(*snapshot, camera, options, progress);
  };
}

Result<ViewScene> SceneDocument::sceneAt(const SceneRequest& request, Progress& progress) {
  ViewScene scene;
  scene.time = request.time;
  // What stands in the way of the first view is left out; it stays so as one goes round.
  std::optional<Vec3> eye;
  if (start_)
    eye = start_->eye;
  VOLUTE_ASSIGN(
      auto taken,
      scene_.at(
          {.time = request.time, .coarse = request.coarse, .moving = request.moving, .eye = eye},
          progress));
  const auto snapshot = std::make_shared<const SceneSnapshot>(std::move(taken));
  auto media = glSceneOf(*snapshot, {.smokeMethod = options_.smokeMethod});
  if (media)
    scene.media = std::move(*media);
  else
    scene.notByGl = media.error().message;
  scene.geometry = snapshot->geometry;
  scene.now = snapshot->media;
  describeMedia(scene_, eye, scene);
  addSurfaces(request, snapshot, scene);
  for (const Sign& sign : snapshot->signs) scene.quads.push_back(quadOf(sign, snapshot->law));
  if (!scene_.isFile() && scene_.media().front()->info().interpolates)
    addBox(scene_.bounds(), kOutline, scene.aids);
  for (const Box3& box : scene_.description().clip.boxes) addBox(box, kOutline, scene.aids);
  const double size = content().empty() ? 1 : content().size().norm();
  for (const Lamp& lamp : scene_.description().lights.lamps)
    markLamp(lamp, 0.03 * size, scene.marks);
  for (const ClipPlane& plane : scene_.description().clip.planes)
    markPlane(plane, 0.3 * size, scene.marks);
  if (!scene_.isFile() && snapshot->geometry.empty() && !start_)
    addGround(content(), scene.aids);
  scene.cpu = byCpu(snapshot, true);
  if (auto quick = snapshot->quick())
    scene.preview = byCpu(std::make_shared<const SceneSnapshot>(std::move(*quick)), true);
  scene.inTiles = std::ranges::none_of(snapshot->media,
                                       [](const auto& medium) { return medium->drawsItself(); });
  for (const auto& medium : snapshot->media) {
    scene.bytes += medium->memoryBytes();
    scene.provisional = scene.provisional || medium->provisional();
  }
  // Here, not while a picture is waited for; but the first one that is waited for is a preview,
  // which needs none of it.
  const bool later = std::exchange(opens_, false) && scene.preview;
  if (request.openGl) {
    for (const auto& part : scene.media.parts) part->prepare();
  } else if (!later) {
    std::vector<AnyMedium> prepared;
    for (const auto& medium : snapshot->media) medium->addMedia(prepared);
  }
  if (!snapshot->geometry.empty() || snapshot->hasWalls())
    scene.bare = byCpu(snapshot, false);
  return scene;
}

}  // namespace volute
