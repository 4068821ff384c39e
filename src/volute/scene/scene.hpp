// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/media/medium_kind.hpp"
#include "volute/scene/scene_file.hpp"
#include "volute/scene/snapshot.hpp"

namespace volute {

/// How a scene is opened.
struct SceneOptions {
  std::uint64_t maxMemory = std::uint64_t{4} << 30;  ///< [bytes]
  OpenOptions files{};
  /// Members of the medium of a file that is no scene: what the scene it stands for would say.
  nlohmann::ordered_json members = nlohmann::ordered_json::object();
  /// Members that all media have instead of their own, if they are of a kind that has them.
  nlohmann::ordered_json overrides = nlohmann::ordered_json::object();
  /// What only a person knows of such a file is assumed, so that something is seen.
  bool assume = false;
};

/// By its name: a scene file, not a medium alone.
bool isScenePath(const std::string& path);

/// Everything that a picture is of: media, surfaces, lights, signs, and a camera. It is opened from
/// a file of any kind; at() gives an instant of it. Its JSON is what it is: changes go into that
/// and are read back. One thread at a time calls it; Snapshots are free of it.
class Scene {
 public:
  /// A scene file, or a scene that shows any other file and nothing else. Errors name the file and
  /// the place in it. What is remarked on while media are opened is told once to `progress`.
  [[nodiscard]] static Result<Scene> open(const std::string& path, const SceneOptions& options,
                                          Progress& progress);

  /// From JSON that a file `file`, which need not be there, would hold.
  [[nodiscard]] static Result<Scene> make(nlohmann::ordered_json json, const std::string& file,
                                          const SceneOptions& options, Progress& progress);

  /// As it was opened.
  const std::string& path() const { return path_; }

  /// Whether path() is a scene file, not a medium alone.
  bool isFile() const { return isFile_; }

  const nlohmann::ordered_json& json() const { return json_; }

  const SceneDescription& description() const { return description_; }

  /// In the order of description().media.
  std::span<const std::shared_ptr<SceneMedium>> media() const { return media_; }

  /// Its own.
  const TriangleScene& geometry() const { return geometry_; }

  /// All that was opaque at the last instant.
  const TriangleScene& surfaces() const { return surfaces_; }

  /// Around all that is to be seen, finite [m]; what has no end above or below ends near the rest.
  Box3 bounds() const;

  /// When its frames begin [s]: a medium's own where it is alone, else 25 a second; one at least.
  std::vector<double> times() const;

  /// That its media want to be seen through, or setLaw().
  PictureLaw law() const;

  void setLaw(const PictureLaw& law) { law_ = law; }

  /// The scene's camera, or that of a medium alone; nothing: one that frames bounds().
  std::optional<CameraDescription> camera() const;

  /// The scene at request.time; request.factor is that of law().
  [[nodiscard]] Result<Snapshot> at(const InstantRequest& request, Progress& progress);

  /// Becomes what `json` says. What was read serves as long as the same is read. An error leaves
  /// everything as it was.
  [[nodiscard]] Status change(nlohmann::ordered_json json, Progress& progress);

  /// What a person may change, in the order of the file: media, lights, signs, the background.
  std::vector<Parameter> parameters() const;

  /// The JSON in which one of parameters() has another value, with whatever must go with it: media
  /// of a kind share what MediumKind::shares(), a sign that emits light drops a C of its own.
  /// kInvalidArgument for a path that none of them has.
  [[nodiscard]] Result<nlohmann::ordered_json> with(const std::string& path,
                                                    const std::vector<double>& value) const;

  /// Takes what was assumed of a file alone for something else where the values that were read since
  /// say so.
  [[nodiscard]] Status reconsider(Progress& progress);

  /// What was assumed of a file alone; empty: nothing.
  const std::string& assumption() const { return assumption_; }

  /// Names of all files that it is read from, whether they are there or not.
  std::vector<std::string> files() const;

  /// The JSON changed without the scene: a map has another name.
  void note(nlohmann::ordered_json json);

 private:
  Scene() = default;

  [[nodiscard]] Status checkLaws() const;
  [[nodiscard]] Result<std::vector<std::shared_ptr<SceneMedium>>> openMedia(
      const SceneDescription& description, bool sameLights, Progress& progress);
  [[nodiscard]] Status placeSurfaces(const InstantRequest& request);
  /// What glows lights the rest.
  void shine(Snapshot& snapshot, Progress& progress);

  std::string path_;  ///< names in the JSON are found from its folder
  bool isFile_ = true;
  SceneOptions options_;
  nlohmann::ordered_json json_;
  SceneDescription description_;
  std::vector<std::shared_ptr<SceneMedium>> media_;
  TriangleScene geometry_;  ///< the scene's own
  std::string assumption_;
  std::optional<PictureLaw> law_;
  bool toldOfGlow_ = false;
  TriangleScene surfaces_;               ///< all that is opaque,
  std::vector<std::uint64_t> surfacesOf_;  ///< SceneMedium::surfacesKey() of it
};

/// InstantRequest::eye of a camera: of parallel rays far behind all that they may meet [m].
Vec3 seenFrom(const Camera& camera);

}  // namespace volute
