// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// Before long work: whether a file can be written there. Its folder must be there and writable,
/// and the target must be no folder and no device. "-" is allowed where `standardOutput` says so.
/// kIo, with what to do, else.
[[nodiscard]] Status checkOutput(const std::string& target, bool standardOutput = false);

/// A name for what is made of `input`, in the current folder: "cache_%04d.vdb" and ".volute" are
/// cache.volute, or cache_2.volute where that is there.
std::string derivedOutput(const std::string& input, std::string_view end);

}  // namespace volute
