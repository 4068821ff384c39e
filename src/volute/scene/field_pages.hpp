// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <set>
#include <string>

#include "volute/media/field.hpp"

namespace volute {

/// Adds the JSON Schema of a table's objects, and of what its members are, to "$defs".
void addSchema(const FieldTable& table, nlohmann::ordered_json& defs);

/// "## fog", its sentence, and a Markdown table with one line a member; behind it those of objects
/// in it that are not in `done`.
/// @param outer  the member that they are, of objects in objects
std::string membersTable(const FieldTable& table, std::set<const FieldTable*>& done,
                         std::string_view outer = {});

}  // namespace volute
