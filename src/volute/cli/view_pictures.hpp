// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/cli/arguments.hpp"
#include "volute/cli/context.hpp"
#include "volute/optics/visibility.hpp"
#include "volute/visibility/survey_job.hpp"

namespace volute::cli {

/// What people see who stand at a few places: pictures towards the nearest sign, in the middle of
/// the times and at the last, photometric and threshold. Each place has a scene file that `volute
/// render` takes; lamps hang below the ceiling over the eye, the sign and between them, or the
/// light of an FDS case comes from everywhere.
class ViewPictures final : public SurveyPictures {
 public:
  /// `path` and the options about it go into the scenes. kUnsupported for pictures of a scene, which
  /// has a camera of its own.
  /// @param source  of the survey (SightField::fillingSource()), unless an option names another
  [[nodiscard]] static Result<ViewPictures> make(std::vector<Vec3> eyes, const std::string& path,
                                                 const std::string& source,
                                                 const Arguments& arguments, Context& context);

  /// Writes the scenes.
  [[nodiscard]] Status begin(const Survey& survey, const SightInstant& first) override;

  /// Renders; adds the pictures to the report and returns their part of the page.
  [[nodiscard]] Result<std::string> finish(const Survey& survey, Json& report) override;

 private:
  struct View {
    Vec3 eye = Vec3::Zero();
    std::size_t sign = 0;
    bool inSight = true;  ///< it can be read from there without smoke
    std::string scene;  ///< the file, in the folder of results
  };

  explicit ViewPictures(Context& context) : context_(&context) {}

  [[nodiscard]] Status render(const View& view, const std::filesystem::path& target, double time,
                              PictureMode mode) const;

  std::vector<Vec3> eyes_;
  nlohmann::ordered_json scene_;  ///< of the file alone
  bool lit_ = true;               ///< by lamps; else from everywhere
  Context* context_;
  std::vector<View> views_;
};

}  // namespace volute::cli
