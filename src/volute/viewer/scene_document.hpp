// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "volute/scene/fds_layer.hpp"
#include "volute/scene/fog_layer.hpp"
#include "volute/scene/scene_facts.hpp"
#include "volute/scene/scene_file.hpp"
#include "volute/scene/scene_history.hpp"
#include "volute/scene/smoke_layer.hpp"
#include "volute/scene/still.hpp"
#include "volute/viewer/document.hpp"
#include "volute/viewer/open_document.hpp"

namespace volute {

/// A scene; or a volume, a map of fog or a case of smoke, as a scene that holds nothing else. The
/// scene's JSON is what it is: changes go into it and are read back, and saving writes it.
class SceneDocument final : public Document {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Document>> open(const std::string& path,
                                                              const DocumentOptions& options,
                                                              Progress& progress);

  std::string title() const override;

  Box3 bounds() const override { return bounds_; }

  std::vector<double> times() const override { return times_; }

  bool grey() const override;
  bool measured() const override;

  std::optional<StartView> startView() const override { return start_; }

  std::optional<ViewLook> look() const override { return scene_.look; }

  Rgb background() const override { return scene_.background; }

  std::vector<std::string> remarks() const override { return remarks_; }

  std::vector<std::filesystem::path> files() const override;
  bool checked() const override;
  void check(Progress& progress) override;
  std::vector<Parameter> parameters() const override;
  std::vector<FogCanvas> canvases() const override;

  std::string sceneName() const override { return file_; }

  bool coarseHelps(double time) const override;
  Result<ViewScene> sceneAt(const SceneWish& wish, Progress& progress) override;
  Status set(const std::string& path, const std::vector<double>& value,
             Progress& progress) override;

  bool editable() const override { return true; }

  Result<std::string> edit(const SceneEdit& edit, Progress& progress) override;

  bool canUndo() const override { return history_.canUndo(); }

  bool canRedo() const override { return history_.canRedo(); }

  Status undo(Progress& progress) override;
  Status redo(Progress& progress) override;
  Status setFogMap(std::size_t canvas, std::vector<double> coefficients, bool unsaved) override;
  Status save(const std::string& target, const StartView& view, const ViewLook& look) override;
  Status saveFogMap(std::size_t canvas, const std::string& target, const Image& map) override;

 private:
  static constexpr std::uint64_t kLightBytes = 128 << 20;  ///< of lamps in smoke, in memory

  /// One of the scene's media, with what has been read of it. Exactly one layer is there.
  struct Medium {
    nlohmann::ordered_json json;
    std::optional<VolumeLayer> volume{};
    bool checked = false;  ///< it was looked through for damage
    bool damaged = false;
    int block = -1;  ///< of the frames of a .volute that are in memory
    std::optional<FogLayer> fog{};
    FogDescription fogWords{};
    std::optional<std::vector<double>> painted{};  ///< the fog's map [1/m], instead of the file's,
    double paintedMost = 0;                        ///< while its densest was this [1/m]
    bool unsaved = false;                          ///< the painted map is in no file
    std::optional<SmokeLayer> smoke{};
    std::optional<FdsLayer> fds{};
    std::vector<std::string> remarks{};  ///< that opening it gave
  };

  struct Board {
    VolumeLayer volume;
    BillboardOptions options;
    bool checked = false;  ///< as of media
    bool damaged = false;
    std::vector<std::string> remarks{};
  };

  /// What is to become of the volumes that were read.
  class Volumes;

  /// Takes one picture at a time: moments come and go, what it prepared for a mesh stays.
  struct Drawer {
    std::mutex mutex;
    ProcessorDrawer drawer;
  };

  SceneDocument(std::string path, const DocumentOptions& options)
      : path_(std::move(path)), options_(options) {}

  Status readJsonOfScene(Progress& progress);
  void lookInside(const FdsLayer& fds);
  nlohmann::ordered_json sceneOfFile();
  Status loadMesh(nlohmann::ordered_json json, Progress& progress);
  Status load(nlohmann::ordered_json json, Progress& progress);
  Status changeTo(nlohmann::ordered_json json, Progress& progress);
  Result<std::vector<Medium>> mediaOf(const nlohmann::ordered_json& json,
                                      const SceneDescription& scene, bool lightsChanged,
                                      Volumes& volumes, Progress& progress);
  [[nodiscard]] Result<VolumeLayer> openVolumeFile(const std::string& file,
                                                   Progress& progress) const;
  Status openMedium(Medium& medium, const Medium* before, const SceneDescription& scene,
                    std::size_t place, Progress& progress) const;
  [[nodiscard]] Result<SmokeLayer> openSmoke(const SmokeDescription& smoke, const Medium* before,
                                             const SceneLights& lights, Reading& reading) const;
  static bool serves(const Medium& old, const nlohmann::ordered_json& wanted, bool lightsChanged);
  SceneFacts facts() const;
  SceneEdit withBounds(SceneEdit edit) const;
  static bool paintable(const Medium& medium);
  static void keepPainted(const Medium& old, Medium& medium);
  static FogLayer shownFog(const Medium& medium);
  [[nodiscard]] Result<Medium*> canvasMedium(std::size_t canvas);
  void gatherRemarks();
  void findExtent();
  void findTimes();
  void include(const Box3& bounds);

  Result<std::shared_ptr<const BrickSlice>> coarseSlice(const VolumeLayer& layer, int position,
                                                        Progress& progress) const;
  Status addVolume(Medium& medium, double time, bool coarse, Progress& progress, ViewScene& scene,
                   Still& still);
  Status addFog(const Medium& medium, double time, ViewScene& scene, Still& still) const;
  Status addSmoke(Medium& medium, double time, Progress& progress, ViewScene& scene, Still& still);
  Status addFds(const Medium& medium, double time, ViewScene& scene, Still& still,
                TriangleMesh& buildings) const;
  Status addBoards(double time, Progress& progress, ViewScene& scene, Still& still);
  void addSurfaces(const SceneWish& wish, const Still& still, ViewScene& scene);
  Result<TriangleScene> withBuildings(TriangleMesh buildings) const;
  ProcessorPicture byProcessor(std::shared_ptr<const Still> still) const;
  PictureLaw law() const;

  std::string path_;  ///< as it was opened
  std::string file_;  ///< of the scene: path_, or where it would be saved
  DocumentOptions options_;
  std::shared_ptr<LightMemory> light_ = std::make_shared<LightMemory>(kLightBytes);
  std::shared_ptr<Drawer> drawer_ = std::make_shared<Drawer>();
  nlohmann::ordered_json json_;
  SceneHistory history_;
  SceneDescription scene_;
  std::vector<Medium> media_;
  TriangleScene geometry_;
  std::vector<Board> boards_;
  Box3 bounds_;
  std::vector<double> times_{0.0};
  std::optional<StartView> start_;
  std::vector<std::string> remarks_, sceneRemarks_;  ///< all; those that no medium gave
  std::string guess_;                                ///< what a file alone was taken for
  std::shared_ptr<const GlSurfaces> surfaces_;     ///< while nothing that lights them changes,
  TriangleScene surfacesOf_;                         ///< of this geometry
};

}  // namespace volute
