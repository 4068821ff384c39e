// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string_view>

#include "volute/base/result.hpp"
#include "volute/cli/context.hpp"

namespace volute::cli {

/// Becomes the program `name` beside this one, with the same words after the command's name;
/// returns only where it cannot.
/// @param remedy  how a missing one is had: "`./dev bench` builds it".
Status becomeSibling(std::string_view name, std::string_view remedy, const Context& context);

}  // namespace volute::cli
