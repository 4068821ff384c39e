// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/volume_output.hpp"

#include "volute/base/interrupt.hpp"
#include "volute/base/output_name.hpp"

namespace volute::cli {

Status checkTarget(const std::string& target, bool standardOutput) {
  VOLUTE_TRY(checkOutput(target, standardOutput));
  if (target != "-")
    Interrupt::watch(target);
  return {};
}

Status checkTarget(const std::string& target, Context& context) {
  context.resultsToStderr = target == "-";
  if (context.json && target == "-") {
    return fail(ErrorCode::kInvalidArgument,
                "--json and '--output -' both want standard output; leave one");
  }
  return context.team.leads() ? checkTarget(target, true) : Status();
}

}  // namespace volute::cli
