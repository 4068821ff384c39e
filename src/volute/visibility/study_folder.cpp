// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/study_folder.hpp"

#include <algorithm>

#include "volute/base/input_file.hpp"
#include "volute/base/version.hpp"
#include "volute/base/write_file.hpp"

namespace volute {
namespace {

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

/// The table and comparisons of all that is there, of other parts too.
Status writeResults(const Study& study, const std::filesystem::path& folder, Progress& progress) {
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
  std::error_code error;
  std::filesystem::create_directories(folder / "compared", error);
  VOLUTE_ASSIGN(const auto remarks, results.compare(folder / "compared"));
  constexpr std::size_t kRemarks = 20;
  for (std::size_t i = 0; i < std::min(remarks.size(), kRemarks); ++i)
    progress.remark(remarks[i]);
  return {};
}

}  // namespace

Result<StudyCounts> runStudy(
    const Study& study, const std::array<std::size_t, 2>& part, const std::filesystem::path& folder,
    Progress& progress,
    const std::function<Status(const StudyRun&, const std::filesystem::path&)>& survey) {
  std::error_code error;
  std::filesystem::create_directories(folder / "keys", error);
  if (error)
    return fail(ErrorCode::kIo, "{}: {}", folder.string(), error.message());
  StudyCounts counts;
  for (std::size_t i = 0; i < study.runs.size(); ++i) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled,
                  "stopped after {} of {} runs; the same command goes on from here", counts.done + counts.kept,
                  study.runs.size());
    progress.report("runs", static_cast<double>(i), static_cast<double>(study.runs.size()));
    if (i % part[1] != part[0] - 1)
      continue;
    const StudyRun& run = study.runs[i];
    const std::string key = keyOf(run);
    const auto keyFile = folder / "keys" / (run.name + ".txt");
    if (isDone(folder / run.name, keyFile, key)) {
      ++counts.kept;
      continue;
    }
    const auto status = survey(run, folder / run.name);
    if (!status && status.error().code == ErrorCode::kCancelled)
      return tl::unexpected<Error>(status.error());
    if (!status) {
      ++counts.failed;
      progress.remark(fmt::format("run '{}': {}", run.name, status.error().message));
      VOLUTE_TRY(writeFile(keyFile, "failed: " + status.error().message + "\n"));
      continue;
    }
    VOLUTE_TRY(writeFile(keyFile, key));
    ++counts.done;
  }
  VOLUTE_TRY(writeResults(study, folder, progress));
  return counts;
}

}  // namespace volute
