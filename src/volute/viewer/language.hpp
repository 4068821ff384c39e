// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace volute {

/// Of the window's labels, hints and help. Messages, remarks and what is said of members of scenes
/// are English, as in the documentation.
enum class Language { kEnglish, kGerman };

/// What LC_ALL, LC_MESSAGES or LANG ask for.
Language localeLanguage();

/// The language of the window, and where it is kept.
class WindowLanguage {
 public:
  /// @param file  holds the one that a person chose, "en" or "de"; empty: nothing is kept
  explicit WindowLanguage(std::filesystem::path file);

  Language language() const { return language_; }

  void choose(Language language);

  /// The same where there is none: names of files and fields.
  /// @param known  it is one of ours, and missing() has it otherwise
  std::string of(std::string_view english, bool known) const;

  const char* of(const char* english) const;

  /// What was asked for and has no German: for tests.
  const std::set<std::string>& missing() const { return missing_; }

 private:
  const char* find(std::string_view english, bool known) const;

  std::filesystem::path file_;
  Language language_;
  mutable std::set<std::string> missing_;
};

/// A string of ours in the window's language: labels keep what follows "##".
const char* tr(const char* english);
std::string tr(const std::string& english);

/// A string that may be a name that somebody else gave: a choice, a unit, a group.
std::string trName(const std::string& name);

}  // namespace volute
