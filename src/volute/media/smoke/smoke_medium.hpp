// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/io/mesh_source.hpp"
#include "volute/io/reading.hpp"
#include "volute/lighting/illumination.hpp"
#include "volute/lighting/light_cache.hpp"
#include "volute/lighting/light_memory.hpp"
#include "volute/lighting/vertex_light.hpp"
#include "volute/media/field_probe.hpp"
#include "volute/media/scene_lights.hpp"
#include "volute/media/scene_medium.hpp"
#include "volute/media/smoke/scene_smoke.hpp"
#include "volute/media/smoke/wall_light.hpp"

namespace volute {

struct OpenOptions;

/// What is known of light at walls between two steps of smoke, between which extinctions are linear
/// in time.
struct WallInterval {
  std::shared_ptr<const std::vector<float>> from, to;  ///< [1/m], one for each vertex
  std::shared_ptr<WallLight> light;
};

/// Smoke at one time, on its mesh.
struct SmokeState {
  std::shared_ptr<const TetLocator> locator;
  std::vector<float> extinction;               ///< [1/m], natural logarithm, one for each vertex
  std::vector<float> source;                   ///< see TetMedium; empty: black
  std::vector<std::vector<float>> lampShares;  ///< of each lamp, at each vertex
  /// The same for what is linear between vertices: LampPaths::means(). Empty: as they are.
  std::vector<std::vector<float>> lampMeans{};
  /// Of one unit of concentration [1/m], unitOfConcentration(); 0: the field holds no mass.
  double extinctionOfUnit = 0;
  std::shared_ptr<const MeshWalls> walls{};  ///< of the mesh; null: not made yet
  WallInterval interval{};                   ///< around its time; null pointers: none is known
  double intervalTime = 0;                   ///< 0..1, when in it
  Rgb albedo = Rgb::Zero();                  ///< share of what it takes from light that it sends on
};

/// What lights smoke, and where computed light is kept.
struct SmokeLighting {
  SceneLights lights;
  std::shared_ptr<const LightCache> cache{};  ///< may be null
  Blocks blocks;                              ///< other opaque things; may be empty
  std::string blocksKey;                      ///< stands for them in the cache
  std::shared_ptr<LightMemory> memory{};      ///< asked before the cache; may be null

  Illumination illumination(const MediaLight& other = {}) const;
};

/// Counts of work, summed over all pictures.
struct SmokeCounts {
  std::uint64_t stepsRead = 0;
  std::uint64_t lightsComputed = 0;  ///< one for each lamp and step
  std::uint64_t lightsReused = 0;    ///< read from the cache
  std::uint64_t clamped = 0;         ///< negative values taken as 0
  double lightMilliseconds = 0;
};

/// Smoke on tetrahedra at one time.
class SmokeSnapshot final : public MediumSnapshot {
 public:
  SmokeSnapshot(SmokeState state, double factor, std::shared_ptr<const SmokeLighting> lighting,
                std::optional<Rgb> walls, Team* team = nullptr)
      : state_(std::move(state)),
        factor_(factor),
        lighting_(std::move(lighting)),
        walls_(std::move(walls)),
        team_(team) {}

  void addMedia(std::vector<AnyMedium>& media) const override;
  void addExtinction(std::vector<AnyMedium>& media) const override;
  std::shared_ptr<MediumPicture> picture(std::shared_ptr<MediumPicture> earlier) const override;

  bool drawsItself() const override { return true; }

  /// Where this process holds all of it; its walls see no more than before.
  std::shared_ptr<const MediumSnapshot> litBy(const MediaLight& light) const override;

  std::uint64_t memoryBytes() const override {
    return 3 * state_.extinction.size() * sizeof(float);
  }

  bool hasWalls() const override { return walls_.has_value(); }

  std::optional<WallHit> wallOn(const Segment& ray) const override;
  Result<SurfaceView> lookAtWalls(const Camera& camera, const TriangleScene& others,
                                  std::span<const std::uint8_t> only) const override;
  bool addContour(const Contour& contour, const Camera& camera,
                  ContourPieces& pieces) const override;

  /// As the files have it, whatever the law; its source is found when it is first asked for.
  const SmokeState& state() const;

  double factor() const { return factor_; }

  /// Whose ranks hold a share each; null: this process holds all.
  Team* team() const { return team_; }

  /// [1/m], times the factor, one for each vertex.
  std::vector<float> extinction() const;

  const SceneLights& lights() const { return lighting_->lights; }

  /// Reflectance of the mesh's boundary; nothing: it is not drawn.
  const std::optional<Rgb>& walls() const { return walls_; }

 private:
  void light(const Illumination& light) const;

  mutable SmokeState state_;
  mutable std::once_flag lit_;
  double factor_;
  std::shared_ptr<const SmokeLighting> lighting_;
  std::optional<Rgb> walls_;
  std::unique_ptr<WallLight> wallLight_ = std::make_unique<WallLight>();
  Team* team_;
};

class MediumKind;

/// A case of smoke on a mesh in a scene. Keeps at most two frames of it in memory: the values of
/// the files, and extinction and light computed from them.
class SmokeMedium final : public SceneMedium, public ProbedMedium {
 public:
  /// Reads the first step.
  /// @param options  of ranks that hold a share each, bounds and what is remarked on are of all,
  /// and
  ///                 kUnsupported is what needs more than one's own share: walls, and values of
  ///                 cells. With sightOnly nothing is remarked on how thick the smoke is
  [[nodiscard]] static Result<std::shared_ptr<SmokeMedium>> open(
      const SmokeDescription& description, std::shared_ptr<const SmokeLighting> lighting,
      Reading& reading, const OpenOptions& options);

  /// Whether the same is read from the same files under both descriptions.
  static bool readsTheSame(const SmokeDescription& a, const SmokeDescription& b);

  /// This case under another description, which readsTheSame(), and another light: what was read is
  /// shared, so that only one of the two may be used from then on. Its light is looked for in the
  /// cache but not added to it: a person who tries values leaves too many behind.
  [[nodiscard]] Result<std::shared_ptr<SmokeMedium>> with(
      const SmokeDescription& description, std::shared_ptr<const SmokeLighting> lighting,
      Reading& reading) const;

  Result<std::shared_ptr<const MediumSnapshot>> at(const SnapshotRequest& request,
                                                   Progress& progress) override;
  Result<std::unique_ptr<SightField>> sight(Reading& reading) override;
  MediumText text(const std::optional<Vec3>& eye) const override;
  std::unique_ptr<FieldProbe> fieldProbe() const override;
  nlohmann::ordered_json counts() const override;

  const SmokeDescription& description() const { return description_; }

  /// Of the case, also where the description leaves it to the file.
  const std::string& fieldName() const { return files_->field; }

  /// The case as it was opened.
  const MeshSource& source() const { return files_->source; }

  /// Its scalars besides that field; empty: there are none.
  const std::string& otherFields() const { return files_->otherFields; }

  const Box3& bounds() const { return bounds_; }

  /// Rooms on fire hold 1e-6 to 1e-3 kg/m3 of soot. Outside of these limits the unit is doubted.
  static constexpr double kMuchSoot = 1e-2, kLittleSoot = 1e-6;

  /// Of the first step with smoke [1/m]; 0 before one was read.
  double largestExtinction() const { return largest_; }

  /// What the choice of quantity and unit comes to for smoke of at most so much extinction [1/m].
  /// `when` is put before the sentence of a doubt; may be empty.
  std::vector<Remark> remarksOn(double largest, const std::string& when) const;

  /// What --frames calls a step.
  int numberOf(int step) const { return files_->source.numberOf(static_cast<std::size_t>(step)); }

  /// When a step is shown as it is, in the scene's time [s].
  double timeOf(int step) const;

  /// At a time of the scene [s], without a source. Between two steps extinction, and what reaches
  /// each vertex of a lamp's light, is linear in time; meshes that differ are held until the next.
  /// Before the first and after the last step it is theirs.
  [[nodiscard]] Result<SmokeState> stateAt(double time, Progress& progress);

  /// A step as sight lines see it: no lamp is asked for its light.
  struct Extinction {
    std::shared_ptr<const TetLocator> locator;
    std::vector<float> values;  ///< [1/m], natural logarithm, one for each vertex
  };

  [[nodiscard]] Result<Extinction> extinctionAt(std::size_t step, Progress& progress);

  const SmokeCounts& done() const { return counts_; }

 private:
  /// Values of a step, as the files hold them.
  struct Stored {
    std::size_t index = 0;
    std::shared_ptr<const LampPaths> paths;
    ContentHash meshHash;  ///< of what the light's key begins with
    MeshFrame frame;
    std::vector<float> gas;                                ///< its density; empty: not asked for
    std::optional<std::array<double, 7>> gasDimensions{};  ///< that its file states
  };

  /// The files, and the last two steps of them.
  struct Files {
    MeshSource source;
    std::optional<MeshSource> densitySource{};
    std::string field{}, otherFields{};
    std::vector<std::shared_ptr<const Stored>> steps{};
    std::shared_ptr<const TetMesh> wallsOf{};  ///< what `walls` are of
    std::shared_ptr<const MeshWalls> walls{};
    bool ghostsTold = false;
    bool unusedTold = false;
    bool overlapTold = false;
    bool contactTold = false;
  };

  /// Data computed from a frame.
  struct Step {
    std::shared_ptr<const Stored> stored;
    std::vector<float> extinction;
    std::vector<std::vector<float>> lampShares, lampMeans;
  };

  SmokeMedium(SmokeDescription description, std::shared_ptr<Files> files)
      : description_(std::move(description)), files_(std::move(files)) {}

  void describe();

  [[nodiscard]] Result<std::shared_ptr<const Step>> step(std::size_t index);
  [[nodiscard]] Result<std::shared_ptr<const Stored>> readStep(std::size_t index);
  /// Says that cells lie in others, once.
  void tellOverlap(const Stored& stored);
  /// Says that cells touch which have no faces in common, once.
  void tellContact(const Stored& stored);
  [[nodiscard]] Result<std::vector<float>> extinctionOf(const Stored& stored) const;
  [[nodiscard]] Status light(Step& step);
  [[nodiscard]] Result<std::shared_ptr<const MeshWalls>> wallsOf(const MeshFrame& frame);
  WallInterval wallsBetween(const std::shared_ptr<const Step>& from,
                            const std::shared_ptr<const Step>& to);
  /// lampShares and, behind them, lampMeans.
  std::vector<float> lightOf(const Step& step, const Lamp& lamp);
  [[nodiscard]] Result<std::vector<float>> sharedLightOf(const Step& step, const Lamp& lamp);
  std::string lightKey(const Step& step, const Lamp& lamp) const;
  [[nodiscard]] Status checkShare(const Stored& stored) const;
  [[nodiscard]] Result<double> largestOf(std::span<const float> extinction);
  void remarkOn(const Stored& stored, double most);
  void addThinSmoke(double most, const std::string& when, std::vector<Remark>& remarks) const;

  SmokeDescription description_;
  std::shared_ptr<Files> files_;
  std::shared_ptr<const SmokeLighting> lighting_;
  Box3 bounds_;
  Team* team_ = nullptr;
  Progress* progress_ = nullptr;
  std::vector<std::shared_ptr<const Step>> steps_;  ///< the last two
  WallInterval interval_;                           ///< the last
  SmokeCounts counts_;
  bool remarked_ = false;
  double largest_ = 0;
  bool fillsCache_ = true;
};

const MediumKind& smokeKind();

}  // namespace volute
