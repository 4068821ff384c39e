// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "volute/io/reading.hpp"
#include "volute/media/field.hpp"
#include "volute/optics/visibility.hpp"
#include "volute/visibility/survey_job.hpp"

namespace volute {

/// What people see who stand at a few places: pictures towards the nearest sign, in the middle of
/// the times and at the last, photometric and threshold. Each place has a scene file; lamps hang
/// below the ceiling over the eye, the sign and between them, or the light of an FDS case comes
/// from everywhere.
class SignViews final : public SurveyPictures {
 public:
  /// kUnsupported for pictures of a scene, which has a camera of its own.
  /// @param eyes  [m]; none: no pictures
  /// @param path  of a medium alone
  /// @param members  of its entry in the scenes, besides what such a file has by itself
  /// @param source  of the survey (SightField::fillingSource()), unless `members` name a field
  /// @param reading  must outlive this
  [[nodiscard]] static Result<SignViews> make(std::vector<Vec3> eyes, const std::string& path,
                                              const FieldValue& members, const std::string& source,
                                              Reading& reading);

  /// Writes the scenes.
  [[nodiscard]] Status begin(const Survey& survey, const SightSnapshot& first) override;

  /// Renders; adds the pictures to the report and returns their part of the page.
  [[nodiscard]] Result<std::string> finish(const Survey& survey, Json& report) override;

 private:
  struct View {
    Vec3 eye = Vec3::Zero();
    std::size_t sign = 0;
    bool inSight = true;  ///< it can be read from there without smoke
    std::string scene;    ///< the file, in the folder of results
  };

  explicit SignViews(Reading& reading) : reading_(&reading) {}

  [[nodiscard]] Status render(const View& view, const std::filesystem::path& target, double time,
                              PictureMode mode) const;

  std::vector<Vec3> eyes_;
  nlohmann::ordered_json scene_;  ///< of the file alone
  bool lit_ = true;               ///< by lamps; else from everywhere
  Reading* reading_;
  std::vector<View> views_;
};

}  // namespace volute
