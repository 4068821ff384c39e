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
/// "fec"; "room": [from, below] has floor areas. Errors name the place in the file.
[[nodiscard]] Result<std::vector<Criterion>> readCriteria(const std::string& file);

/// A profile by its name, nothing for "none", or those of a file.
[[nodiscard]] Result<CriteriaProfile> criteriaOf(const std::string& which);

std::vector<std::string_view> criteriaNames();

}  // namespace volute
