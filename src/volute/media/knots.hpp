// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

namespace volute {

/// Moves a knot of a list of [place, value, ...]: its place stays between its neighbours', its
/// value is 0 to `most`.
void setKnot(nlohmann::ordered_json& knots, std::size_t i, const std::vector<double>& knot,
             double most);

/// One more knot halfway to the next one; beyond the last as far as it is from the one before, and
/// at least `apart`.
void duplicateKnot(nlohmann::ordered_json& knots, std::size_t i, double apart);

}  // namespace volute
