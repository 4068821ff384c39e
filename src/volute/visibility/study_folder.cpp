// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/study_folder.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "volute/base/read_files.hpp"
#include "volute/base/read_text.hpp"
#include "volute/base/version.hpp"
#include "volute/base/write_file.hpp"
#include "volute/io/output_names.hpp"

namespace volute {
namespace {

/// What is asked of a run.
std::string keyOf(const StudyRun& run) {
  std::string key = fmt::format("{} {}", VOLUTE_VERSION, run.casePath);
  for (const std::string& word : run.words) key += " " + word;
  return key + "\n";
}

/// A file as it is now: its size and when it was written; -1: it is not there. Of a folder all that
/// is below it, without the study's.
std::string stampOf(const std::filesystem::path& path, const std::filesystem::path& study) {
  std::error_code error;
  std::int64_t size = -1, time = std::numeric_limits<std::int64_t>::min();
  const auto add = [&](const std::filesystem::path& file) {
    std::error_code gone;
    const auto bytes = std::filesystem::file_size(file, gone);
    const auto written = std::filesystem::last_write_time(file, gone);
    if (gone)
      return;
    size = std::max(size, std::int64_t{0}) + static_cast<std::int64_t>(bytes);
    time = std::max<std::int64_t>(time, written.time_since_epoch().count());
  };
  if (std::filesystem::is_directory(path, error)) {
    for (std::filesystem::recursive_directory_iterator entry(path, error), end;
         !error && entry != end; entry.increment(error)) {
      std::error_code gone;
      if (std::filesystem::equivalent(entry->path(), study, gone))
        entry.disable_recursion_pending();
      else if (entry->is_regular_file(gone))
        add(entry->path());
    }
  } else {
    add(path);
  }
  return fmt::format("{} {} {}\n", size, time, path.string());
}

/// Whether all that a run has read is as it was.
bool isUnchanged(std::string_view stamps, const std::filesystem::path& study) {
  while (!stamps.empty()) {
    const std::string_view line = stamps.substr(0, stamps.find('\n') + 1);
    const std::size_t name = line.find(' ', line.find(' ') + 1);
    if (line.empty() || name == line.npos ||
        stampOf(line.substr(name + 1, line.size() - name - 2), study) != line)
      return false;
    stamps.remove_prefix(line.size());
  }
  return true;
}

/// @param study  the folder of all runs
bool isDone(const StudyRun& run, const std::filesystem::path& study,
            const std::filesystem::path& keyFile) {
  std::error_code error;
  if (!std::filesystem::exists(study / run.name / "visibility.json", error))
    return false;
  const std::string key = keyOf(run);
  const auto text = readText(keyFile);
  return text && text->starts_with(key) && text->size() > key.size() &&
         isUnchanged(std::string_view(*text).substr(key.size()), study);
}

StudyRunState stateOf(const StudyRun& run, const std::filesystem::path& folder) {
  const auto keyFile = folder / "keys" / (run.name + ".txt");
  if (isDone(run, folder, keyFile))
    return {true, ""};
  if (const auto text = readText(keyFile, 65535); text && text->starts_with("failed: "))
    return {false, text->substr(8, text->size() - 9)};
  return {false, "not run yet"};
}

/// The table and comparisons of all that is there, of other parts too.
Status writeResults(const Study& study, const std::filesystem::path& folder, Progress& progress) {
  StudyResults results(study.baseline.empty() ? study.runs.front().name : study.baseline);
  for (const StudyRun& run : study.runs) {
    const StudyRunState state = stateOf(run, folder);
    if (state.done)
      VOLUTE_TRY(results.add(run, folder / run.name));
    else
      results.addFailure(run, state.why);
  }
  VOLUTE_TRY(writeFile(folder / "study.csv", results.table()));
  std::error_code error;
  std::filesystem::create_directories(folder / "compared", error);
  VOLUTE_ASSIGN(const auto remarks, results.compare(folder / "compared"));
  constexpr std::size_t kRemarks = 20;
  for (std::size_t i = 0; i < std::min(remarks.size(), kRemarks); ++i) progress.remark(remarks[i]);
  return {};
}

/// The runs that are done by one call.
class StudyPass {
 public:
  using Survey = std::function<Status(const StudyRun&, const std::filesystem::path&)>;

  StudyPass(const std::filesystem::path& folder, const Survey& survey)
      : folder_(folder), survey_(survey) {}

  Status take(const StudyRun& run) {
    const auto keyFile = folder_ / "keys" / (run.name + ".txt");
    if (isDone(run, folder_, keyFile)) {
      ++kept_;
      return {};
    }
    const ReadNames read;
    const auto status = survey_(run, folder_ / run.name);
    if (!status && status.error().code == ErrorCode::kCancelled)
      return status;
    if (!status) {
      ++failed_;
      failures_ += fmt::format("run '{}': {}\n", run.name, status.error().message);
      return writeFile(keyFile, "failed: " + status.error().message + "\n");
    }
    ++done_;
    std::string stamps;
    for (const auto& path : read.names()) {
      if (!liesIn(path, folder_))
        stamps += stampOf(std::filesystem::absolute(path), folder_);
    }
    return writeFile(keyFile, keyOf(run) + stamps);
  }

  /// Of all ranks; tells of runs that failed. Collective.
  Result<StudyCounts> counts(Progress& progress, Team& team) {
    VOLUTE_ASSIGN(const auto texts, team.gatherTexts(failures_));
    std::vector<std::string> lines;
    for (const std::string& text : texts) {
      for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = text.find('\n', at);
        lines.push_back(text.substr(at, end - at));
        at = end + 1;
      }
    }
    std::ranges::sort(lines);
    for (const std::string& line : lines) progress.remark(line);
    std::array<std::uint64_t, 3> all{done_, kept_, failed_};
    VOLUTE_TRY(team.sum(all));
    return StudyCounts{all[0], all[1], all[2]};
  }

 private:
  const std::filesystem::path& folder_;
  const Survey& survey_;
  std::uint64_t done_ = 0, kept_ = 0, failed_ = 0;
  std::string failures_;  // a line each
};

}  // namespace

std::vector<StudyRunState> statesOf(const Study& study, const std::filesystem::path& folder) {
  std::vector<StudyRunState> states;
  for (const StudyRun& run : study.runs) states.push_back(stateOf(run, folder));
  return states;
}

Result<StudyCounts> runStudy(
    const Study& study, const StudyChoice& choice, const std::filesystem::path& folder,
    Progress& progress, Team& team,
    const std::function<Status(const StudyRun&, const std::filesystem::path&)>& survey) {
  std::error_code error;
  std::filesystem::create_directories(folder / "keys", error);
  if (error)
    return fail(ErrorCode::kIo, "{}: {}", folder.string(), error.message());
  std::vector<const StudyRun*> runs;
  for (std::size_t i = 0; i < study.runs.size(); ++i) {
    if (choice.only ? i == *choice.only : i % choice.part[1] == choice.part[0] - 1)
      runs.push_back(&study.runs[i]);
  }
  StudyPass pass(folder, survey);
  const auto status =
      team.forUnits("runs", static_cast<std::int64_t>(runs.size()), progress,
                    [&](std::int64_t i) { return pass.take(*runs[static_cast<std::size_t>(i)]); });
  if (!status && status.error().code == ErrorCode::kCancelled)
    return fail(ErrorCode::kCancelled, "stopped; the same command goes on from here");
  VOLUTE_TRY(status);
  VOLUTE_ASSIGN(const auto counts, pass.counts(progress, team));
  if (!choice.only)
    VOLUTE_TRY(team.agree(team.leads() ? writeResults(study, folder, progress) : Status()));
  return counts;
}

Result<std::array<std::size_t, 2>> parsePart(const std::string& text) {
  std::array<std::size_t, 2> part{};
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, part[0]);
  if (first.ec == std::errc() && first.ptr != end && *first.ptr == '/') {
    const auto second = std::from_chars(first.ptr + 1, end, part[1]);
    if (second.ec == std::errc() && second.ptr == end && part[0] >= 1 && part[0] <= part[1])
      return part;
  }
  return fail(ErrorCode::kInvalidArgument, "'{}': expected I/N with I from 1 to N", text);
}

StudyList listOf(const Study& study, const std::optional<std::string>& folder) {
  std::vector<StudyRunState> states(study.runs.size());
  if (folder)
    states = statesOf(study, *folder);
  auto runs = Json::array();
  StudyList list;
  for (std::size_t i = 0; i < study.runs.size(); ++i) {
    const StudyRun& run = study.runs[i];
    runs.push_back({{"number", i + 1}, {"name", run.name}, {"case", run.casePath}});
    list.text += fmt::format("{} {}", i + 1, run.name);
    if (folder) {
      runs.back()["done"] = states[i].done;
      if (!states[i].done)
        runs.back()["why"] = states[i].why;
      list.text += ": " + (states[i].done ? "done" : states[i].why);
    }
    list.text += '\n';
  }
  list.json = {{"runs", runs}};
  return list;
}

}  // namespace volute
