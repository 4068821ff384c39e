// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "volute/base/hint.hpp"
#include "volute/base/remark.hpp"
#include "volute/base/result.hpp"

namespace volute {

/// How an interface writes a setting with a value, which may be empty: "--renderer cpu". Empty: it
/// has no such setting.
using SettingText =
    std::function<std::string(const std::string& setting, const std::string& value)>;

/// "raise --max-memory, or leave out --bounds"; empty where the interface has none of the settings.
/// Members of a scene ("/media/0/up") are named as they stand there by all interfaces.
std::string adviceText(const Hints& hints, const SettingText& name);

/// The sentence with the setting that it is about and the advice.
std::string fullText(const Error& error, const SettingText& name);
std::string fullText(const Remark& remark, const SettingText& name);

/// The same of an interface, or a part of it, that calls the setting `from` otherwise.
[[nodiscard]] Error renamed(Error error, std::string_view from, const std::string& to);

}  // namespace volute
