// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>

#include "volute/base/input_file.hpp"
#include "volute/base/version.hpp"
#include "volute/base/write_file.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/parse.hpp"
#include "volute/visibility/study.hpp"

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

/// What a run's result depends on: options, and the index and the signs as they are now.
std::string keyOf(const StudyRun& run) {
  std::string key = fmt::format("{} {}", VOLUTE_VERSION, run.casePath);
  const auto stamp = [&](const std::string& file) {
    std::error_code error;
    const auto size = std::filesystem::file_size(file, error);
    if (error)
      return;
    const auto time = std::filesystem::last_write_time(file, error).time_since_epoch().count();
    key += fmt::format(" {} {} {}", file, size, time);
  };
  stamp(run.casePath);
  for (const std::string& word : run.words) {
    key += " " + word;
    const std::size_t equals = word.find('=');
    if (equals != word.npos)
      stamp(word.substr(equals + 1));
  }
  return key + "\n";
}

bool isDone(const std::filesystem::path& folder, const std::filesystem::path& keyFile,
            const std::string& key) {
  std::error_code error;
  if (!std::filesystem::exists(folder / "visibility.json", error))
    return false;
  const auto file = InputFile::open(keyFile);
  if (!file || file->size() != key.size())
    return false;
  std::string text(key.size(), '\0');
  return file->read(0, std::as_writable_bytes(std::span(text))) && text == key;
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
  std::error_code error;
  std::filesystem::create_directories(folder / "keys", error);
  if (error)
    return fail(ErrorCode::kIo, "{}: {}", folder.string(), error.message());
  Context::watch(folder / "study.csv");
  std::size_t done = 0, kept = 0, failed = 0;
  for (std::size_t i = 0; i < study.runs.size(); ++i) {
    if (context.progress.cancelled())
      return fail(ErrorCode::kCancelled,
                  "stopped after {} of {} runs; the same command goes on from here", done + kept,
                  study.runs.size());
    context.progress.report("runs", static_cast<double>(i), static_cast<double>(study.runs.size()));
    if (i % part[1] != part[0] - 1)
      continue;
    const StudyRun& run = study.runs[i];
    const std::string key = keyOf(run);
    const auto keyFile = folder / "keys" / (run.name + ".txt");
    if (isDone(folder / run.name, keyFile, key)) {
      ++kept;
      continue;
    }
    const auto status = surveyOf(run, folder / run.name, context);
    if (!status && status.error().code == ErrorCode::kCancelled)
      return status;
    if (!status) {
      ++failed;
      context.progress.remark(fmt::format("run '{}': {}", run.name, status.error().message));
      VOLUTE_TRY(writeFile(keyFile, "failed: " + status.error().message + "\n"));
      continue;
    }
    VOLUTE_TRY(writeFile(keyFile, key));
    ++done;
  }
  // The table has all that is there, of other parts too.
  StudyResults results(study.baseline.empty() ? study.runs.front().name : study.baseline);
  for (const StudyRun& run : study.runs) {
    const auto keyFile = folder / "keys" / (run.name + ".txt");
    if (isDone(folder / run.name, keyFile, keyOf(run))) {
      VOLUTE_TRY(results.add(run, folder / run.name));
      continue;
    }
    std::string why = "not run yet";
    if (const auto file = InputFile::open(keyFile); file && file->size() < 65536) {
      std::string text(file->size(), '\0');
      if (file->read(0, std::as_writable_bytes(std::span(text))) && text.starts_with("failed: "))
        why = text.substr(8, text.size() - 9);
    }
    results.addFailure(run, why);
  }
  VOLUTE_TRY(writeFile(folder / "study.csv", results.table()));
  std::filesystem::create_directories(folder / "compared", error);
  VOLUTE_ASSIGN(const auto remarks, results.compare(folder / "compared"));
  constexpr std::size_t kRemarks = 20;
  for (std::size_t i = 0; i < std::min(remarks.size(), kRemarks); ++i)
    context.progress.remark(remarks[i]);
  Report report;
  report.add("output", folder.string())
      .add("table", (folder / "study.csv").string())
      .add("runs", study.runs.size(), fmt::format("{}", study.runs.size()))
      .add("done", done, fmt::format("{} done now", done))
      .add("kept", kept, fmt::format("{} were done before", kept))
      .add("failed", failed, fmt::format("{} failed: study.csv says why", failed));
  context.print(report);
  if (failed > 0 && done + kept == 0)
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
