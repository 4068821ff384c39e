// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/io/reading.hpp"
#include "volute/media/field_sliders.hpp"
#include "volute/media/scene_lights.hpp"
#include "volute/media/scene_medium.hpp"
#include "volute/media/sight.hpp"

namespace volute {

/// The format of scenes that are written. Volutes of before wrote 1, whose scenes keep their
/// meaning; from 2 on a medium looks in a scene as its file does alone.
inline constexpr int kSceneVersion = 2;
inline constexpr std::string_view kSceneFormat = "volute-scene-2";

/// The version that a scene's "format" names; nothing when it is none that can be read.
std::optional<int> sceneVersionOf(const nlohmann::json& format);

class LightCache;
class LightMemory;

/// How the files of a scene are read, for all kinds of media.
struct OpenOptions {
  bool partial = false;  ///< read the intact part of damaged files
  bool verify = true;    ///< with `partial`: check them first, and report what is missing
  /// Defaults for measurements instead of appearance: the files' own basis.
  bool measured = true;
  bool sightOnly = false;  ///< for SceneMedium::sight() only: data for pictures are not read
  /// Optical depths are measured: an extinction that nobody states is what the unit of the values
  /// says, before what a look makes of them.
  bool depths = false;
  bool byTree = false;  ///< pictures are drawn from the tree, which holds values and no light
  std::shared_ptr<const LightCache> lightCache{};  ///< on disk, for the light of lamps; may be null
  std::shared_ptr<LightMemory> lightMemory{};      ///< consulted before it; may be null
  /// The team whose ranks each hold a share of a mesh in pieces and draw pictures together, with
  /// the same calls in the same order; null: this process holds everything.
  Team* team = nullptr;
  std::shared_ptr<const MemoryVolumes> volumes{};  ///< in memory, as Reading::volumes; may be null
};

/// The context in which a medium is opened.
struct MediumContext {
  Reading& reading;
  const OpenOptions& options;
  const SceneLights& lights;
  const TriangleScene& geometry;  ///< the scene's own surfaces, which block light
  const std::string& file;        ///< of the scene; file names are relative to its folder
  std::string path;               ///< of the medium in it: "/media/0"
  int version = kSceneVersion;    ///< of the scene's format
  /// The medium previously read for this entry of the scene; null: none.
  std::shared_ptr<SceneMedium> before{};
  /// All previously read media that have not been reused yet.
  std::vector<std::shared_ptr<SceneMedium>>* earlier = nullptr;

#ifdef __cpp_rtti
  /// One of `earlier` of a type for which `serves` is true, preferably `before`. It is then removed
  /// from the list.
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
#endif
};

struct FileDescription;

/// Optional parts of describe().
struct DescribeRequest {
  std::string field{};  ///< grid of a file with several, or source of a case; empty: the default
  bool values = false;  ///< read all values to report their range
  bool blocks = false;  ///< list each block of data stored in blocks
  std::optional<double> framesPerSecond{};  ///< of a sequence, instead of the times of its files
};

/// A kind of medium: its syntax in scenes, its files, and how it is opened and changed by a user.
class MediumKind {
 public:
  virtual ~MediumKind() = default;

  /// The members of an entry. They define all names of the kind: in files, in options, in the
  /// schema and in the viewer's sliders.
  virtual const FieldTable& fields() const = 0;

  /// The value of "kind" in a scene's media.
  std::string_view name() const { return fields().kind.empty() ? fields().name : fields().kind; }

  /// For people: "volumes of voxels", "a volume of voxels".
  std::string_view plural() const { return fields().things; }

  std::string_view singular() const { return fields().thing; }

  /// The list of the scene that contains its entries.
  virtual std::string_view list() const { return "media"; }

  /// Among kinds of the same name: whether an entry is of this kind, by its members' patterns.
  bool claims(const nlohmann::json& entry) const;

  /// Errors name the file and the place in it, also for unknown members.
  [[nodiscard]] virtual Result<std::shared_ptr<SceneMedium>> open(const nlohmann::json& entry,
                                                                  MediumContext& context) const = 0;

  /// Whether a file alone is of this kind, by its name.
  virtual bool opens(const std::string& path) const {
    (void)path;
    return false;
  }

  /// Describes such a file, for people and programs. By default only its name and kind.
  [[nodiscard]] virtual Result<FileDescription> describe(const std::string& path,
                                                         const DescribeRequest& request,
                                                         Reading& reading) const;

  /// Whether such a file lacks information, so that it cannot be shown without assume().
  virtual bool assumes() const { return false; }

  /// Whether lights that shine from everywhere alike light it.
  virtual bool takesAmbient() const { return true; }

  /// A scene that shows only such a file, under the name `name`.
  virtual nlohmann::ordered_json sceneOf(const std::string& name) const;

  /// Adds assumptions about information that only the user has to the entry of such a scene, so
  /// that it can be shown. Returns a sentence about what was assumed; empty: nothing.
  virtual std::string assume(nlohmann::ordered_json& scene) const {
    (void)scene;
    return "";
  }

  /// Checks the assumptions of assume() against values read since: changes the entry and says why;
  /// empty: no change.
  virtual std::string guess(nlohmann::ordered_json& entry, const SceneMedium& medium) const {
    (void)entry, (void)medium;
    return "";
  }

  /// Alternative entries if one cannot be opened; the first that can be opened is taken.
  virtual std::vector<nlohmann::ordered_json> alternatives(
      const nlohmann::ordered_json& entry) const;

  /// Adds the parameters that a user may change. By default the sliders of the entry's members.
  virtual void addParameters(ParameterGroup& group, const nlohmann::ordered_json& entry,
                             const SceneMedium& medium, MediumFacts facts) const;

  /// Sets a value that is stored in several numbers of an entry, or that other values must follow.
  /// False, with nothing changed, for all other values.
  /// @param key  below the entry: "transform/turn"
  /// @param value  as jsonOf() returns it; `numbers` as set by the user
  virtual bool setParameter(nlohmann::ordered_json& entry, const SceneMedium& medium,
                            const std::string& key, const nlohmann::ordered_json& value,
                            const std::vector<double>& numbers) const {
    (void)entry, (void)medium, (void)key, (void)value, (void)numbers;
    return false;
  }

  /// For a Parameter that is an entry of a list: duplicates or removes it. Returns a sentence about
  /// what was done; nothing if the key names no entry.
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

/// All kinds, in the order in which they are tried for a file.
std::vector<const MediumKind*>& mediumKinds();

/// Registers a kind, which must exist until the program ends.
void registerMedium(const MediumKind& kind);

/// The kind of an entry of a list; kInvalidData, which lists the names, if there is none.
[[nodiscard]] Result<const MediumKind*> mediumKindOf(const nlohmann::json& entry,
                                                     std::string_view list, const std::string& file,
                                                     const std::string& path);

/// The kind of a file alone, by its name. Null: none.
/// @param assuming  also accept kinds whose files need assume()
const MediumKind* mediumKindOf(const std::string& path, bool assuming);

}  // namespace volute
