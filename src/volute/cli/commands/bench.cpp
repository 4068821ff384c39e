// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/sibling_program.hpp"

namespace volute::cli {
namespace {

/// The benchmarks, with what they are compared with, are a program of their own.
Status runBench(const Arguments& /*arguments*/, Context& context) {
  return becomeSibling("volute-bench", "./dev bench builds and runs it from Volute's sources",
                       context);
}

}  // namespace

Command benchCommand() {
  return {
      .name = "bench",
      .summary = "Measures speed and size on this machine",
      .examples = {"volute bench", "volute bench codec --json",
                   "volute bench tomography --input capture.json --truth 'truth/%04d.vdb'"},
      .description =
          "Ratios compare figures of the same run with the baseline named by the benchmark; "
          "figures of different machines or runs are not comparable. Without a name, all "
          "benchmarks run. tools/codec_plot.py plots the output of `bench codec --json`.\n\nThe "
          "benchmarks are a separate program, volute-bench, beside volute; `./dev bench` builds "
          "and runs it.",
      .positionals = {{.name = "NAME",
                       .help = "which benchmarks to run",
                       .several = true,
                       .optional = true,
                       .file = false}},
      .options = {{.name = "input",
                   .kind = ValueKind::kFile,
                   .value = "VOLUME",
                   .help = "measure with this volume instead of synthetic ones; tomography: a "
                           "capture; smoke and gl: a mesh with smoke"},
                  {.name = "truth",
                   .kind = ValueKind::kFile,
                   .value = "VOLUME",
                   .help = "tomography: the true volumes of the capture's frames"},
                  fieldOption("tomography: grid of the true volumes"),
                  {.name = "quick",
                   .help =
                       "fewer measurements: `smoke` only 800 x 600 without a sign, `gl` a short "
                       "run of one minute, `tomography` only the best methods"},
                  {.name = "peers",
                   .kind = ValueKind::kFile,
                   .value = "FOLDER",
                   .help = "`codec`: sources of SZ3 and SPERR, in folders with these names, which "
                           "are built with the system's compiler and measured, too"},
                  {.name = "whole-pictures",
                   .help = "`smoke`: compare every pixel with the reference in double (takes "
                           "minutes) and measure no times"},
                  {.name = "only",
                   .kind = ValueKind::kText,
                   .value = "TEXT",
                   .help = "`light`: only rows with this in their names, as in 'sun, mesh,'"},
                  {.name = "list", .help = "list the benchmarks"}},
      .run = runBench};
}

}  // namespace volute::cli
