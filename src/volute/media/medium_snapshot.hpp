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

/// Draws one medium at all pixels at once, faster than along their rays. Caches data for other
/// snapshots of the same medium; not thread-safe.
class MediumPicture {
 public:
  virtual ~MediumPicture() = default;

  /// The optical depth (natural logarithm, whatever the law of a picture) of each pixel's ray up to
  /// `opaqueDepth`, as render() takes it.
  virtual void opticalDepth(const Camera& camera, std::span<const float> opaqueDepth,
                            std::span<float> depth) = 0;

  /// Light towards the eye, and the transmittance of the picture's law: RGBT, 4 values a pixel.
  /// Those of pixels whose rays end in the eye (`opaqueDepth` 0, perspective) mean nothing.
  virtual void light(const Camera& camera, std::span<const float> opaqueDepth,
                     std::span<float> rgbt) = 0;

  /// For a medium shared by ranks: the optical depth of the whole along segments, a collective call
  /// with the same segments on all ranks. Empty: the medium is not shared, or knows only the rays
  /// of pixels.
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

/// The emission of media as lamps, and the media that absorb the light of all lamps.
struct MediaLight {
  std::span<const Lamp> lamps;
  std::span<const AnyMedium> between{};  ///< all other media, with their physical extinction
};

/// A medium at one time, immutable and shared between threads: media for rays and, optionally,
/// faster paths and more than rays. All extinctions include SnapshotRequest::factor.
class MediumSnapshot {
 public:
  virtual ~MediumSnapshot() = default;

  /// Appends what rays from anywhere meet: one medium, or several that overlap.
  virtual void addMedia(std::vector<AnyMedium>& media) const = 0;

  /// The same for absorption only; emission may be left out.
  virtual void addExtinction(std::vector<AnyMedium>& media) const { addMedia(media); }

  /// The same for rays from a camera's eye: may be faster, or depend on the eye.
  [[nodiscard]] virtual Status addMediaFor(const Camera& camera,
                                           std::vector<AnyMedium>& media) const {
    (void)camera;
    addMedia(media);
    return {};
  }

  /// Whether picture() is not null.
  virtual bool drawsItself() const { return false; }

  /// Null, or what draws it at all pixels at once.
  /// @param earlier  the picture of another snapshot, to be reused if possible; or null
  virtual std::shared_ptr<MediumPicture> picture(std::shared_ptr<MediumPicture> earlier) const {
    (void)earlier;
    return nullptr;
  }

  /// A preview that is drawn much faster, without shadows of surfaces; or null.
  virtual std::shared_ptr<const MediumSnapshot> quick() const { return nullptr; }

  /// Its emission as a bounded number of point lamps in scene coordinates, without absorption.
  /// Empty: it lights only itself.
  virtual std::vector<Lamp> lightSources() const { return {}; }

  /// The same, lit and shadowed by other media, too; null: they do not change it.
  virtual std::shared_ptr<const MediumSnapshot> litBy(const MediaLight& light) const {
    (void)light;
    return nullptr;
  }

  /// What it holds alone, about [bytes].
  virtual std::uint64_t memoryBytes() const { return 0; }

  /// Whether it has reduced detail: SnapshotRequest::moving.
  virtual bool provisional() const { return false; }

  /// Whether it has walls of its own, which lookAtWalls() draws.
  virtual bool hasWalls() const { return false; }

  /// The first place where a ray would leave it through a wall, shown or not; nothing: nowhere.
  virtual std::optional<WallHit> wallOn(const Segment& ray) const {
    (void)ray;
    return std::nullopt;
  }

  /// @param others  that stand in the light besides
  /// @param only  empty, or one for each pixel: 0 leaves it out
  [[nodiscard]] virtual Result<SurfaceView> lookAtWalls(const Camera& camera,
                                                        const TriangleScene& others,
                                                        std::span<const std::uint8_t> only) const {
    (void)camera, (void)others, (void)only;
    return SurfaceView{};
  }

  /// Returns false, without any change, if it has no contours.
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
