// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// An error but for its code, as text for another process.
std::string packed(const Error& error);
Error unpacked(ErrorCode code, std::string_view text);

}  // namespace volute
