// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/team.hpp"
#include "volute/grid/frame_source.hpp"
#include "volute/tomography/diagnostics.hpp"
#include "volute/tomography/frame_views.hpp"
#include "volute/tomography/picture_check.hpp"
#include "volute/tomography/reconstruct.hpp"
#include "volute/tomography/work_folder.hpp"

namespace volute {

/// How each frame is reconstructed.
struct ReconstructionSettings {
  TomographyOptions tomography;
  PictureLimits limits;
  bool warmStart = true;  ///< from the frame before, in chains of frames
  /// The volume is extinction, of a medium that the capture's lamps light; else it is the light
  /// that the medium sends, the same in all directions.
  bool singleScattering = false;
  bool force = false;  ///< go on in spite of faults, which become warnings
  /// The volume is a flame's, whose colours tell the soot that takes light on the way to a camera.
  bool flame = false;
  bool errorBars = false;           ///< standard deviations are estimated, too
  bool causeNamed = false;          ///< why cameras disagree is known: frames do not guess at it
  std::vector<int> causeNamedIn{};  ///< frames of which that is known
};

/// Where chains of frames begin, positions in `frames` (ascending numbers): with a warm start each
/// frame starts from the one before in its chain, the first from nothing. A chain ends where a
/// multiple of 8 times the step of the frames is passed, so chains depend on the numbers alone:
/// parts that are reconstructed apart, or by several processes, are those of the whole as far as
/// they begin with a chain. Without a warm start each frame is a chain.
std::vector<int> chainBegins(std::span<const int> frames, bool warmStart);

/// A capture as a sequence of volumes. Frames are reconstructed when they are first asked for,
/// those of a chain in order, and kept in a work folder: writers read them more than once, and an
/// interrupted run goes on where it was.
class ReconstructedFrames final : public FrameSource {
 public:
  /// Reads the first frame's pictures, to know whether they are grey, and remarks on frames that an
  /// earlier run finished. Capture, settings and progress must outlive the object.
  /// @param heldOut  cameras that are not used, only compared with
  /// @param output  the work folder is beside it; see WorkFolder::open()
  [[nodiscard]] static Result<std::unique_ptr<ReconstructedFrames>> open(
      const Capture& capture, const ReconstructionSettings& settings,
      const std::vector<std::string>& heldOut, const std::filesystem::path& output,
      Progress& progress);

  const VolumeInfo& info() const override { return info_; }

  [[nodiscard]] Status readFrame(int index, std::span<float> values) override;

  /// Standard deviations of the values, as estimateUncertainty() has them, as a grid of its own
  /// ("emission_sigma"). Only with ReconstructionSettings::errorBars.
  FrameSource& errorBars() { return errorBars_; }

  bool hasErrorBars() const { return settings_.errorBars; }

  /// Reconstructs what is missing, with the progress of the whole sequence. A chain is a unit of
  /// work; ranks share the work folder. Collective.
  [[nodiscard]] Status solveAll(Team& team);

  /// Solves all frames in this process alone.
  [[nodiscard]] Status solveAll() {
    Team alone;
    return solveAll(alone);
  }

  /// How many frames an earlier run had finished.

  /// What was measured on frame `index`, as the report has it.
  [[nodiscard]] Result<nlohmann::ordered_json> record(int index) const;

  /// The frame's volume, shape (z, y, x, 3), and its views; for pictures of the report.
  [[nodiscard]] Result<std::vector<float>> volume(int index) const;

  /// The light that the frame's volume sends, shape (z, y, x, 3): the volume itself but for
  /// extinction that lamps light.
  [[nodiscard]] Result<std::vector<float>> emission(int index) const;

  /// The pictures that emission() is to explain.
  [[nodiscard]] Result<FrameViews> views(int index);

  /// What a volume of the frame leaves of the fitted cameras' pictures: the mean of their
  /// residuals, as record() has them. For volumes that were written and read again; not with single
  /// scattering.
  /// @param values  shape (z, y, x, channels of info()).
  [[nodiscard]] Result<double> residualOf(int index, std::span<const float> values);

  VolumeGeometry geometry() const;

  const WorkFolder& work() const { return work_; }

  /// What finished frames in the work folder must have, one a frame; see frameKeys().
  const std::vector<std::string>& keys() const { return keys_; }

 private:
  ReconstructedFrames(const Capture& capture, const ReconstructionSettings& settings,
                      ViewReader views, WorkFolder work, std::vector<std::string> keys,
                      Progress& progress)
      : capture_(capture),
        settings_(settings),
        views_(std::move(views)),
        work_(std::move(work)),
        keys_(std::move(keys)),
        chains_(chainBegins(capture.frames, settings.warmStart)),
        finished_(keys_.size(), 0),
        progress_(progress) {}

  /// What the work folder has beside the values.
  class ErrorBars final : public FrameSource {
   public:
    explicit ErrorBars(ReconstructedFrames& frames) : frames_(frames) {}

    const VolumeInfo& info() const override { return info_; }

    [[nodiscard]] Status readFrame(int index, std::span<float> values) override;

   private:
    friend class ReconstructedFrames;
    ReconstructedFrames& frames_;
    VolumeInfo info_;
  };

  [[nodiscard]] Status begin();
  [[nodiscard]] Status solveUpTo(int index);
  void toChannels(std::span<const float> colour, std::span<float> values) const;

  int numberOf(int index) const { return capture_.frames[static_cast<std::size_t>(index)]; }

  /// Looks into the work folder once for a frame that is there: writers ask for all before each
  /// that they read. A damaged one is not there.
  bool finished(int index);

  std::size_t colourValues() const { return 3 * info_.voxels(); }

  /// The position of the first frame of the chain that a frame is of.
  int chainOf(int index) const;

  [[nodiscard]] Status solve(int index);
  bool carriesOn(int index) const;
  [[nodiscard]] Result<std::vector<float>> frameBefore(int index);
  [[nodiscard]] Status leaveOutOccluded(FrameViews& views, std::vector<std::string>& warnings);
  [[nodiscard]] Result<Reconstruction> fit(int index, FrameViews& views,
                                           std::vector<float>& extinction);

  bool takesOwnLight() const { return settings_.singleScattering || settings_.flame; }

  static std::vector<std::size_t> fittedOf(const FrameViews& views);
  [[nodiscard]] Result<Reconstruction> fitLit(FrameViews& views, const TomographyOptions& options,
                                              std::vector<float>& extinction, Progress& progress);
  [[nodiscard]] Result<TomographyOptions> optionsOf(int index) const;
  nlohmann::ordered_json measured(const FrameViews& views, const Reconstruction& result) const;
  [[nodiscard]] Result<std::vector<std::string>> examine(const FrameViews& views,
                                                         const PictureFindings& findings);
  [[nodiscard]] Result<std::vector<std::string>> diagnosed(const FrameViews& views,
                                                           const Reconstruction& result,
                                                           nlohmann::ordered_json& cameras);
  [[nodiscard]] Result<std::optional<std::string>> commonShift(const FrameViews& views,
                                                               const Reconstruction& result,
                                                               bool othersWarn);
  [[nodiscard]] Status addErrorBars(int index, const FrameViews& views,
                                    const Reconstruction& result, nlohmann::ordered_json& record);
  std::optional<std::string> explained(std::size_t camera, const CameraDiagnosis& found,
                                       const FrameViews& views, const Reconstruction& result);
  std::optional<std::string> outOfStep(std::size_t camera, const FrameViews& views,
                                       const Reconstruction& result);
  void warn(const std::string& text);

  const Capture& capture_;
  const ReconstructionSettings& settings_;
  ViewReader views_;
  WorkFolder work_;
  std::vector<std::string> keys_;  // one a frame
  std::vector<int> chains_;        // where they begin
  std::vector<char> finished_;     // one a frame: known to be
  Progress& progress_;
  VolumeInfo info_;
  ErrorBars errorBars_{*this};
  int resumed_ = 0;
  int solved_ = 0;       // by this run
  bool shares_ = false;  // the work with other processes, so its own progress is not that of all
  std::set<std::string> shown_;  // kinds of warnings
  bool more_ = false;            // it was said that there are more
  bool grey_ = false;
  bool shiftJudged_ = false;  // once a run: calibrations do not change
};

}  // namespace volute
