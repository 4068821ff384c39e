// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/fds/fds_building.hpp"
#include "volute/fds/fds_case.hpp"
#include "volute/fds/fds_flame.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/io/reading.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/media/fds/fds_iso_sheets.hpp"
#include "volute/media/fds/fds_look.hpp"
#include "volute/media/fds/fds_particle_cloud.hpp"
#include "volute/media/fds/fds_slice.hpp"
#include "volute/media/fds/lit_fds.hpp"
#include "volute/media/field_probe.hpp"
#include "volute/media/medium_snapshot.hpp"
#include "volute/media/scene_lights.hpp"
#include "volute/media/scene_medium.hpp"
#include "volute/medium/any_medium.hpp"

namespace volute {

/// A case whose meshes are distributed over the ranks of a team.
struct FdsShares {
  Team* team = nullptr;
  double scale = 1;     ///< the smoke is so many times as thick as the files say, whatever the law
  bool shines = false;  ///< FdsMedium::shines(), the same on all ranks
};

/// Smoke and fire of an FDS case at one time.
class FdsSnapshot final : public MediumSnapshot {
 public:
  /// The smoke in lamps' light, and the surfaces that shadow it.
  struct Lit {
    std::shared_ptr<const LitMedium> smoke;  ///< null: no lamp shines
    TriangleScene surfaces;
  };

  /// In the scene's light, and in that and the shadow of other media.
  using LightUp = std::function<Lit(const FdsField& smoke, const MediaLight& light)>;

  /// @param factor  of the smoke's extinction and of what it scatters
  /// @param shares  nothing: this process holds all
  /// @param smoke  in the light that comes from everywhere
  /// @param lightUp  asked when light is first asked for; empty: no lamp shines
  FdsSnapshot(FdsField smoke, double factor, std::optional<FdsFlame> fire,
              std::vector<AnyMedium> sheets, std::optional<FdsShares> shares = {},
              LightUp lightUp = {})
      : smoke_(std::move(smoke)),
        factor_(factor),
        fire_(std::move(fire)),
        sheets_(std::move(sheets)),
        shares_(shares),
        lightUp_(std::move(lightUp)) {}

  void addMedia(std::vector<AnyMedium>& media) const override;
  void addExtinction(std::vector<AnyMedium>& media) const override;

  /// The snapshot in another light, where this process holds all of it.
  std::shared_ptr<const MediumSnapshot> litBy(const MediaLight& light) const override;

  bool drawsItself() const override { return shares_.has_value(); }

  /// Where ranks hold shares, what draws them together.
  std::shared_ptr<MediumPicture> picture(std::shared_ptr<MediumPicture> earlier) const override;

  /// Without lamps.
  const FdsField& smoke() const { return smoke_; }

  const Lit& lit() const;

  double factor() const { return factor_; }

  /// Which shines and hides nothing; nothing where there is none.
  const std::optional<FdsFlame>& fire() const { return fire_; }

  /// Translucent surfaces.
  std::span<const AnyMedium> sheets() const { return sheets_; }

 private:
  FdsField smoke_;
  mutable Lit lit_;  ///< once it was asked for
  mutable std::once_flag asked_;
  double factor_;
  std::optional<FdsFlame> fire_;
  std::vector<AnyMedium> sheets_;
  std::optional<FdsShares> shares_;
  LightUp lightUp_;
};

class MediumKind;
struct MediumContext;

/// An FDS case in a scene: smoke, fire and building at any time and, if requested, devices and
/// slices. Keeps two stored frames of each in memory.
class FdsMedium final : public SceneMedium, public ProbedMedium {
 public:
  /// `description` gives the case, the source (its field; empty: the best that fills meshes), a
  /// scale, Km and the albedo; the quantity is that of the files, so kInvalidArgument for another
  /// one. Smoke scatters the light of the lamps that the building, as it is drawn, and the scene's
  /// own surfaces let through, and the ambient one. If ranks hold a share of the meshes each (see
  /// OpenOptions), iso-surfaces, and fire where meshes of two shares overlap, are kUnsupported.
  [[nodiscard]] static Result<std::shared_ptr<FdsMedium>> open(const FdsDescription& description,
                                                               const MediumContext& context,
                                                               Reading& reading);

  /// Whether the same is read from the same files under both descriptions.
  static bool readsTheSame(const FdsDescription& a, const FdsDescription& b);

  /// This case under another description, which readsTheSame(), and in another light; what was read
  /// is shared, so that only one of the two may be used from then on.
  std::shared_ptr<FdsMedium> with(const FdsDescription& description,
                                  const MediumContext& context) const;

  Result<std::shared_ptr<const MediumSnapshot>> at(const SnapshotRequest& request,
                                                   Progress& progress) override;

  /// Any of the case's sources, at its stored times, with bounds from the rounding to bytes. Shares
  /// files with the pictures.
  Result<std::unique_ptr<SightField>> sight(Reading& reading) override;

  /// All cases have a building, so never 0.
  std::uint64_t surfacesKey(const SnapshotRequest& request) const override;

  /// All opaque surfaces: the building, the devices' marks, particles and the slice. Outer walls
  /// and cuts open towards the eye.
  Status addSurfaces(const SnapshotRequest& request, TriangleMesh& to) const override;

  std::unique_ptr<FieldProbe> fieldProbe() const override;

  /// What a picture says about what it shows, and by which laws.
  MediumText text(const std::optional<Vec3>& eye) const override;

  /// An open building: from outside and above, so far away that all of it is seen, from that of
  /// eight directions from which most of its rooms is seen. A building that is looked at inside: at
  /// the height of a standing person's eyes, from one end of its largest room at 0 s to the other.
  std::optional<CameraDescription> firstCamera() const override;

  /// The first of some stored times at which the smoke has half of its largest amount among them.
  Result<std::optional<FirstTime>> firstTime(Progress& progress) override;

  const FdsDescription& description() const { return description_; }

  /// Whether flames are shown.
  bool burns() const { return heat_ != nullptr; }

  /// What the case's files say.
  const FdsCase& fdsCase() const { return *case_; }

  /// How bright flames are: FlameLaw::emission.
  const FlameLaw& flame() const { return flame_; }

  const Box3& bounds() const { return case_->bounds(); }

  /// When a stored frame is shown as it is, in the scene's time [s], and what --frames calls it.
  double timeOf(int step) const;

  int numberOf(int step) const { return step; }

 private:
  bool isClear() const { return case_->source().kind == FdsFileKind::kClear; }

  void describe();
  /// A field of that time as lamps light it: those of the scene and of other media, through them.
  FdsSnapshot::Lit inLight(const FdsField& field, double time, const std::optional<Vec3>& eye,
                           const MediaLight& other = {}) const;
  /// The scene's own surfaces, and the building and its walls of triangles as they are drawn.
  TriangleScene inTheWay(double time, const std::optional<Vec3>& eye) const;
  /// The fire at a time of the scene [s], which shines and hides nothing; nothing where the case
  /// has neither flame temperature nor heat release, or it is not shown, or nothing burns.
  Result<std::optional<FdsFlame>> fireAt(double time) const;
  /// Adds the obstructions, vents and walls of that time, coloured as the case says; what has no
  /// colour of its own is light grey. Ambient light alone would show no edges, so faces reflect
  /// less of their colour the less they face up. An open building stands in its meshes' outline,
  /// with a ruler along the two lower edges before it, and a needle to the north where the case
  /// says it.
  void addBuilding(double time, const std::optional<Vec3>& eye, TriangleMesh& to) const;
  std::vector<FdsQuad> quadsOf(const FdsBuilding& building, const std::optional<Vec3>& eye) const;
  void addFaces(std::span<const FdsQuad> quads, TriangleMesh& to) const;
  std::vector<std::string> words(const std::optional<Vec3>& eye) const;
  /// The numbers of the rulers that addBuilding() lays before an open building: coordinates [m],
  /// and which axis it is.
  std::vector<PlaceMark> rulerMarks(const std::optional<Vec3>& eye) const;
  double caseTime(double time) const;
  FdsBuilding buildingAt(double time) const;
  FdsSides openTowards(const FdsBuilding& building, const std::optional<Vec3>& eye) const;
  CameraDescription outsideCamera() const;
  std::optional<CameraDescription> insideCamera() const;
  double ruler(int axis) const;
  int rulerAxes() const;

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

  FdsDescription description_;
  SceneLights lights_;
  TriangleScene geometry_;  ///< of the scene
  Team* team_ = nullptr;
  std::shared_ptr<FdsCase> case_;
  std::shared_ptr<FdsCase> heat_;  // null: no fire
  bool glows_ = false;             // heat_ holds the flames' temperature
  double brightest_ = 1500;        // [K], of FdsFlame::glowing()
  FlameLaw flame_;
  std::optional<FdsSliceSheet> slice_;
  std::optional<FdsIsoSheets> iso_;
  std::optional<FdsParticleCloud> particles_;
  std::shared_ptr<const FdsBuilding> shell_;   // at the first time
  std::vector<Remark> notes_;                  // of walls and options, for people
  std::shared_ptr<const TriangleMesh> walls_;  // of triangles
  std::vector<double> events_;  // of obstructions, and of devices where they are shown; ascending
};

const MediumKind& fdsKind();

}  // namespace volute
