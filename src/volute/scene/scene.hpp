// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/io/kept_json.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/scene/scene_file.hpp"
#include "volute/scene/scene_snapshot.hpp"

namespace volute {

/// How a scene is opened.
struct SceneOptions {
  std::uint64_t maxMemory = std::uint64_t{4} << 30;  ///< [bytes]
  OpenOptions files{};
  /// Members of the medium of a file that is not a scene, as in a scene's entry.
  KeptJson<nlohmann::ordered_json> members{};
  /// Members that override those of all media whose kind has them.
  KeptJson<nlohmann::ordered_json> overrides{};
  /// Instead of the scene's "scattering": lamps' light is scattered more than once.
  std::optional<bool> multiple{};
  /// Make assumptions about what only the user knows of such a file, so that it can be shown.
  bool assume = false;
};

/// Whether it is a scene file and not a medium alone, by its name.
bool isScenePath(const std::string& path);

/// Media, surfaces, lights, signs and a camera. It is opened from a file of any kind; at() gives a
/// SceneSnapshot. Its state is its JSON: changes are made there and read back. Call it from one
/// thread at a time; Snapshots are independent of it.
class Scene {
 public:
  /// Opens a scene file, or a scene that shows only the given file. Errors name the file and the
  /// place in it. Remarks made while media are opened go once to `progress`.
  [[nodiscard]] static Result<Scene> open(const std::string& path, const SceneOptions& options,
                                          Progress& progress);

  /// From the JSON of a file `file`, which need not exist.
  [[nodiscard]] static Result<Scene> make(nlohmann::ordered_json json, const std::string& file,
                                          const SceneOptions& options, Progress& progress);

  /// The options it was opened with.
  const std::string& path() const { return path_; }

  /// Whether path() is a scene file, not a medium alone.
  bool isFile() const { return isFile_; }

  const nlohmann::ordered_json& json() const { return *json_; }

  const SceneDescription& description() const { return description_; }

  /// In the order of description().media.
  std::span<const std::shared_ptr<SceneMedium>> media() const { return media_; }

  /// The scene's own surfaces.
  const TriangleScene& geometry() const { return geometry_; }

  /// All opaque surfaces at the last time requested.
  const TriangleScene& surfaces() const { return surfaces_; }

  /// Finite bounds of the visible content [m]; unbounded media are cut off near the rest.
  Box3 bounds() const;

  /// What of them a camera is to frame: not where fog fades away.
  Box3 framed() const;

  /// Times of its frames [s]: a medium's own if it is alone, else 25 per second; at least one.
  std::vector<double> times() const;

  /// The law requested by its media, or set by setLaw().
  PictureLaw law() const;

  void setLaw(const PictureLaw& law) { law_ = law; }

  /// The scene's camera, or that of a medium alone; nothing: use one that frames bounds().
  std::optional<CameraDescription> camera() const;

  /// From where pictures that measure nothing will see it: SceneMedium::chooseLook(), of media that
  /// later changes open too.
  void setViews(std::vector<Camera> views);

  /// The scene at request.time; request.factor is that of law().
  [[nodiscard]] Result<SceneSnapshot> at(const SnapshotRequest& request, Progress& progress);

  /// Changes the scene to `json`. Data already read are reused where entries do not change. An
  /// error leaves everything unchanged.
  [[nodiscard]] Status change(nlohmann::ordered_json json, Progress& progress);

  /// Parameters a user may change, in the order of the file: media, lights, signs, the background.
  std::vector<Parameter> parameters() const;

  /// The JSON with a new value of one of parameters() and all dependent changes: media of a kind
  /// share the values of MediumKind::shares(), a sign that emits light loses its own C.
  /// kInvalidArgument for an unknown path.
  [[nodiscard]] Result<nlohmann::ordered_json> with(const std::string& path,
                                                    const std::vector<double>& value) const;

  /// Revises the assumptions about a file alone if the values read since contradict
  /// them.
  [[nodiscard]] Status reconsider(Progress& progress);

  /// The assumptions about a file alone; empty: none.
  const std::string& assumption() const { return assumption_; }

  /// Names of all files it is read from, whether they exist or not.
  std::vector<std::string> files() const;

  /// Puts another medium of the same entry in the place of one, which stays as it is.
  void replace(std::size_t i, std::shared_ptr<SceneMedium> medium) {
    media_[i] = std::move(medium);
  }

  /// Changes only the name of a map in the JSON.
  void note(nlohmann::ordered_json json);

 private:
  Scene() = default;

  [[nodiscard]] Status checkLaws() const;
  Box3 boundsOf(Box3 (*ofMedium)(const MediumInfo&)) const;
  void chooseScattering(SceneDescription& description, Progress& progress) const;
  [[nodiscard]] Result<std::vector<std::shared_ptr<SceneMedium>>> openMedia(
      const SceneDescription& description, bool sameLights, Progress& progress);
  [[nodiscard]] Status placeSurfaces(const SnapshotRequest& request);
  /// Adds media that glow as lamps for the others.
  void shine(SceneSnapshot& snapshot, Progress& progress);

  std::string path_;  ///< names in the JSON are found from its folder
  bool isFile_ = true;
  SceneOptions options_;
  KeptJson<nlohmann::ordered_json> json_;
  SceneDescription description_;
  std::vector<std::shared_ptr<SceneMedium>> media_;
  TriangleScene geometry_;  ///< the scene's own
  std::string assumption_;
  std::optional<PictureLaw> law_;
  std::vector<Camera> views_;  ///< setViews()
  bool toldOfGlow_ = false;
  TriangleScene surfaces_;                 ///< all that is opaque,
  std::vector<std::uint64_t> surfacesOf_;  ///< SceneMedium::surfacesKey() of it
};

/// SnapshotRequest::eye of a camera: for parallel rays, a point far behind everything [m].
Vec3 seenFrom(const Camera& camera);

}  // namespace volute
