// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/language.hpp"

#include <imgui.h>

#include <cctype>
#include <cstdlib>
#include <fstream>
#include <map>

#include "volute/viewer/strings_german.hpp"

namespace volute {
namespace {

const std::map<std::string_view, const char*>& german() {
  static const std::map<std::string_view, const char*> kTable(std::begin(kGermanStrings),
                                                              std::end(kGermanStrings));
  return kTable;
}

/// The window's, while ImGui draws it.
const WindowLanguage* current() {
  return ImGui::GetCurrentContext() ? static_cast<const WindowLanguage*>(ImGui::GetIO().UserData)
                                    : nullptr;
}

/// Where " 12" at the end begins.
std::size_t numberAtEnd(std::string_view text) {
  std::size_t at = text.size();
  while (at > 0 && std::isdigit(static_cast<unsigned char>(text[at - 1]))) --at;
  return at < text.size() && at > 1 && text[at - 1] == ' ' ? at - 1 : text.size();
}

}  // namespace

Language localeLanguage() {
  for (const char* name : {"LC_ALL", "LC_MESSAGES", "LANG"}) {
    const char* const value = std::getenv(name);
    if (value && *value)
      return std::string_view(value).starts_with("de") ? Language::kGerman : Language::kEnglish;
  }
  return Language::kEnglish;
}

WindowLanguage::WindowLanguage(std::filesystem::path file)
    : file_(std::move(file)), language_(localeLanguage()) {
  std::string kept;
  if (!file_.empty() && std::ifstream(file_) >> kept && (kept == "de" || kept == "en"))
    language_ = kept == "de" ? Language::kGerman : Language::kEnglish;
}

void WindowLanguage::choose(Language language) {
  language_ = language;
  if (file_.empty())
    return;
  std::error_code ignored;
  std::filesystem::create_directories(file_.parent_path(), ignored);
  std::ofstream(file_) << (language == Language::kGerman ? "de\n" : "en\n");
}

const char* WindowLanguage::find(std::string_view english, bool known) const {
  if (language_ == Language::kEnglish || english.empty())
    return nullptr;
  const auto found = german().find(english);
  if (found != german().end())
    return found->second;
  if (known)
    missing_.emplace(english);
  return nullptr;
}

std::string WindowLanguage::of(std::string_view english, bool known) const {
  const std::size_t label = std::min(english.find("##"), english.size());
  const std::size_t end = numberAtEnd(english.substr(0, label));
  const char* const found = find(english.substr(0, end), known);
  return found ? found + std::string(english.substr(end)) : std::string(english);
}

const char* WindowLanguage::of(const char* english) const {
  const char* const found = find(english, true);
  return found ? found : english;
}

const char* tr(const char* english) {
  const WindowLanguage* language = current();
  return language ? language->of(english) : english;
}

std::string tr(const std::string& english) {
  const WindowLanguage* language = current();
  return language ? language->of(english, true) : english;
}

std::string trName(const std::string& name) {
  const WindowLanguage* language = current();
  return language ? language->of(name, false) : name;
}

}  // namespace volute
