// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/fds/fds_building.hpp"
#include "volute/fds/fds_case.hpp"
#include "volute/fds/fds_flame.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/media/fds/fds_iso_sheets.hpp"
#include "volute/media/fds/fds_particle_cloud.hpp"
#include "volute/media/fds/fds_slice.hpp"
#include "volute/media/medium_at.hpp"
#include "volute/media/reading.hpp"
#include "volute/media/scene_lights.hpp"
#include "volute/media/scene_medium.hpp"
#include "volute/media/smoke/scene_smoke.hpp"
#include "volute/medium/any_medium.hpp"

namespace volute {

/// An FDS case that is shown: its smoke, fire and building at any time, and devices and slices
/// where they are asked for. Holds two stored frames of each.
class FdsLayer {
 public:
  /// `description` says the case, the source (its field; empty: the best that fills meshes), a
  /// scale, Km and the albedo; the case itself says what its files hold, so kInvalidArgument for
  /// another quantity. Smoke scatters the light of the lamps that obstructions and `blocks` let
  /// through, once, and the ambient one.
  /// @param holders  whose ranks hold a share of the meshes each, see OpenOptions; kUnsupported for
  ///                 what needs more than that: iso-surfaces, and fire where meshes of two shares
  ///                 overlap
  [[nodiscard]] static Result<FdsLayer> open(const SmokeDescription& description,
                                             const SceneLights& lights, Blocks blocks,
                                             Reading& reading, Team* holders = nullptr);

  /// Whether the same is read from the same files under both descriptions.
  static bool readsTheSame(const SmokeDescription& a, const SmokeDescription& b);

  /// This case under another description, which readsTheSame(), and in another light; what was read
  /// is shared, so that only one of the two may be used from then on.
  FdsLayer with(const SmokeDescription& description, const SceneLights& lights) const;

  const SmokeDescription& description() const { return description_; }

  Team* holders() const { return holders_; }

  /// Whether flames are shown.
  bool burns() const { return heat_ != nullptr; }

  /// A field of that time as lamps light it: those of the scene and of other media, through them.
  [[nodiscard]] Result<FdsField> inLight(const FdsField& field, double time,
                                         const MediaLight& other = {}) const;

  /// Whether what smoke sends is not the same everywhere, or it burns somewhere at some time.
  bool shines() const { return heat_ != nullptr || !lights_.lamps.empty(); }

  /// What the extinction is read from, in words.
  const std::string& source() const { return case_->source().description; }

  /// What the case's files say.
  const FdsCase& files() const { return *case_; }

  /// How bright flames are: FlameLaw::emission.
  const FlameLaw& flame() const { return flame_; }

  bool isClear() const { return case_->source().kind == FdsFileKind::kClear; }

  const Box3& bounds() const { return case_->bounds(); }

  int steps() const { return static_cast<int>(case_->times().size()); }

  /// What --frames calls a stored frame.
  int numberOf(int step) const { return step; }

  /// When a stored frame is shown as it is, in the scene's time [s].
  double timeOf(int step) const;

  /// The smoke at a time of the scene [s], linear between stored frames, in its light, still
  /// without the description's scale. Slow with lamps.
  [[nodiscard]] Result<FdsField> fieldAt(double time, bool lit = true) const;

  /// The fire at a time of the scene [s], which shines and hides nothing; nothing where the case
  /// has neither flame temperature nor heat release, or it is not shown, or nothing burns.
  [[nodiscard]] Result<std::optional<FdsFlame>> fireAt(double time) const;

  /// The translucent surfaces at a time of the scene [s]; none where none is asked for.
  [[nodiscard]] Result<std::vector<AnyMedium>> isoAt(double time) const;

  /// A number for what addSurfaces() adds: while it stays, so do they.
  std::uint64_t surfacesAt(double time, const std::optional<Vec3>& eye) const;

  /// Adds all that is opaque: the building, the devices' marks, particles and the slice.
  /// @param eye  from where it is seen: outer walls and cuts open towards it
  [[nodiscard]] Status addSurfaces(double time, const std::optional<Vec3>& eye,
                                   TriangleMesh& to) const;

  /// Adds the obstructions, vents and walls of that time, coloured as the case says; what has no
  /// colour of its own is light grey. Ambient light alone would show no edges, so faces reflect
  /// less of their colour the less they face up. An open building stands in its meshes' outline,
  /// with a ruler along the two lower edges before it, and a needle to the north where the case
  /// says it.
  void addBuilding(double time, const std::optional<Vec3>& eye, TriangleMesh& to) const;

  /// From where the case is seen where nobody says. An open building: from outside and above, so
  /// far away that all of it is seen, from that of eight directions from which most of its rooms is
  /// seen. A building that is looked at inside: at the height of a standing person's eyes, from one
  /// end of its largest room at 0 s to the other.
  std::optional<CameraDescription> firstCamera() const;

  /// The first of some stored times at which the smoke has half of its largest amount among them.
  [[nodiscard]] Result<std::optional<FirstTime>> firstTime(Progress& progress);

  /// What a picture says about what it shows, and by which laws.
  /// @param eye  from where it is seen [m]; nothing: not known
  std::vector<std::string> words(const std::optional<Vec3>& eye) const;

  /// The numbers of the rulers that addBuilding() lays before an open building: coordinates [m],
  /// and which axis it is.
  std::vector<PlaceMark> rulerMarks(const std::optional<Vec3>& eye) const;

  /// The slice that is shown, or null.
  const FdsSliceSheet* slice() const { return slice_ ? &*slice_ : nullptr; }

  /// The particles that are shown, or null.
  const FdsParticleCloud* particles() const { return particles_ ? &*particles_ : nullptr; }

  /// The translucent surfaces that are shown, or null.
  const FdsIsoSheets* iso() const { return iso_ ? &*iso_ : nullptr; }

 private:
  FdsLayer() = default;

  double caseTime(double time) const;
  FdsBuilding buildingAt(double time) const;
  FdsSides openTowards(const FdsBuilding& building, const std::optional<Vec3>& eye) const;
  CameraDescription outsideCamera() const;
  std::optional<CameraDescription> insideCamera() const;
  double ruler() const;

  /// Which points north, where the case says it.
  struct Needle {
    Vec3 tip, notch, left, right, letter;
  };

  Needle northNeedle(const Vec3& eye, FdsSides open) const;
  /// Where the ruler of x (0) or y (1) begins, `beside` the outline [m].
  static Vec3 rulerStart(const Box3& box, int axis, FdsSides open, double beside);
  void addEdges(std::span<const FdsQuad> quads, const Box3& bounds, TriangleMesh& to) const;
  void addOutline(const FdsBuilding& building, FdsSides open, TriangleMesh& to) const;
  Status openFire(Reading& reading);
  void showWhatThereIs(FdsLook& look, Reading& reading) const;
  Status dimFire(Reading& reading);
  Result<FdsFlame> flameOf(double caseTime) const;
  std::string fireLaw() const;
  Result<double> luminanceAt(double caseTime) const;
  void addDevices(double time, TriangleMesh& to) const;

  SmokeDescription description_;
  SceneLights lights_;
  Blocks blocks_;
  Team* holders_ = nullptr;
  std::shared_ptr<FdsCase> case_;
  std::shared_ptr<FdsCase> heat_;  // null: no fire
  bool glows_ = false;             // heat_ holds the flames' temperature
  double brightest_ = 1500;        // [K], of FdsFlame::glowing()
  FlameLaw flame_;
  std::optional<FdsSliceSheet> slice_;
  std::optional<FdsIsoSheets> iso_;
  std::optional<FdsParticleCloud> particles_;
  std::shared_ptr<const FdsBuilding> shell_;   // at the first time
  std::shared_ptr<const TriangleMesh> walls_;  // of triangles
  std::vector<double> events_;  // of obstructions, and of devices where they are shown; ascending
};

}  // namespace volute
