// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <array>
#include <charconv>
#include <filesystem>

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/parse.hpp"
#include "volute/visibility/study_folder.hpp"

namespace volute::cli {
namespace {

/// "2/5": the second of five parts.
Result<std::array<std::size_t, 2>> partOf(const Arguments& arguments) {
  const auto text = arguments.find<std::string>("part");
  if (!text)
    return std::array<std::size_t, 2>{1, 1};
  std::array<std::size_t, 2> part{};
  const char* end = text->data() + text->size();
  const auto first = std::from_chars(text->data(), end, part[0]);
  if (first.ec == std::errc() && first.ptr != end && *first.ptr == '/') {
    const auto second = std::from_chars(first.ptr + 1, end, part[1]);
    if (second.ec == std::errc() && second.ptr == end && part[0] >= 1 && part[0] <= part[1])
      return part;
  }
  return fail(ErrorCode::kInvalidArgument, "--part: '{}': expected I/N with I from 1 to N", *text);
}

Status surveyOf(const StudyRun& run, const std::filesystem::path& folder, Context& context) {
  static const Command command = visibilityCommand();
  std::vector<std::string> words{run.casePath, "--output=" + folder.string()};
  words.insert(words.end(), run.words.begin(), run.words.end());
  VOLUTE_ASSIGN(const auto arguments, parseArguments(command, words));
  Context own = context;
  own.words = words;
  own.silent = true;
  return command.run(arguments, own);
}

Status runSweep(const Arguments& arguments, Context& context) {
  VOLUTE_ASSIGN(const auto study, Study::read(arguments.positional(0)));
  VOLUTE_ASSIGN(const auto part, partOf(arguments));
  const std::filesystem::path folder = arguments.get<std::string>("output");
  Context::watch(folder / "study.csv");
  VOLUTE_ASSIGN(const auto found,
                runStudy(study, part, folder, context.progress,
                         [&](const StudyRun& run, const std::filesystem::path& target) {
                           return surveyOf(run, target, context);
                         }));
  Report report;
  report.add("output", folder.string())
      .add("table", (folder / "study.csv").string())
      .add("runs", study.runs.size(), fmt::format("{}", study.runs.size()))
      .add("done", found.done, fmt::format("{} done now", found.done))
      .add("kept", found.kept, fmt::format("{} were done before", found.kept))
      .add("failed", found.failed, fmt::format("{} failed: study.csv says why", found.failed));
  context.print(report);
  if (found.failed > 0 && found.done + found.kept == 0)
    return fail(ErrorCode::kInvalidData, "no run of {} could be done; {} says why", study.runs.size(),
                (folder / "study.csv").string());
  return {};
}

}  // namespace

Command sweepCommand() {
  using enum ValueKind;
  return {
      .name = "sweep",
      .summary = "Many surveys of sight and tenability: parameter studies, folders of cases",
      .examples = {"volute sweep STUDY.json -o study", "volute sweep STUDY.json -o study --part 2/4"},
      .description =
          "Runs `volute visibility` for each case with each variant of STUDY.json and puts what it "
          "found into one table, study.csv, a row a run; compared/ has maps of the differences to "
          "the baseline and the spread over all runs with the same plan. The same command goes on "
          "where it was stopped: what is done and unchanged is kept. Runs that fail have a sentence "
          "in the table, the others go on. --part I/N does every N-th run, for several processes or "
          "machines that share the folder; run it once more without --part for the whole "
          "table.\n\nSTUDY.json: {\"cases\": [\"a.smv\", \"folder\", {\"case\": \"b.smv\", "
          "\"options\": {..}}], \"options\": {\"signs\": \"signs.json\", \"height\": 2}, "
          "\"variants\": [{\"name\": \"strict\", \"options\": {\"criteria\": \"strict.json\"}}], "
          "\"baseline\": \"a\"}. A folder stands for all .smv files in and below it; options are "
          "those of `volute visibility`; files are found from the study's folder.",
      .positionals = {{.name = "STUDY.json", .help = "cases, options and variants"}},
      .options = {{.name = "output",
                   .letter = 'o',
                   .kind = kFile,
                   .value = "FOLDER",
                   .help = "for a folder each run, study.csv and comparisons; what an earlier run of "
                           "the same study left is gone on with",
                   .required = true},
                  {.name = "part",
                   .kind = kText,
                   .value = "I/N",
                   .help = "every N-th run alone, from the I-th"}},
      .run = runSweep};
}

}  // namespace volute::cli
