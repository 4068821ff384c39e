// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <string_view>

namespace volute {

/// Formats text as a cell of a comma-separated table, quoted where necessary; line ends become
/// blanks, other control characters what printable() makes of them. Spreadsheets evaluate text that
/// begins with =, +, -, @, a tab or a line end, and names come from untrusted files: such text gets
/// a leading apostrophe unless it is a finite number.
std::string csvCell(std::string_view text);

}  // namespace volute
