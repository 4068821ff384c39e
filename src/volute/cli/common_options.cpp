// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/command.hpp"

namespace volute::cli {

std::span<const Option> commonOptions() {
  static const std::vector<Option> options = {
      {.name = "threads",
       .kind = ValueKind::kInteger,
       .value = "N",
       .help = "number of threads; 0: all cores",
       .initial = "0",
       .least = 0,
       .most = 4096},
      {.name = "max-memory",
       .kind = ValueKind::kBytes,
       .value = "BYTES",
       .help = "limit of memory; what needs more is refused (512M, 2G)",
       .initial = "4G"},
      {.name = "untrusted",
       .help = "refuse scenes and captures that name files outside their own folder"},
      {.name = "json", .help = "print the results as one JSON object"},
      {.name = "quiet", .letter = 'q', .help = "print no progress and no remarks"},
      {.name = "strict",
       .help =
           "fail where something is assumed, left out, damaged, changed or doubtful, instead of "
           "remarking on it"},
      {.name = "verbose", .letter = 'v', .help = "print more remarks"},
      {.name = "help", .letter = 'h', .help = "show this help"},
      {.name = "version", .help = "show the version"},
  };
  return options;
}

}  // namespace volute::cli
