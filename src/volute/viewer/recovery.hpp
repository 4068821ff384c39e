// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace volute {

/// Scenes with changes that no file has, kept in a folder while they are open, so that they can be
/// offered after a viewer ended without asking: each process has a scene there, and beside it the
/// name that it would be saved under.
class Recovery {
 public:
  struct Lost {
    std::filesystem::path scene;
    std::string name;  ///< that it would be saved under
  };

  /// @param folder  empty: nothing is kept
  explicit Recovery(std::filesystem::path folder) : folder_(std::move(folder)) {}

  ~Recovery() {
    keep("", "");
    adopt("");
  }

  const std::filesystem::path& folder() const { return folder_; }

  Recovery(const Recovery&) = delete;
  Recovery& operator=(const Recovery&) = delete;

  /// Keeps the scene, unless it is kept already or the last one was kept just now. False, once,
  /// where it cannot be written.
  /// @param scene  its JSON; empty: there is nothing unsaved
  /// @param name  that it would be saved under
  bool keep(const std::string& scene, const std::string& name);

  /// Keeps a scene that was mended before it could be opened; returns its file.
  std::string keepMended(const std::string& scene, const std::string& name) const;

  /// What processes left that are no longer there.
  std::vector<Lost> lost() const;

  /// It is not wanted.
  static void remove(const Lost& lost);

  /// What is open is one of lost(), or nothing: that goes when something else is open.
  void adopt(const std::string& path);

  /// The name that a scene which was kept here would be saved under; nothing: it is none.
  static std::optional<std::string> nameOf(const std::string& path);

 private:
  std::filesystem::path folder_;
  std::string kept_;    ///< the scene
  bool fails_ = false;  ///< keep() was false
  std::filesystem::path adopted_;
  std::chrono::steady_clock::time_point next_{};
};

}  // namespace volute
