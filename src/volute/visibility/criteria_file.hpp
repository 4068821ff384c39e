// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/tenability/criterion.hpp"

namespace volute {

/// Criteria of a file: {"criteria": [{"kind": "temperature", "limit": 60}, {"kind": "fed-gas",
/// "model": "sfpe", "activity": "light", "limit": 0.3}, {"kind": "visibility", "C": 3, "limit":
/// 10}]}. A kind is a quantity (tenability/exposure.hpp), "visibility", "fed-gas", "fed-heat" or
/// "fec". Errors name the place in the file.
[[nodiscard]] Result<std::vector<Criterion>> readCriteria(const std::string& file);

/// "usual", "none", or those of a file.
[[nodiscard]] Result<std::vector<Criterion>> criteriaOf(const std::string& which);

}  // namespace volute
