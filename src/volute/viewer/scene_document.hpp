// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "volute/scene/first_sight.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_history.hpp"
#include "volute/scene/scene_renderer.hpp"
#include "volute/viewer/document.hpp"
#include "volute/viewer/open_document.hpp"

namespace volute {

/// A Scene, and what was done to it; any file alone is a scene that holds nothing else. Saving
/// writes its JSON.
class SceneDocument final : public Document {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Document>> open(const std::string& path,
                                                              const DocumentOptions& options,
                                                              Progress& progress);

  DocumentInfo info() const override;
  std::vector<std::filesystem::path> files() const override;
  Result<std::string> goOnFrom(const Document& before, Progress& progress) override;
  bool checked() const override;
  void check(Progress& progress) override;
  bool coarseHelps(double time) const override;
  Result<ViewScene> sceneAt(const SceneRequest& request, Progress& progress) override;
  Result<std::vector<PlaceFields>> fieldsAt(double time, const Vec3& place) override;
  std::shared_ptr<Document> frozen() const override;
  Status set(const std::string& path, const std::vector<double>& value,
             Progress& progress) override;
  Result<std::string> edit(const SceneEdit& edit, Progress& progress) override;
  Result<std::string> add(const std::string& path, Progress& progress) override;
  Status undo(Progress& progress) override;
  Status redo(Progress& progress) override;
  Status setFogMap(std::size_t canvas, std::vector<double> coefficients, bool unsaved) override;
  Status save(const std::string& target, const StartView& view, const ViewLook& look) override;
  Status saveFogMap(std::size_t canvas, const std::string& target, const Image& map) override;

 private:
  static constexpr std::uint64_t kLightBytes = 128 << 20;  ///< of lamps in smoke, in memory

  /// Takes one picture at a time: snapshots come and go, what it prepared for a mesh stays.
  struct Drawer {
    std::mutex mutex;
    CpuRenderer renderer;
  };

  SceneDocument(std::string path, Scene scene, const DocumentOptions& options);

  std::string title() const;
  std::vector<std::string> remarks() const;
  std::vector<FogCanvas> canvases() const;

  Box3 content() const { return sight_ ? sight_->content : scene_.bounds(); }

  [[nodiscard]] Status checkNotShown(const std::string& target, const std::string& own) const;
  Result<nlohmann::ordered_json> withFile(const std::string& path, Progress& progress) const;
  SceneEdit withBounds(SceneEdit edit) const;
  void addSurfaces(const SceneRequest& request,
                   const std::shared_ptr<const SceneSnapshot>& snapshot, ViewScene& scene);
  CpuPicture byCpu(std::shared_ptr<const SceneSnapshot> snapshot, bool surfaces) const;

  std::string path_;  ///< as it was opened
  std::string file_;  ///< of the scene: path_, or where it would be saved
  DocumentOptions options_;
  std::shared_ptr<Drawer> drawer_ = std::make_shared<Drawer>();
  Scene scene_;
  SceneHistory history_;
  bool opens_ = true;  ///< nothing has been shown of it
  std::optional<StartView> start_;
  std::optional<FirstSight> sight_;             ///< of what is no scene file
  nlohmann::ordered_json saved_;                ///< the scene, as a file has it
  std::string onDisk_;                          ///< the scene's file as it was read or written
  bool overwritten_ = false;                    ///< DocumentInfo::overwritten
  std::vector<std::string> sceneRemarks_;       ///< that no medium gave
  std::shared_ptr<const GlSurfaces> surfaces_;  ///< while nothing that lights them changes,
  TriangleScene surfacesOf_;                    ///< of this geometry
  nlohmann::ordered_json surfacesIn_;           ///< in these lights

  struct Probe {
    std::weak_ptr<SceneMedium> medium;  ///< of which it is
    std::shared_ptr<FieldProbe> probe;  ///< null: the medium has none
  };

  std::vector<Probe> probes_;
};

}  // namespace volute
