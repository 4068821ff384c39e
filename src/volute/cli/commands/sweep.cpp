// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <filesystem>
#include <optional>

#include "volute/base/team_checks.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/parse.hpp"
#include "volute/cli/ranks.hpp"
#include "volute/cli/values.hpp"
#include "volute/io/output_names.hpp"
#include "volute/visibility/study_folder.hpp"

namespace volute::cli {
namespace {

Result<StudyChoice> choiceOf(const Arguments& arguments, const Study& study) {
  StudyChoice choice;
  if (const auto only = arguments.find<int>("only")) {
    if (*only > static_cast<int>(study.runs.size())) {
      return fail(ErrorCode::kInvalidArgument,
                  "--only: {} of a study of {} runs; --list shows them", *only, study.runs.size());
    }
    choice.only = static_cast<std::size_t>(*only - 1);
  }
  if (const auto part = arguments.find<std::string>("part")) {
    VOLUTE_ASSIGN(choice.part, ofOption("part", parsePart(*part)));
  }
  return choice;
}

Status surveyOf(const StudyRun& run, const std::filesystem::path& folder, Context& context) {
  static const Command command = visibilityCommand();
  std::vector<std::string> words{run.casePath, "--output=" + folder.string()};
  words.insert(words.end(), run.words.begin(), run.words.end());
  VOLUTE_ASSIGN(const auto arguments, parseArguments(command, words));
  Team alone;  // who has taken the run does all of it
  Context own{{context.progress, context.maxMemory}, alone, context.console};
  own.verbose = context.verbose;
  own.words = words;
  own.silent = true;
  const Status status = command.run(arguments, own);
  if (status)
    return {};
  // With the option that it is about, as studies name it.
  const auto name = [](const std::string& setting, const std::string& value) {
    const std::string option = optionsOf(command)(setting, value);
    return option.starts_with("--") ? option.substr(2) : option;
  };
  return fail(status.error().code, "{}", fullText(status.error(), name));
}

/// A study says what is computed, and whoever starts it where that goes.
Status checkWritesNothing(const Study& study, const std::string& file) {
  const Command command = visibilityCommand();
  for (const StudyRun& run : study.runs) {
    std::vector<std::string> words{run.casePath, "--output=x"};
    words.insert(words.end(), run.words.begin(), run.words.end());
    const auto arguments = parseArguments(command, words);
    if (!arguments)
      continue;  // the run says what is wrong
    for (const Option& option : command.options) {
      if (option.kind == ValueKind::kOutput && option.name != "output" &&
          arguments->given(option.name)) {
        return fail(ErrorCode::kInvalidData,
                    "{}: run '{}': the option '{}' writes a file, and a study names none: leave it "
                    "out; each run has a folder of its own",
                    file, run.name, option.name);
      }
    }
  }
  return {};
}

Status runSweep(const Arguments& arguments, Context& context) {
  VOLUTE_ASSIGN(const auto study, Study::read(arguments.positional(0)));
  VOLUTE_TRY(checkWritesNothing(study, arguments.positional(0)));
  VOLUTE_ASSIGN(const auto choice, choiceOf(arguments, study));
  const auto output = arguments.find<std::string>("output");
  if (arguments.flag("list")) {
    const StudyList list = listOf(study, output);
    context.print(context.json ? dumpJson(list.json) : list.text);
    return {};
  }
  if (!output)
    return fail(ErrorCode::kInvalidArgument,
                "--output is missing: say into which folder the runs go");
  if (const auto stats = arguments.find<std::string>("stats"); stats && liesIn(*stats, *output)) {
    return fail(
        ErrorCode::kInvalidArgument,
        "--stats: {} is in the folder of --output, among the runs' files; give another name",
        *stats);
  }
  const std::filesystem::path folder = *output;
  VOLUTE_TRY(checkFolderIsShared(*output, context.team));
  Context::watch(folder / "study.csv");
  VOLUTE_ASSIGN(const auto found,
                runStudy(study, choice, folder, context.progress, context.team,
                         [&](const StudyRun& run, const std::filesystem::path& target) {
                           return surveyOf(run, target, context);
                         }));
  VOLUTE_TRY(writeStats(arguments, context, {{"runs", study.runs.size()}}));
  if (found.failed > 0 && context.team.leads() && !choice.only) {
    context.progress.remark(
        {RemarkCode::kLeftOut, fmt::format("{} of {} runs failed: {} says why", found.failed,
                                           study.runs.size(), (folder / "study.csv").string())});
  }
  Report report;
  report.add("output", folder.string());
  if (!choice.only)
    report.add("table", (folder / "study.csv").string());
  report.add("runs", study.runs.size(), fmt::format("{}", study.runs.size()))
      .add("done", found.done, fmt::format("{} done now", found.done))
      .add("kept", found.kept, fmt::format("{} were done before", found.kept))
      .add("failed", found.failed, fmt::format("{} failed: study.csv says why", found.failed));
  context.print(report);
  if (found.failed > 0 && choice.only)
    return fail(ErrorCode::kInvalidData, "run {} could not be done", *choice.only + 1);
  if (found.failed > 0 && found.done + found.kept == 0)
    return fail(ErrorCode::kInvalidData, "no run of {} could be done; {} says why",
                study.runs.size(), (folder / "study.csv").string());
  return {};
}

}  // namespace

Command sweepCommand() {
  using enum ValueKind;
  return {
      .name = "sweep",
      .summary =
          "Runs many surveys of visibility and tenability: parameter studies, folders of "
          "cases",
      .examples = {"volute sweep STUDY.json -o study",
                   "volute sweep STUDY.json -o study --part 2/4",
                   "mpirun -n 8 volute sweep STUDY.json -o study"},
      .description =
          "Runs `volute visibility` for each case with each variant of STUDY.json and collects "
          "the results in one table, study.csv, one row per run; compared/ has maps of the "
          "differences to the baseline and of the spread over all runs with the same plan, for "
          "each height of the eyes. The same command continues after an interruption: finished, "
          "unchanged runs are kept. A failed run has an error message in the table; the others "
          "continue, and the exit code is 1 where none could be done. --part I/N does every N-th "
          "run, for several processes or machines that "
          "share the folder; run once more without --part for the whole table. Schedulers "
          "without MPI select runs by number: --list shows them, --only I does one, and the "
          "same command without it, when all are done, writes the table. Ranks (mpirun) share "
          "the runs.\n\nSTUDY.json: {\"cases\": "
          "[\"a.smv\", \"folder\", {\"case\": \"b.smv\", \"options\": {..}}], \"options\": "
          "{\"signs\": \"signs.json\", \"height\": 2}, \"variants\": [{\"name\": \"strict\", "
          "\"options\": {\"criteria\": \"strict.json\"}}], \"baseline\": \"a\"}. A folder stands "
          "for all .smv files in and below it; options are those of `volute visibility`; file "
          "names are relative to the study's folder.",
      .positionals = {{.name = "STUDY.json", .help = "cases, options and variants"}},
      .options = {{.name = "output",
                   .letter = 'o',
                   .kind = kFile,
                   .value = "FOLDER",
                   .help = "output folder: one folder per run, study.csv and comparisons; "
                           "continues an earlier run of the same study; not needed for --list"},
                  {.name = "list",
                   .help = "list the runs with their numbers, and with -o their state; do nothing "
                           "else"},
                  {.name = "only",
                   .kind = kInteger,
                   .value = "I",
                   .help = "do only run I, counted from 1, without the table",
                   .least = 1},
                  statsOption(),
                  {.name = "part",
                   .kind = kText,
                   .value = "I/N",
                   .help = "do only every N-th run, from the I-th"}},
      .oneOf = {{{"list", "only", "part"}, false}},
      .ranks = true,
      .run = runSweep};
}

}  // namespace volute::cli
