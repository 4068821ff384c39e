// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/lighting/lamp.hpp"
#include "volute/medium/any_medium.hpp"
#include "volute/render/surfaces.hpp"

namespace volute {

/// Draws one medium at all pixels at once, faster than along their rays. Keeps what serves other
/// instants of the same medium, so it is used by one thread at a time.
class MediumPicture {
 public:
  virtual ~MediumPicture() = default;

  /// The optical depth (natural logarithm, whatever the law of a picture) of each pixel's ray up to
  /// `opaqueDepth`, as render() takes it.
  virtual void opticalDepth(const Camera& camera, std::span<const float> opaqueDepth,
                            std::span<float> depth) = 0;

  /// Light towards the eye, and the transmittance of the picture's law: RGBT, 4 values a pixel.
  virtual void light(const Camera& camera, std::span<const float> opaqueDepth,
                     std::span<float> rgbt) = 0;

  /// Of a medium of which several ranks hold a share each: the optical depth along segments of what
  /// all hold, which all ranks ask for together, for the same segments. Empty: it is not shared, or
  /// not known along any but pixels' rays.
  virtual DepthsAlong depthsOfAll() const { return {}; }
};

struct Contour;

/// A contour as triangles, and the building around it.
struct ContourPieces {
  std::vector<Triangle> triangles;
  std::vector<std::array<float, 3>>
      values;                   ///< at the corners of each: extinction [1/m] or concentration
  std::vector<Triangle> walls;  ///< those that the camera sees the inner side of
};

/// Where a ray meets the inner side of a medium's wall.
struct WallHit {
  double distance = 0;          ///< along the ray [m]
  Vec3 normal = Vec3::UnitX();  ///< unit, into the medium
};

/// What glows in a scene, as lamps, and what is in the way of all lights.
struct MediaLight {
  std::span<const Lamp> lamps;
  std::span<const AnyMedium> between{};  ///< all other media, with their physical extinction
};

/// A medium at one time, immutable and shared between threads: what rays meet, and by query what
/// somebody can do faster or beyond rays. Extinctions are times the factor of the picture's law
/// that it was asked for with.
class MediumSnapshot {
 public:
  virtual ~MediumSnapshot() = default;

  /// Appends what rays from anywhere meet: one medium, or several that overlap.
  virtual void addMedia(std::vector<AnyMedium>& media) const = 0;

  /// The same as far as light that is in its way is concerned: what it sends may be left out.
  virtual void addExtinction(std::vector<AnyMedium>& media) const { addMedia(media); }

  /// The same for rays from a camera's eye, where something faster serves them, or where it depends
  /// on the eye.
  [[nodiscard]] virtual Status addMediaFor(const Camera& camera,
                                           std::vector<AnyMedium>& media) const {
    (void)camera;
    addMedia(media);
    return {};
  }

  /// Whether picture() is not null.
  virtual bool drawsItself() const { return false; }

  /// Null, or what draws it at all pixels at once.
  /// @param earlier  what this gave for another snapshot of the scene, which may serve; or null
  virtual std::shared_ptr<MediumPicture> picture(std::shared_ptr<MediumPicture> earlier) const {
    (void)earlier;
    return nullptr;
  }

  /// Null, or what looks nearly the same and is drawn much sooner: without surfaces' shadows.
  virtual std::shared_ptr<const MediumSnapshot> quick() const { return nullptr; }

  /// Where it glows, and how strongly: lamps that shine everywhere, a bounded number, in the
  /// scene's place. Nothing takes from their light yet. Empty: it lights nothing but itself.
  virtual std::vector<Lamp> lightSources() const { return {}; }

  /// The same in the light of other media besides all that shines at it anyway, and in their
  /// shadow; null: that changes nothing of it.
  virtual std::shared_ptr<const MediumSnapshot> litBy(const MediaLight& light) const {
    (void)light;
    return nullptr;
  }

  /// What it holds alone, about [bytes].
  virtual std::uint64_t memoryBytes() const { return 0; }

  /// Whether it has less detail than one that rests: SnapshotRequest::moving.
  virtual bool provisional() const { return false; }

  /// Whether it has walls of its own, which lookAtWalls() draws.
  virtual bool hasWalls() const { return false; }

  /// The first place where a ray would leave it through a wall, shown or not; nothing: nowhere.
  virtual std::optional<WallHit> wallOn(const Segment& ray) const {
    (void)ray;
    return std::nullopt;
  }

  /// @param others  that stand in the light besides
  /// @param only  empty, or one for each pixel: of the others nothing is asked
  [[nodiscard]] virtual Result<SurfaceView> lookAtWalls(const Camera& camera,
                                                        const TriangleScene& others,
                                                        std::span<const std::uint8_t> only) const {
    (void)camera, (void)others, (void)only;
    return SurfaceView{};
  }

  /// False, with nothing done, where no contours can be cut from it.
  virtual bool addContour(const Contour& contour, const Camera& camera,
                          ContourPieces& pieces) const {
    (void)contour, (void)camera, (void)pieces;
    return false;
  }

  /// What rays have looked at so far, by names of `render --stats`.
  virtual nlohmann::ordered_json counts() const;
};

/// Adds the numbers of `more` to those of the same names, those of objects within likewise.
void addCounts(nlohmann::ordered_json& sum, const nlohmann::ordered_json& more);

}  // namespace volute
