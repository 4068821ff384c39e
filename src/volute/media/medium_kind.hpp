// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/lighting/light_cache.hpp"
#include "volute/lighting/light_memory.hpp"
#include "volute/media/field_sliders.hpp"
#include "volute/media/reading.hpp"
#include "volute/media/scene_lights.hpp"
#include "volute/media/scene_medium.hpp"
#include "volute/media/sight.hpp"

namespace volute {

/// How the files of a scene are read, whatever is in them.
struct OpenOptions {
  bool partial = false;  ///< damaged files are read as far as they are whole
  bool verify = true;    ///< with `partial`: looks through them first, and says what is missing
  /// What files do not say is as it is measured, not as it looks best: their own basis.
  bool measured = true;
  std::optional<LightCache> lightCache{};     ///< where the light of lamps is looked for and kept
  std::shared_ptr<LightMemory> lightMemory{};  ///< asked before; may be null
  /// Whose ranks hold a share each of meshes in pieces and draw pictures together, by calling the
  /// same in the same order; null: this process holds all.
  Team* holders = nullptr;
};

/// What a medium is opened in.
struct MediumContext {
  Reading& reading;
  const OpenOptions& options;
  const SceneLights& lights;
  const TriangleScene& geometry;  ///< the scene's own: it stands in the light
  const std::string& file;        ///< of the scene; names of files are found from its folder
  std::string path;               ///< of the medium in it: "/media/0"
  /// What was read before in this place of the scene; null: nothing.
  std::shared_ptr<SceneMedium> before{};
  /// All that was read before and that nobody has taken yet.
  std::vector<std::shared_ptr<SceneMedium>>* earlier = nullptr;

  /// One of `earlier` of a type, which is what `serves` says: rather `before` than another. Nobody
  /// else gets it.
  template <class M, class Serves>
  std::shared_ptr<M> take(Serves&& serves) {
    if (!earlier)
      return nullptr;
    std::shared_ptr<M> found;
    for (const auto& medium : *earlier) {
      auto one = std::dynamic_pointer_cast<M>(medium);
      if (one && serves(*one) && (!found || medium == before))
        found = std::move(one);
    }
    std::erase(*earlier, found);
    return found;
  }
};

struct FileDescription;

/// What describe() is asked for besides what every description has.
struct DescribeRequest {
  std::string field{};  ///< which grid of a file with several, which source of a case; empty: the usual
  bool values = false;  ///< reads everything for its range
  bool blocks = false;  ///< of what is stored in blocks, each block
};

/// A kind of medium: how one is written down, found in a file, opened and changed by a person.
class MediumKind {
 public:
  virtual ~MediumKind() = default;

  /// What an entry may say. Its members are all that is known of the kind by name: in files, in
  /// options, in the schema, and as what a person may change.
  virtual const FieldTable& fields() const = 0;

  /// Of "kind" in a scene's media.
  std::string_view name() const { return fields().says.empty() ? fields().name : fields().says; }

  /// For people: "volumes of voxels", "a volume of voxels".
  std::string_view plural() const { return fields().things; }
  std::string_view singular() const { return fields().thing; }

  /// Which list of the scene it stands in.
  virtual std::string_view list() const { return "media"; }

  /// Among kinds of the same name: whether an entry is one of these, by the patterns of its members.
  bool claims(const nlohmann::json& entry) const;

  /// Errors name the file and the place in it, members that are unknown included.
  [[nodiscard]] virtual Result<std::shared_ptr<SceneMedium>> open(const nlohmann::json& entry,
                                                                  MediumContext& context) const = 0;

  /// The same as sight lines ask for it; by default along rays through what open() gives.
  [[nodiscard]] virtual Result<std::unique_ptr<SightField>> openSight(const nlohmann::json& entry,
                                                                      MediumContext& context) const;

  /// Whether a file alone, by its name, is one of these.
  virtual bool opens(const std::string& path) const {
    (void)path;
    return false;
  }

  /// What is in such a file, for people and programs. By default its name and kind alone.
  [[nodiscard]] virtual Result<FileDescription> describe(const std::string& path,
                                                         const DescribeRequest& request,
                                                         Reading& reading) const;

  /// Whether such a file says too little to be shown without assume().
  virtual bool assumes() const { return false; }

  /// A scene that shows such a file and nothing else; `name` is what the scene calls it.
  virtual nlohmann::ordered_json sceneOf(const std::string& name) const;

  /// Adds to the entry of such a scene what only a person knows, so that something is seen. Says
  /// what was assumed; empty: nothing.
  virtual std::string assume(nlohmann::ordered_json& scene) const {
    (void)scene;
    return "";
  }

  /// What the values of such a file, of which some were read, tell of what assume() assumed: changes
  /// its entry and says why; empty: nothing.
  virtual std::string guess(nlohmann::ordered_json& entry, const SceneMedium& medium) const {
    (void)entry, (void)medium;
    return "";
  }

  /// Other entries that may be meant where one cannot be opened; the first that can is taken.
  virtual std::vector<nlohmann::ordered_json> alternatives(
      const nlohmann::ordered_json& entry) const {
    (void)entry;
    return {};
  }

  /// Adds what a person may change about one. By default the sliders of what the entry says.
  virtual void addParameters(ParameterGroup& group, const nlohmann::ordered_json& entry,
                             const SceneMedium& medium, MediumFacts facts) const;

  /// Sets a value in an entry that more than one of its numbers stand for, or that other values
  /// must go with. False, with nothing done, for all others.
  /// @param key  below the entry: "transform/turn"
  /// @param value  as jsonOf() gives it; `numbers` as the person set them
  virtual bool setParameter(nlohmann::ordered_json& entry, const SceneMedium& medium,
                            const std::string& key, const nlohmann::ordered_json& value,
                            const std::vector<double>& numbers) const {
    (void)entry, (void)medium, (void)key, (void)value, (void)numbers;
    return false;
  }

  /// Of a Parameter that is an entry of a list: it is there twice, or no more. Says in a sentence
  /// what was done; nothing where the key names none.
  [[nodiscard]] virtual Result<std::optional<std::string>> editEntry(nlohmann::ordered_json& entry,
                                                                     const std::string& key,
                                                                     bool more) const {
    (void)entry, (void)key, (void)more;
    return std::nullopt;
  }

  /// Whether all media of this kind in a scene share a value.
  virtual bool shares(const std::string& key) const {
    (void)key;
    return false;
  }
};

/// All kinds there are, in the order in which files are asked for.
std::vector<const MediumKind*>& mediumKinds();

/// Adds a kind; it must live as long as the program.
void registerMedium(const MediumKind& kind);

/// That of an entry of a list; kInvalidData, which lists the names, where there is none.
[[nodiscard]] Result<const MediumKind*> mediumKindOf(const nlohmann::json& entry,
                                                     std::string_view list,
                                                     const std::string& file,
                                                     const std::string& path);

/// That of a file alone, by its name. Null: none.
/// @param assuming  kinds that say too little alone count as well
const MediumKind* mediumKindOf(const std::string& path, bool assuming);

}  // namespace volute
