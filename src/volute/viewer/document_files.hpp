// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "volute/viewer/file_dialog.hpp"

namespace volute {

/// How a person names files to open, and which files may be written without asking.
class DocumentFiles {
 public:
  /// The viewer's own list of files, while it is open.
  struct Browser {
    std::filesystem::path folder;
    std::vector<FolderEntry> entries{};
    std::string name{};
  };

  /// A file that exists and that the person did not name as a target before.
  struct Replacing {
    std::string target;
    std::function<void()> then;
  };

  /// @param recent  names of files that were opened are kept here; empty: they are not kept
  explicit DocumentFiles(const std::filesystem::path& recent) : recent_(recent) {}

  /// Lets the person choose a file, by the desktop's dialog if `desktop` is set and there is one,
  /// else by the list.
  void askToOpen(const std::filesystem::path& folder, bool desktop);

  /// What was chosen in the desktop's dialog, once.
  std::optional<std::string> takeChosen();

  /// Opens the list, or shows another folder in it.
  void browse(const std::filesystem::path& folder);

  Browser* browser() { return browser_ ? &*browser_ : nullptr; }

  void closeBrowser() { browser_.reset(); }

  RecentFiles& recent() { return recent_; }

  const RecentFiles& recent() const { return recent_; }

  /// Whether `target` may be written now: it does not exist, or was written from here before. Else
  /// the person is asked, and `then` is called by replace().
  bool mayWrite(const std::string& target, std::function<void()> then);

  /// The person said that this file may be written.
  void allow(const std::string& target) { allowed_.insert(target); }

  const Replacing* replacing() const { return replacing_ ? &*replacing_ : nullptr; }

  /// The answers.
  void replace();

  void keep() { replacing_.reset(); }

  /// Whether a question or the list waits for an answer.
  bool asks() const { return replacing_ || browser_; }

 private:
  std::set<std::string> allowed_;
  std::optional<Replacing> replacing_;
  std::optional<Browser> browser_;
  std::unique_ptr<DesktopDialog> dialog_;
  RecentFiles recent_;
};

}  // namespace volute
