// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/cli/sibling_program.hpp"

namespace volute::cli {
namespace {

/// The benchmarks, with what they are compared with, are a program of their own.
Status runBench(const Arguments& /*arguments*/, Context& context) {
  return becomeSibling("volute-bench", "./dev bench builds and runs it from Volute's sources", context);
}

}  // namespace

Command benchCommand() {
  return {
      .name = "bench",
      .summary = "Measures speed and size on this machine",
      .examples = {"volute bench", "volute bench codec --json",
                   "volute bench tomography --input capture.json --truth 'truth/%04d.vdb'"},
      .description =
          "Ratios compare figures of the same run with the baseline that the benchmark names; "
          "figures of different machines or runs are not comparable. Without a name all benchmarks "
          "run. tools/codec_plot.py draws what `bench codec --json` prints.\n\nThe benchmarks are "
          "a program of their own, volute-bench, beside volute; `./dev bench` builds and runs it.",
      .positionals =
          {{.name = "NAME", .help = "which benchmarks to run", .several = true, .optional = true}},
      .options = {{.name = "input",
                   .kind = ValueKind::kFile,
                   .value = "VOLUME",
                   .help = "measure with this volume instead of made-up ones; tomography: a "
                           "capture; smoke and gl: a mesh with smoke"},
                  {.name = "truth",
                   .kind = ValueKind::kFile,
                   .value = "VOLUME",
                   .help = "tomography: the true volumes of the capture's frames"},
                  fieldOption("tomography: which one of the truth's files"),
                  {.name = "quick",
                   .help =
                       "fewer measurements: `smoke` draws 800 x 600 alone, without a sign, `gl` "
                       "less of everything in a minute, `tomography` has the best methods alone"},
                  {.name = "whole-pictures",
                   .help = "`smoke`: hold every pixel against the reference in double, in "
                           "minutes, and measure no times"},
                  {.name = "list", .help = "list the benchmarks"}},
      .run = runBench};
}

}  // namespace volute::cli
