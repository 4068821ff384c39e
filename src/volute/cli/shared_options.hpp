// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/cli/arguments.hpp"
#include "volute/cli/option.hpp"
#include "volute/film/picture_writer.hpp"

// Options that several commands have. `kinds` as in Option, empty: all.

namespace volute::cli {

/// -o, --output of one file or a pattern.
/// @param derived  as Option::derived; empty: the option is required
Option outputOption(std::string_view value, std::string help, std::string_view derived = {});

/// --frames by their numbers.
Option framesOption(std::string help = "frames with numbers A <= n < B, every S-th",
                    std::vector<std::string_view> kinds = {});

/// --fps, of a sequence or a film.
Option rateOption(std::string help, std::string initial = {},
                  std::vector<std::string_view> aliases = {});

/// The same of files that are read, not of a film.
Option filesRateOption(std::vector<std::string_view> kinds = {});

/// --field of what has several.
Option fieldOption(std::string help, std::vector<std::string_view> kinds = {});

/// The same where several may be named.
Option fieldsOption(std::string help, std::vector<std::string_view> kinds = {});

/// --partial: damaged .volute files.
Option partialOption(std::vector<std::string_view> kinds = {});

/// --rms of a .volute.
Option rmsOption(std::string help, std::string initial = "");

/// --rays-per-pixel of pictures that are projected.
Option raysOption();

/// --film-bits, --film-quality and --half.
std::vector<Option> fileStyleOptions();

/// Sets what they say; kInvalidArgument where they are given and the target is of another kind.
[[nodiscard]] Status takeFileStyle(const Arguments& arguments, const std::string& target,
                                   Development& development);

/// --smoke-method of OpenGL.
Option smokeMethodOption(std::string help, std::vector<std::string_view> kinds = {});

}  // namespace volute::cli
