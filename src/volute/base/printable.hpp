// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace volute {

/// Text as a terminal may get it, names from strangers' files included: control characters but
/// line ends and tabs, and what turns the direction of writing, become u001b, u202e and the like
/// with a backslash, as JSON writes them (which stays JSON); bytes that are no UTF-8 become x80.
std::string printable(std::string_view text);

/// The same for messages, which are one line or indent those that follow: no name can begin a line
/// that looks like a message of its own.
std::string printableMessage(std::string_view text);

/// Adds a character by its number in Unicode.
void appendUtf8(std::string& text, std::uint32_t code);

/// In UTF-8: text that is none is taken as Latin-1, which names of older files are in.
std::string asUtf8(std::string_view text);

}  // namespace volute
