// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "volute/viewer/file_dialog.hpp"
#include "volute/viewer/moved_file.hpp"

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
    std::string loses{};  ///< a sentence; empty: what it holds
  };

  /// What a person chooses a file for.
  enum class Purpose { kOpen, kAdd, kCompare, kFind };

  /// @param recent  names of files that were opened are kept here; empty: they are not kept
  /// @param desktop  the desktop's dialog is used, where there is one
  DocumentFiles(const std::filesystem::path& recent, bool desktop)
      : desktop_(desktop), recent_(recent) {}

  /// What is open: others are looked for beside it, and it may be written, unless somebody else
  /// wrote it meanwhile.
  void setOpen(const std::string& path, bool overwritten) {
    open_ = path;
    overwritten_ = overwritten;
    if (overwritten)
      allowed_.erase(path);
  }

  /// Lets the person choose a file, by the desktop's dialog or by the list.
  void askToOpen(Purpose purpose = Purpose::kOpen);

  /// The purpose for which a file is being chosen.
  Purpose purpose() const { return purpose_; }

  /// What was chosen in the desktop's dialog, once.
  std::optional<std::string> takeChosen();

  /// A file that a scene names which could not be opened, until the person has answered.
  const MovedFile* moved() const { return moved_ ? &*moved_ : nullptr; }

  void setMoved(std::optional<MovedFile> file) { moved_ = std::move(file); }

  /// The person looks for it.
  void findMoved();

  /// Takes the file to look for, once.
  std::optional<MovedFile> takeSought() { return std::exchange(sought_, std::nullopt); }

  /// Opens the list, or shows another folder in it.
  void browse(const std::filesystem::path& folder);

  Browser* browser() { return browser_ ? &*browser_ : nullptr; }

  void closeBrowser() { browser_.reset(); }

  RecentFiles& recent() { return recent_; }

  /// Whether `target` may be written now: it does not exist, is open, or was written before. Else
  /// the person is asked, and `then` is called by replace().
  /// @param loses  what is lost, in a sentence: then it is asked though `target` is open
  bool mayWrite(const std::string& target, std::function<void()> then,
                const std::string& loses = {});

  /// The person said that this file may be written.
  void allow(const std::string& target) { allowed_.insert(target); }

  const Replacing* replacing() const { return replacing_ ? &*replacing_ : nullptr; }

  /// The answers.
  void replace();

  void keep() { replacing_.reset(); }

  /// Whether a question or the list waits for an answer.
  bool asks() const { return replacing_ || browser_ || moved_; }

 private:
  bool desktop_ = false;
  std::string open_;
  bool overwritten_ = false;
  Purpose purpose_ = Purpose::kOpen;
  std::optional<MovedFile> moved_, sought_;
  std::set<std::string> allowed_;
  std::optional<Replacing> replacing_;
  std::optional<Browser> browser_;
  std::unique_ptr<DesktopDialog> dialog_;
  RecentFiles recent_;
};

}  // namespace volute
