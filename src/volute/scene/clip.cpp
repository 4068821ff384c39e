// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/clip.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "volute/media/field_members.hpp"
#include "volute/media/field_sliders.hpp"

namespace volute {
namespace {

/// Another medium along the parts of segments that a clip shows.
class ClippedMedium {
 public:
  ClippedMedium(AnyMedium medium, std::shared_ptr<const SceneClip> clip)
      : medium_(std::move(medium)), clip_(std::move(clip)) {}

  Box3 bounds() const { return medium_.bounds(); }

  double extinction(const Vec3& point) const {
    return clip_->holds(point) ? medium_.extinction(point) : 0;
  }

  Rgb emission(const Vec3& point) const {
    return clip_->holds(point) ? medium_.emission(point) : Rgb(Rgb::Zero());
  }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    medium_.opticalDepth(shown(segments), depths);
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    medium_.pieces(shown(segments), pieces);
  }

  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
    medium_.radiance(shown(segments), out);
  }

  bool dependsOnEnd() const { return medium_.dependsOnEnd(); }

 private:
  std::vector<Segment> shown(std::span<const Segment> segments) const {
    std::vector<Segment> parts;
    parts.reserve(segments.size());
    for (const Segment& segment : segments) parts.push_back(clip_->part(segment));
    return parts;
  }

  AnyMedium medium_;
  std::shared_ptr<const SceneClip> clip_;
};

class ClippedSnapshot final : public MediumSnapshot {
 public:
  ClippedSnapshot(std::shared_ptr<const MediumSnapshot> medium,
                  std::shared_ptr<const SceneClip> clip)
      : medium_(std::move(medium)), clip_(std::move(clip)) {}

  const MediumSnapshot& whole() const { return *medium_; }

  const SceneClip& clip() const { return *clip_; }

  void addMedia(std::vector<AnyMedium>& media) const override {
    const std::size_t first = media.size();
    medium_->addMedia(media);
    clipFrom(first, media);
  }

  void addExtinction(std::vector<AnyMedium>& media) const override {
    medium_->addExtinction(media);  // light is that of the whole
  }

  Status addMediaFor(const Camera& camera, std::vector<AnyMedium>& media) const override {
    const std::size_t first = media.size();
    VOLUTE_TRY(medium_->addMediaFor(camera, media));
    clipFrom(first, media);
    return {};
  }

  std::shared_ptr<const MediumSnapshot> quick() const override {
    auto sooner = medium_->quick();
    return sooner ? clipped(std::move(sooner), clip_) : nullptr;
  }

  std::vector<Lamp> lightSources() const override { return medium_->lightSources(); }

  std::shared_ptr<const MediumSnapshot> litBy(const MediaLight& light) const override {
    auto lit = medium_->litBy(light);
    return lit ? clipped(std::move(lit), clip_) : nullptr;
  }

  std::uint64_t memoryBytes() const override { return medium_->memoryBytes(); }

  bool provisional() const override { return medium_->provisional(); }

  bool hasWalls() const override { return medium_->hasWalls(); }

  std::optional<WallHit> wallOn(const Segment& ray) const override { return medium_->wallOn(ray); }

  Result<SurfaceView> lookAtWalls(const Camera& camera, const TriangleScene& others,
                                  std::span<const std::uint8_t> only) const override {
    return medium_->lookAtWalls(camera, others, only);
  }

  bool addContour(const Contour& contour, const Camera& camera,
                  ContourPieces& pieces) const override {
    return medium_->addContour(contour, camera, pieces);
  }

  nlohmann::ordered_json counts() const override { return medium_->counts(); }

 private:
  void clipFrom(std::size_t first, std::vector<AnyMedium>& media) const {
    for (std::size_t i = first; i < media.size(); ++i)
      media[i] = AnyMedium(ClippedMedium(std::move(media[i]), clip_));
  }

  std::shared_ptr<const MediumSnapshot> medium_;
  std::shared_ptr<const SceneClip> clip_;
};

double stepIn(const void* /*clip*/, const MediumFacts& facts) {
  return facts.bounds.size().norm() / 500;
}

const FieldTable& boxFields() {
  using enum FieldType;
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "min", .type = kPoint, .access = member<&Box3::min>(),
       .help = "the corner with the smallest x, y and z", .unit = "m", .required = true,
       .slider = {.label = "from", .step = stepIn}},
      {.name = "max", .type = kPoint, .access = member<&Box3::max>(),
       .help = "the corner with the largest x, y and z", .unit = "m", .required = true,
       .slider = {.label = "to", .step = stepIn}}};
  // clang-format on
  static const FieldTable kTable =
      fieldTable<Box3>({.name = "clip_box",
                        .sentence = "media are shown inside of this box alone",
                        .fields = kFields,
                        .kind = "box"});
  return kTable;
}

const FieldTable& planeFields() {
  using enum FieldType;
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "point", .type = kPoint, .access = member<&ClipPlane::point>(),
       .help = "a point of the plane", .unit = "m", .required = true, .slider = {.label = "point", .step = stepIn}},
      {.name = "normal", .type = kDirection, .access = member<&ClipPlane::normal>(),
       .help = "points to the side that is left out", .required = true,
       .slider = {.label = "normal"}}};
  // clang-format on
  static const FieldTable kTable =
      fieldTable<ClipPlane>({.name = "clip_plane",
                             .sentence = "media are shown on one side of this plane alone",
                             .fields = kFields,
                             .kind = "plane"});
  return kTable;
}

}  // namespace

bool SceneClip::holds(const Vec3& point) const {
  return std::ranges::all_of(boxes, [&](const Box3& box) { return box.contains(point); }) &&
         std::ranges::all_of(planes, [&](const ClipPlane& plane) {
           return (point - plane.point).dot(plane.normal) <= 0;
         });
}

Segment SceneClip::part(const Segment& segment) const {
  Interval shown{segment.begin, segment.end};
  for (const Box3& box : boxes)
    shown = shown.intersect(box.intersect(segment.origin, segment.direction));
  for (const ClipPlane& plane : planes) {
    const double above = (segment.origin - plane.point).dot(plane.normal);
    const double climbs = segment.direction.dot(plane.normal);
    if (climbs > 0)
      shown.end = std::min(shown.end, -above / climbs);
    else if (climbs < 0)
      shown.begin = std::max(shown.begin, -above / climbs);
    else if (above > 0)
      shown = {};
  }
  Segment part = segment;
  part.begin = shown.empty() ? 0 : shown.begin;
  part.end = shown.empty() ? 0 : shown.end;
  return part;
}

std::span<const FieldTable* const> clipTables() {
  static const FieldTable* const kTables[] = {&boxFields(), &planeFields()};
  return kTables;
}

Result<SceneClip> parseClip(const nlohmann::json& json, const FieldOrigin& origin) {
  SceneClip clip;
  VOLUTE_TRY(
      eachEntry(json, origin, [&](const FieldValue& entry, const FieldOrigin& place) -> Status {
        const nlohmann::json kind =
            entry.is_object() ? entry.value("kind", nlohmann::json()) : entry;
        if (kind == "box") {
          VOLUTE_ASSIGN(const auto box, readAs<Box3>(boxFields(), entry, place));
          if (box.empty()) {
            return place.wrong(boxFields().at("max"),
                               "expected each number to be larger than that of min");
          }
          clip.boxes.push_back(box);
        } else if (kind == "plane") {
          VOLUTE_ASSIGN(const auto plane, readAs<ClipPlane>(planeFields(), entry, place));
          if (!(plane.normal.norm() > 0))
            return place.wrong(planeFields().at("normal"), "expected a direction, not 0, 0, 0");
          clip.planes.push_back(plane);
        } else {
          return place.wrong(FieldRow{.name = "kind"}, "expected box or plane");
        }
        return {};
      }));
  return clip;
}

std::shared_ptr<const MediumSnapshot> clipped(std::shared_ptr<const MediumSnapshot> medium,
                                              std::shared_ptr<const SceneClip> clip) {
  return std::make_shared<const ClippedSnapshot>(std::move(medium), std::move(clip));
}

const SceneClip* clipOf(const MediumSnapshot& medium) {
  const auto* clipped = dynamic_cast<const ClippedSnapshot*>(&medium);
  return clipped ? &clipped->clip() : nullptr;
}

const MediumSnapshot& unclipped(const MediumSnapshot& medium) {
  const auto* clip = dynamic_cast<const ClippedSnapshot*>(&medium);
  return clip ? clip->whole() : medium;
}

}  // namespace volute
