// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/document_files.hpp"

namespace volute {

void DocumentFiles::askToOpen(Purpose purpose) {
  purpose_ = purpose;
  if (dialog_)
    return;
  std::error_code unknown;
  const std::filesystem::path folder =
      open_.empty() ? std::filesystem::current_path(unknown)
                    : std::filesystem::absolute(open_, unknown).parent_path();
  if (desktop_)
    dialog_ = DesktopDialog::open(folder);
  if (!dialog_)
    browse(folder);
}

std::optional<std::string> DocumentFiles::takeChosen() {
  if (!dialog_)
    return std::nullopt;
  auto chosen = dialog_->poll();
  if (!chosen)
    return std::nullopt;
  dialog_.reset();
  return chosen->empty() ? std::nullopt : chosen;
}

void DocumentFiles::findMoved() {
  sought_ = std::exchange(moved_, std::nullopt);
  askToOpen(Purpose::kFind);
}

void DocumentFiles::browse(const std::filesystem::path& folder) {
  browser_ = Browser{folder, folderEntries(folder)};
}

bool DocumentFiles::mayWrite(const std::string& target, std::function<void()> then,
                             const std::string& loses) {
  std::error_code unknown;
  if ((target == open_ && !overwritten_ && loses.empty()) || allowed_.contains(target) ||
      !std::filesystem::exists(target, unknown)) {
    allowed_.insert(target);
    return true;
  }
  replacing_ = Replacing{target, std::move(then), loses};
  return false;
}

void DocumentFiles::replace() {
  const Replacing asked = *std::exchange(replacing_, std::nullopt);
  allowed_.insert(asked.target);
  asked.then();
}

}  // namespace volute
