// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/base/team.hpp"
#include "volute/grid/select_frames.hpp"
#include "volute/media/sight.hpp"
#include "volute/visibility/sight_csv.hpp"
#include "volute/visibility/survey_page.hpp"
#include "volute/visibility/watch.hpp"

namespace volute {

struct SurveyRequest {
  std::string casePath;
  std::vector<SafetySign> signs;
  std::vector<std::vector<std::string>> sets;  ///< names of signs
  FrameRange frames;                           ///< of stored times, by their numbers
  Survey survey;                               ///< the numbers of it
  CriteriaProfile profile;                     ///< what Survey::criteria are; for the report
  std::vector<Remark> remarks{};               ///< that the results begin with
  std::string output;
  SightFile sightFile = SightFile::kAuto;
  bool pdf = false;  ///< print report.html as report.pdf; a remark where that cannot be

  /// Title, author and inputs of the report; may be empty.
  struct Document {
    std::string title, project, author, date;
    std::vector<std::filesystem::path> inputs;  ///< files that were read, for their checksums
  };

  Document document{};
  std::uint64_t maxMemory = std::uint64_t{4} << 30;
};

/// Pictures of what is seen, which go into the folder and the page.
class SurveyPictures {
 public:
  virtual ~SurveyPictures() = default;

  /// On rank 0, like finish().
  [[nodiscard]] virtual Status begin(const Survey& survey, const SightSnapshot& first) = 0;

  /// Takes them; adds them to the report and returns their part of the page.
  [[nodiscard]] virtual Result<std::string> finish(const Survey& survey, Json& report) = 0;
};

/// What a survey found, in short.
struct SurveySummary {
  std::uint64_t sightLines = 0;
  std::vector<double> times;           ///< [s]
  double seenFirst = 0, seenLast = 0;  ///< shares of the eyes that see a sign; NaN: no eyes
  std::vector<std::string> verdict;    ///< in sentences
  SurveyPage page{};                   ///< empty where there is none
};

/// Goes through the stored times of a case and writes the folder of results. A stored time is a
/// unit of work: ranks read it, look and write its maps; rank 0 puts together what all see.
/// Collective; the summary is rank 0's, of the others only the times are there.
[[nodiscard]] Result<SurveySummary> runSurvey(SurveyRequest request, SightField& field,
                                              Watch& watch, SurveyPictures& pictures,
                                              Progress& progress, Team& team);

/// Runs a survey in this process alone.
[[nodiscard]] Result<SurveySummary> runSurvey(SurveyRequest request, SightField& field,
                                              Watch& watch, SurveyPictures& pictures,
                                              Progress& progress);

}  // namespace volute
