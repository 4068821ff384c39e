// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace volute {

/// The desktop's own dialog to choose a file, as a program beside this one (zenity or kdialog,
/// whatever $PATH has), which the window does not wait for.
class DesktopDialog {
 public:
  /// Null where neither program is there, or it does not start.
  static std::unique_ptr<DesktopDialog> open(const std::filesystem::path& folder);

  ~DesktopDialog();  ///< closes it
  DesktopDialog(const DesktopDialog&) = delete;
  DesktopDialog& operator=(const DesktopDialog&) = delete;

  /// Nothing while it is open; then the file, or an empty name where a person chose none.
  std::optional<std::string> poll();

 private:
  DesktopDialog(int process, int output) : process_(process), output_(output) {}

  int process_, output_;
  std::string answer_;
};

/// An entry of a folder in the viewer's own list.
struct FolderEntry {
  std::string name;
  bool folder = false;
  bool known = false;  ///< the viewer opens files that are called so
};

/// Extensions of files that the viewer opens.
std::span<const std::string_view> knownExtensions();

/// Whether a file's name has one of them.
bool isKnown(const std::filesystem::path& path);

/// Folders first, then files that may be opened, then others, each by name; without hidden ones.
/// What cannot be read has no entries. At most `most`.
std::vector<FolderEntry> folderEntries(const std::filesystem::path& folder,
                                       std::size_t most = 2000);

/// Files that were opened, the last one first, in a file that holds a name in each line. Without a
/// file nothing is remembered; one that cannot be written is no error.
class RecentFiles {
 public:
  explicit RecentFiles(std::filesystem::path file = {});

  const std::vector<std::string>& names() const { return names_; }

  /// Remembers the absolute name.
  void add(const std::string& name);

  /// $XDG_STATE_HOME/volute/recent, or its usual place.
  static std::filesystem::path usualFile();

 private:
  static constexpr std::size_t kMax = 10;

  std::filesystem::path file_;
  std::vector<std::string> names_;
};

}  // namespace volute
