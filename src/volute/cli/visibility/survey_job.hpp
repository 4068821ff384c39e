// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/cli/context.hpp"
#include "volute/cli/visibility/case_field.hpp"
#include "volute/cli/visibility/view_pictures.hpp"
#include "volute/cli/visibility/watch.hpp"
#include "volute/grid/select_frames.hpp"

namespace volute::cli {

struct SurveyRequest {
  std::string casePath;
  std::vector<SafetySign> signs;
  std::vector<std::vector<std::string>> sets;  ///< names of signs
  FrameRange frames;                           ///< of stored times, by their numbers
  Survey survey;                               ///< the numbers of it
  std::string output;
};

/// Goes through the stored times of a case, one after the other, and writes the folder of results.
[[nodiscard]] Status runSurvey(SurveyRequest request, SightCase& sightCase, Watch& watch,
                               ViewPictures& pictures, Context& context);

}  // namespace volute::cli
