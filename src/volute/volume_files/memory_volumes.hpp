// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "volute/grid/array_source.hpp"
#include "volute/grid/function_source.hpp"
#include "volute/io/memory_mesh.hpp"

namespace volute {

/// Volumes and meshes in memory, or volumes of functions, which scenes name as they name files:
/// OpenOptions::volumes.
/// Their numbers must not change while a scene shows them; a scene that is to show others gives
/// them another name.
class MemoryVolumes {
 public:
  /// What the name of such a volume begins with, so that it is no file's.
  static constexpr std::string_view kPrefix = "memory:";

  /// @param name  without kPrefix; one that is there is replaced
  [[nodiscard]] Status add(const std::string& name, VolumeInfo info, NumberArray array);

  /// The values of a function at the centres of voxels, asked for when a frame is needed.
  [[nodiscard]] Status add(const std::string& name, VolumeInfo info, ValueFunction value);

  /// A mesh, which is called kPrefix NAME.vtu, as the files are that scenes show as such; one that
  /// is there is replaced.
  [[nodiscard]] Status add(const std::string& name, MemoryMesh mesh);

  /// Whether a scene's file name is that of a volume in memory.
  static bool isName(const std::string& file);

  /// All of `other`.
  void add(const MemoryVolumes& other);

  /// Lets go of all but those of these names, which are without kPrefix.
  void keep(std::span<const std::string> names);

  /// The volume that a scene's file name means, its folder aside; null: none.
  std::unique_ptr<FrameSource> open(const std::string& file) const;

  /// The mesh that a scene's file name means, its folder aside; null: none.
  std::shared_ptr<const MemoryMesh> mesh(const std::string& file) const;

 private:
  struct Volume {
    VolumeInfo info;
    std::variant<NumberArray, ValueFunction> values;
  };

  Status take(const std::string& name, Volume volume);

  std::map<std::string, Volume> volumes_;                            // by the whole name
  std::map<std::string, std::shared_ptr<const MemoryMesh>> meshes_;  // likewise
};

}  // namespace volute
