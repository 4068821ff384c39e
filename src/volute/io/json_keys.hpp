// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// An error with file and line where a member is in its object twice, of which parsers keep the
/// last one, or an object has too many. Of text that is no JSON it may find nothing.
[[nodiscard]] Status checkJsonKeys(std::string_view text, const std::string& file,
                                   std::size_t mostMembers = SIZE_MAX);

}  // namespace volute
