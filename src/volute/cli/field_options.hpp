// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/cli/arguments.hpp"
#include "volute/media/field.hpp"

namespace volute::cli {

/// Which rows become options.
enum class FieldUse {
  kAll,
  kMeasured,  ///< not those that change pictures alone
};

/// The options that say what the rows of these tables say. What several tables have is one option,
/// for all of their kinds.
std::vector<Option> fieldOptions(const std::vector<const FieldTable*>& tables,
                                 FieldUse use = FieldUse::kAll);

/// What a command line says of such an object, as a file would. kInvalidArgument names the option.
[[nodiscard]] Result<FieldValue> membersOf(const FieldTable& table, const Arguments& arguments);

/// The option that stands for a member of a table: "fire/cutoff" for one within. Empty: none.
std::string optionOfMember(const FieldTable& table, std::string_view member);

}  // namespace volute::cli
