// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "volute/grid/array_source.hpp"

namespace volute {

/// Volumes in memory, which scenes name as they name files: OpenOptions::volumes. Their numbers
/// must not change while a scene shows them; a scene that is to show others gives them another
/// name.
class MemoryVolumes {
 public:
  /// What the name of such a volume begins with, so that it is no file's.
  static constexpr std::string_view kPrefix = "memory:";

  /// @param name  without kPrefix; one that is there is replaced
  [[nodiscard]] Status add(const std::string& name, VolumeInfo info, NumberArray array);

  /// Whether a scene's file name is that of a volume in memory.
  static bool isName(const std::string& file);

  /// All of `other`.
  void add(const MemoryVolumes& other);

  /// The volume that a scene's file name means, its folder aside; null: none.
  std::unique_ptr<FrameSource> open(const std::string& file) const;

 private:
  struct Volume {
    VolumeInfo info;
    NumberArray array;
  };

  std::map<std::string, Volume> volumes_;  // by the whole name
};

}  // namespace volute
