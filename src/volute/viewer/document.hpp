// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/fog/fog_medium.hpp"
#include "volute/math/box.hpp"
#include "volute/media/field_probe.hpp"
#include "volute/media/fog/fog_file.hpp"
#include "volute/media/parameter.hpp"
#include "volute/scene/scene_edits.hpp"
#include "volute/scene/scene_look.hpp"
#include "volute/viewer/view_scene.hpp"

namespace volute {

/// From where a document wants to be seen first.
struct StartView {
  Vec3 eye = Vec3(0, -1, 0);
  Vec3 target = Vec3::Zero();
  Vec3 up = Vec3::UnitZ();
  double fov = 40;     ///< vertical [degrees]
  double ortho = 0;    ///< [m] > 0: the height of the view volume of a parallel camera, without fov
  bool walks = false;  ///< one is inside: the mouse turns the head
  bool moves = false;  ///< nobody asked for it: moves so that all there is to see is in view
};

/// How a person looks at a document.
using ViewLook = SceneLook;

/// A fog whose map can be painted.
struct FogCanvas {
  std::string name;                ///< of the map's file
  std::string file;                ///< the map's
  double most = 1;                 ///< [1/m], the extinction of a pixel of value 1
  std::optional<FogMedium> fog{};  ///< as it is at 0 s, painted or not
  Vec3 wind = Vec3::Zero();        ///< [m/s],
  FogBorder border{};              ///< and what it brings in
  bool unsaved = false;            ///< it was painted, and no file has it
};

/// What the maps are called that were painted and that no file has: "a.png, b.png"; empty: none.
std::string unsavedMaps(const std::vector<FogCanvas>& canvases);

/// A camera of a capture.
struct ViewStation {
  std::string name;
  StartView view;
};

/// What the fields of a medium are at a place.
struct PlaceFields {
  std::string medium;  ///< "volume: cache.vdb"
  std::vector<ProbedField> fields;
};

/// A snapshot of a document that is to be shown.
struct SceneRequest {
  double time = 0;  ///< [s]
  bool coarse = false;
  bool moving = false;  ///< SnapshotRequest::moving
  bool openGl = true;   ///< OpenGL will draw it: without, what only that needs may be left out
};

/// What an open document says of itself: the loader takes it whenever the document has changed.
struct DocumentInfo {
  std::string title;               ///< "fire.volute, 64 x 64 x 64 voxels, 48 frames"
  Box3 bounds;                     ///< finite [m]
  std::vector<double> times{0.0};  ///< [s] when frames begin; one at least
  /// What a person calls each of the frames, where that is not their count.
  std::vector<int> numbers{};
  Box3 content = bounds;             ///< around what there is to see, within `bounds` [m]
  double firstTime = times.front();  ///< when there is something to see [s]
  bool grey = false;                 ///< one channel: colour maps apply
  bool rests = false;                ///< nothing moves, but for the camera
  bool interpolates = false;         ///< between `times`; else each holds until the next
  bool measured = false;             ///< what is seen is as bright as it says: no exposure
  bool burns = false;                ///< what burns may be brighter than white
  std::optional<StartView> startView{};
  std::vector<CameraKey> cameraKeys{};  ///< the camera's path, by ascending times
  std::optional<ViewLook> look{};
  Rgb background = Rgb::Zero();
  std::vector<std::string> remarks{};  ///< what is not shown
  std::vector<Parameter> parameters{};
  std::vector<FogCanvas> canvases{};
  std::vector<ViewStation> stations{};
  std::string sceneName{};  ///< where save() would go unless a person says otherwise
  bool editable = false;    ///< edit() works
  bool changed = false;     ///< it is no longer what its file, or the last one that was saved, says
  bool overwritten = false;               ///< others have written the file since it was read
  std::string unsaved{};                  ///< then the scene, as a file anywhere has it
  bool canUndo = false, canRedo = false;  ///< what set() and edit() did
  std::uint64_t snapshotMemory = std::uint64_t{256} << 20;  ///< for snapshots that are kept [bytes]
  std::string path{};                                       ///< as it was opened
  std::string files{};  ///< stands for its files as they were read
  int opened = 0;       ///< how many documents were opened before; the same after a change
};

/// A file that the viewer shows. Only the loader's thread calls it, one call at a time, once it is
/// open.
class Document {
 public:
  virtual ~Document() = default;

  /// All but `path`, `files` and `opened`. It changes with set(), edit() and check() alone.
  virtual DocumentInfo info() const = 0;

  /// To be watched, whether they are there or not.
  virtual std::vector<std::filesystem::path> files() const = 0;

  /// Goes on with what was done to `before`, the same file as it was read earlier: unsaved changes,
  /// and what can be undone. Says in a sentence where that is not what the file says now, else
  /// nothing. An error: the files no longer hold what `before` shows of them.
  [[nodiscard]] virtual Result<std::string> goOnFrom(const Document& before, Progress& progress) {
    (void)before, (void)progress;
    return "";
  }

  /// Whether check() has nothing to look for.
  virtual bool checked() const { return true; }

  /// Looks for damage that only reading whole files finds; it then is in the title and the remarks.
  /// Nothing waits for it: where `progress` cancels it, it is asked again when there is time.
  virtual void check(Progress& progress) { (void)progress; }

  /// Whether a coarse scene at this time is there much sooner than the fine one.
  virtual bool coarseHelps(double time) const {
    (void)time;
    return false;
  }

  /// What all fields of its files are at a place and a time [s], shown or not.
  [[nodiscard]] virtual Result<std::vector<PlaceFields>> fieldsAt(double time, const Vec3& place) {
    (void)time, (void)place;
    return std::vector<PlaceFields>();
  }

  [[nodiscard]] virtual Result<ViewScene> sceneAt(const SceneRequest& request,
                                                  Progress& progress) = 0;

  /// The document as it is now, which later changes leave alone: for jobs that take long. The same
  /// thread calls both. Null where no change alters pictures.
  virtual std::shared_ptr<Document> frozen() const { return nullptr; }

  /// Changes one of DocumentInfo::parameters. An error leaves all as it was.
  [[nodiscard]] virtual Status set(const std::string& path, const std::vector<double>& value,
                                   Progress& progress) {
    (void)value, (void)progress;
    return fail(ErrorCode::kUnsupported, "{} cannot be changed", path);
  }

  /// Says in a sentence what was done. An error leaves all as it was.
  [[nodiscard]] virtual Result<std::string> edit(const SceneEdit& edit, Progress& progress) {
    (void)edit, (void)progress;
    return fail(ErrorCode::kUnsupported, "this document has no signs and lights");
  }

  /// Adds what another file holds; says so in a sentence.
  [[nodiscard]] virtual Result<std::string> add(const std::string& path, Progress& progress) {
    (void)progress;
    return fail(ErrorCode::kUnsupported, "{}: nothing can be added to this document", path);
  }

  /// Nothing where there is nothing to take back.
  [[nodiscard]] virtual Status undo(Progress& progress) {
    (void)progress;
    return {};
  }

  [[nodiscard]] virtual Status redo(Progress& progress) {
    (void)progress;
    return {};
  }

  /// Replaces the map of one of the canvases until it is saved or the document closed [1/m].
  /// @param unsaved  it is not what a file holds
  [[nodiscard]] virtual Status setFogMap(std::size_t canvas, std::vector<double> coefficients,
                                         bool unsaved) {
    (void)canvas, (void)coefficients, (void)unsaved;
    return fail(ErrorCode::kUnsupported, "there is no map of fog");
  }

  /// Writes a scene file that shows this document as it is now.
  [[nodiscard]] virtual Status save(const std::string& target, const StartView& view,
                                    const ViewLook& look) {
    (void)view, (void)look;
    return fail(ErrorCode::kUnsupported, "{}: this document cannot be saved", target);
  }

  /// Writes the map of a canvas: a picture of 0..1.
  [[nodiscard]] virtual Status saveFogMap(std::size_t canvas, const std::string& target,
                                          const Image& map) {
    (void)canvas, (void)map;
    return fail(ErrorCode::kUnsupported, "{}: there is no map of fog", target);
  }
};

using OpenDocument =
    std::function<Result<std::unique_ptr<Document>>(const std::string& path, Progress& progress)>;

}  // namespace volute
