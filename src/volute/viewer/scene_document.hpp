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

  std::string title() const override;

  Box3 bounds() const override { return scene_.bounds(); }

  Box3 content() const override { return sight_ ? sight_->content : bounds(); }

  double firstTime() const override { return sight_ ? sight_->time : times().front(); }

  bool changed() const override { return scene_.json() != saved_; }

  std::vector<double> times() const override { return scene_.times(); }

  bool grey() const override;
  bool interpolates() const override;

  std::uint64_t snapshotMemory() const override { return options_.maxMemory / 4; }

  bool measured() const override;
  bool burns() const override;

  std::optional<StartView> startView() const override { return start_; }

  std::optional<ViewLook> look() const override { return scene_.description().look; }

  Rgb background() const override { return scene_.description().background; }

  std::vector<std::string> remarks() const override;
  std::vector<std::filesystem::path> files() const override;
  bool checked() const override;
  void check(Progress& progress) override;

  std::vector<Parameter> parameters() const override { return scene_.parameters(); }

  std::vector<FogCanvas> canvases() const override;

  std::string sceneName() const override { return file_; }

  bool coarseHelps(double time) const override;
  Result<ViewScene> sceneAt(const SceneRequest& request, Progress& progress) override;
  std::shared_ptr<Document> frozen() const override;
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

  /// Takes one picture at a time: instants come and go, what it prepared for a mesh stays.
  struct Drawer {
    std::mutex mutex;
    CpuRenderer renderer;
  };

  SceneDocument(std::string path, Scene scene, const DocumentOptions& options);

  SceneEdit withBounds(SceneEdit edit) const;
  void addSurfaces(const SceneRequest& request, const std::shared_ptr<const Snapshot>& snapshot,
                   ViewScene& scene);
  CpuPicture byCpu(std::shared_ptr<const Snapshot> snapshot, bool surfaces) const;

  std::string path_;  ///< as it was opened
  std::string file_;  ///< of the scene: path_, or where it would be saved
  DocumentOptions options_;
  std::shared_ptr<Drawer> drawer_ = std::make_shared<Drawer>();
  Scene scene_;
  SceneHistory history_;
  std::optional<StartView> start_;
  std::optional<FirstSight> sight_;             ///< of what is no scene file
  nlohmann::ordered_json saved_;                ///< the scene, as a file has it
  std::vector<std::string> sceneRemarks_;       ///< that no medium gave
  std::shared_ptr<const GlSurfaces> surfaces_;  ///< while nothing that lights them changes,
  TriangleScene surfacesOf_;                    ///< of this geometry
  nlohmann::ordered_json surfacesIn_;           ///< in these lights
};

}  // namespace volute
