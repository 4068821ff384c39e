// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/advice.hpp"

#include <fmt/core.h>

namespace volute {
namespace {

/// A member of a scene, "/media/0/up", as it is written there.
std::string memberText(const std::string& member, const std::string& value) {
  const std::size_t slash = member.rfind('/');
  const bool literal =
      value == "true" || value == "false" || value.find_first_of("-0123456789[") == 0;
  return fmt::format("\"{}\"{}{} in {}", member.substr(slash + 1), value.empty() ? "" : ": ",
                     value.empty() || literal ? value : '"' + value + '"', member.substr(0, slash));
}

std::string adviceText(const Hint& hint, const SettingText& name) {
  const bool isValue = hint.change == Hint::Change::kSet;
  const std::string value = isValue ? hint.value : "";
  const std::string text =
      hint.setting.starts_with('/') ? memberText(hint.setting, value) : name(hint.setting, value);
  if (text.empty())
    return "";
  if (!hint.purpose.empty())
    return fmt::format("{} {}", text, hint.purpose);
  const std::string to = isValue || hint.value.empty() ? "" : " to " + hint.value;
  switch (hint.change) {
    case Hint::Change::kSet:
      return fmt::format("{} {}", hint.value.empty() ? "give" : "use", text);
    case Hint::Change::kChoose:
      return fmt::format("choose one with {}", text);
    case Hint::Change::kRaise:
      return fmt::format("raise {}{}", text, to);
    case Hint::Change::kLower:
      return fmt::format("lower {}{}", text, to);
    case Hint::Change::kLeaveOut:
      return fmt::format("leave out {}", text);
  }
  return "";
}

std::string joined(const std::string& sentence, const std::string& advice) {
  return advice.empty() ? sentence : fmt::format("{}; {}", sentence, advice);
}

}  // namespace

std::string adviceText(const Hints& hints, const SettingText& name) {
  std::string all;
  for (const Hint& hint : hints) {
    const std::string one = adviceText(hint, name);
    if (!one.empty())
      all += (all.empty() ? "" : ", or ") + one;
  }
  return all;
}

std::string fullText(const Error& error, const SettingText& name) {
  std::string sentence = error.message;
  if (error.path.empty() && !error.member.empty()) {
    const std::string setting = name(error.member, "");
    sentence = fmt::format("{}: {}", setting.empty() ? error.member : setting, error.message);
  }
  return joined(sentence, adviceText(error.hints, name));
}

std::string fullText(const Remark& remark, const SettingText& name) {
  return joined(remark.sentence, adviceText(remark.hints, name));
}

Error renamed(Error error, std::string_view from, const std::string& to) {
  if (error.member == from)
    error.member = to;
  for (Hint& hint : error.hints) {
    if (hint.setting == from)
      hint.setting = to;
  }
  return error;
}

}  // namespace volute
