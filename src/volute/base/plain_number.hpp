// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

namespace volute {

/// A coordinate [m] or a time [s] in a sentence: so many digits, and hundredths however large it
/// is, for a map's coordinates have seven digits before the point.
std::string plainNumber(double value, int digits = 6);

}  // namespace volute
