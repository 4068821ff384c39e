// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/reconstructed_frames.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "volute/base/assert.hpp"
#include "volute/base/cancel_only.hpp"
#include "volute/capture/capture_check.hpp"
#include "volute/report/json.hpp"
#include "volute/tomography/common_shift.hpp"
#include "volute/tomography/diagnostics.hpp"
#include "volute/tomography/lamp_light.hpp"
#include "volute/tomography/occlusion.hpp"
#include "volute/tomography/project.hpp"
#include "volute/tomography/pyrometer.hpp"
#include "volute/tomography/residual.hpp"
#include "volute/tomography/run_key.hpp"
#include "volute/tomography/uncertainty.hpp"
#include "volute/tomography/volume_flow.hpp"

namespace volute {
namespace {

constexpr const char* kDeviationKey = "-sigma";  // after the key of a frame

/// The solver's progress within one frame as progress of the whole sequence.
class FrameProgress final : public Progress {
 public:
  FrameProgress(Progress& whole, int number, double before, double total)
      : whole_(whole), number_(number), before_(before), total_(total) {}

  void report(std::string_view stage, double done, double total) override {
    const bool iterates = stage == "solving";
    whole_.detail(iterates ? fmt::format("frame {}, iteration {:.0f}, {}", number_, done, detail_)
                           : fmt::format("frame {}, {}", number_, stage));
    // The solver may stop before its last iteration, so a frame never looks finished here.
    if (iterates && total > 0)
      share_ = std::clamp(done / total, share_, 0.99);
    if (total_ > 0)
      whole_.report("reconstructing", before_ + share_, total_);
  }

  void detail(std::string_view text) override { detail_ = text; }

  void remark(const Remark& remark) override {
    Remark ofFrame = remark;
    ofFrame.sentence = fmt::format("frame {}: {}", number_, remark.sentence);
    ofFrame.place = fmt::format("frame {}", number_);
    whole_.remark(ofFrame);
  }

  bool cancelled() const override { return whole_.cancelled(); }

 private:
  Progress& whole_;
  std::string detail_;  // of the solver
  int number_;
  double before_, total_;
  double share_ = 0;  // of this frame
};

nlohmann::ordered_json choiceJson(const std::optional<TomographyChoice>& choice) {
  if (!choice)
    return {};
  return {{"regularization", regularizationName(choice->regularization)},
          {"strength", choice->strength},
          {"sparsity", choice->sparsity},
          {"iterations", choice->iterations}};
}

VolumeInfo infoOf(const Capture& capture, const ReconstructionSettings& settings, bool grey) {
  VolumeInfo info;
  const Basis basis = settings.tomography.basis;
  const bool depths = capture.measured == Measured::kAbsorption || settings.singleScattering;
  info.name = depths ? "extinction" : "emission";
  info.unit = depths ? "1/m" : "radiance/m";
  info.frames = static_cast<int>(capture.frames.size());
  info.x = capture.volume.resolution[0];
  info.y = capture.volume.resolution[1];
  info.z = capture.volume.resolution[2];
  info.channels = grey ? 1 : 3;
  info.bounds = capture.volume.bounds;
  info.basis = basis;
  info.frameNumbers = capture.frames;
  // From the first frame of the whole capture, so that parts of it join.
  for (const int frame : capture.frames)
    info.times.push_back((frame - capture.firstFrame) / capture.framesPerSecond);
  return info;
}

}  // namespace

std::vector<int> chainBegins(std::span<const int> frames, bool warmStart) {
  constexpr std::int64_t kChain = 8;
  std::int64_t step = std::numeric_limits<std::int64_t>::max() / kChain;
  for (std::size_t i = 1; i < frames.size(); ++i)
    step = std::min<std::int64_t>(step, std::int64_t{frames[i]} - frames[i - 1]);
  const std::int64_t length = warmStart ? kChain * std::max<std::int64_t>(step, 1) : 1;
  const auto chainOf = [&](int frame) {
    return frame >= 0 ? frame / length : (frame + 1) / length - 1;
  };
  std::vector<int> begins;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i == 0 || chainOf(frames[i]) != chainOf(frames[i - 1]))
      begins.push_back(static_cast<int>(i));
  }
  return begins;
}

Result<std::unique_ptr<ReconstructedFrames>> ReconstructedFrames::open(
    const Capture& capture, const ReconstructionSettings& settings,
    const std::vector<std::string>& heldOut, const std::filesystem::path& output,
    Progress& progress) {
  VOLUTE_ASSIGN(auto views,
                ViewReader::open(capture, heldOut, settings.tomography.maxMemory, progress));
  VOLUTE_ASSIGN(auto work, WorkFolder::open(output));
  std::unique_ptr<ReconstructedFrames> frames(
      new ReconstructedFrames(capture, settings, std::move(views), std::move(work),
                              frameKeys(capture, settings, heldOut), progress));
  if (const Status begun = frames->begin(); !begun) {
    frames->work_.leave(false);
    return tl::unexpected<Error>(begun.error());
  }
  return frames;
}

Status ReconstructedFrames::begin() {
  VOLUTE_ASSIGN(const FrameViews first, views_.read(capture_.frames.front()));
  // A grey picture tells nothing of those after it.
  grey_ = settings_.singleScattering ||
          (first.grey() && isGrey(capture_, settings_.tomography.maxMemory));
  if (settings_.flame && grey_)
    return fail(ErrorCode::kInvalidData,
                "{}: its pictures are grey; a temperature needs the colours of a flame",
                capture_.file.string());
  info_ = infoOf(capture_, settings_, grey_);
  VOLUTE_TRY(info_.validate("the reconstruction"));
  errorBars_.info_ = info_;
  errorBars_.info_.name += "_sigma";
  std::vector<int> damaged;
  for (int index = 0; index < info_.frames; ++index) {
    const bool done = finished(index);
    resumed_ += done ? 1 : 0;
    if (!done && work_.has(numberOf(index), keys_[static_cast<std::size_t>(index)]))
      damaged.push_back(numberOf(index));
  }
  if (work_.any()) {
    progress_.remark(
        fmt::format("{}: an earlier run finished {} of {} frames with these options and inputs",
                    work_.path().string(), resumed_, info_.frames));
  }
  if (!damaged.empty()) {
    progress_.remark(fmt::format("{}: frame {} is damaged, and solved again", work_.path().string(),
                                 fmt::join(damaged, ", ")));
  }
  return {};
}

VolumeGeometry ReconstructedFrames::geometry() const {
  return {capture_.volume.bounds, capture_.volume.resolution};
}

/// A sentence that comes again with other numbers, for another frame, is shown once.
void ReconstructedFrames::warn(const std::string& text) {
  const auto frame = text.find(", frame ");
  std::string kind = text.substr(0, frame == std::string::npos ? 0 : frame);
  for (std::size_t i = kind.size(); i < text.size(); ++i) {
    if (!std::isdigit(static_cast<unsigned char>(text[i])) && text[i] != '.')
      kind += text[i];
  }
  if (shown_.insert(kind).second) {
    progress_.remark({RemarkCode::kDoubtful, "warning: " + text});
  } else if (!more_) {
    progress_.remark({RemarkCode::kDoubtful,
                      "warning: it is so in more frames",
                      {Hint::set("report").so("writes them all")}});
    more_ = true;
  }
}

bool ReconstructedFrames::finished(int index) {
  const auto i = static_cast<std::size_t>(index);
  if (finished_[i] == 0) {
    const bool bars =
        !settings_.errorBars || work_.sound(numberOf(index), keys_[i] + kDeviationKey);
    finished_[i] = bars && work_.sound(numberOf(index), keys_[i]) ? 1 : 0;
  }
  return finished_[i] != 0;
}

int ReconstructedFrames::chainOf(int index) const {
  return *std::prev(std::ranges::upper_bound(chains_, index));
}

Status ReconstructedFrames::solveAll(Team& team) {
  shares_ = team.size() > 1;
  StopOnly quiet(progress_);
  VOLUTE_TRY(team.forUnits(
      "reconstructing", static_cast<std::int64_t>(chains_.size()),
      shares_ ? progress_ : static_cast<Progress&>(quiet), [&](std::int64_t chain) -> Status {
        const auto i = static_cast<std::size_t>(chain);
        const int end = i + 1 < chains_.size() ? chains_[i + 1] : info_.frames;
        for (int index = chains_[i]; index < end; ++index) {
          if (!finished(index))
            VOLUTE_TRY(solve(index));
          if (!shares_)
            progress_.report("reconstructing", solved_, info_.frames - resumed_);
        }
        return {};
      }));
  progress_.detail("");
  return {};
}

Status ReconstructedFrames::solveUpTo(int index) {
  for (int i = chainOf(index); i <= index; ++i) {
    if (!finished(i))
      VOLUTE_TRY(solve(i));
  }
  return {};
}

void ReconstructedFrames::toChannels(std::span<const float> colour, std::span<float> values) const {
  const std::size_t step = grey_ ? 3 : 1;
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = colour[step * i];
}

Status ReconstructedFrames::readFrame(int index, std::span<float> values) {
  VOLUTE_TRY(solveUpTo(index));
  VOLUTE_ASSIGN(const auto colour, volume(index));
  toChannels(colour, values);
  return {};
}

Status ReconstructedFrames::ErrorBars::readFrame(int index, std::span<float> values) {
  VOLUTE_TRY(frames_.solveUpTo(index));
  const std::string key = frames_.keys_[static_cast<std::size_t>(index)] + kDeviationKey;
  VOLUTE_ASSIGN(const auto colour,
                frames_.work_.values(frames_.numberOf(index), key, frames_.colourValues()));
  frames_.toChannels(colour, values);
  return {};
}

Result<std::vector<float>> ReconstructedFrames::volume(int index) const {
  return work_.values(numberOf(index), keys_[static_cast<std::size_t>(index)], colourValues());
}

Result<std::vector<float>> ReconstructedFrames::emission(int index) const {
  VOLUTE_ASSIGN(auto values, volume(index));
  if (!settings_.singleScattering)
    return values;
  const auto extinction = greyVolume(values);
  const auto source = lampSource(capture_.lighting, geometry(), extinction, extinction);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] *= source[i];
  return values;
}

Result<FrameViews> ReconstructedFrames::views(int index) {
  VOLUTE_ASSIGN(FrameViews views, views_.read(numberOf(index)));
  if (!takesOwnLight())
    return views;
  VOLUTE_ASSIGN(const auto values, volume(index));
  VOLUTE_ASSIGN(const auto light, emission(index));
  const Pyrometer pyrometer(capture_.spectrum);
  const auto soot =
      settings_.flame ? sootOf(pyrometer, geometry().resolution, light) : std::vector<Soot>{};
  for (TomographyView& view : views.views) {
    const auto factors = settings_.flame
                             ? sootAttenuation(pyrometer, soot, view.camera, geometry(), light)
                             : selfAttenuation(view.camera, geometry(), greyVolume(values), light);
    const std::size_t each = settings_.flame ? 1 : 3;
    for (std::size_t i = 0; i < view.radiance.pixels.size(); ++i)
      view.radiance.pixels[i] *= factors[i / each];
  }
  if (!views.chosen.empty())
    views.chosen = views.fittedWithout(views.views.size());
  return views;
}

Result<double> ReconstructedFrames::residualOf(int index, std::span<const float> values) {
  VOLUTE_ASSERT(values.size() == info_.voxels() * static_cast<std::size_t>(info_.channels));
  std::vector<float> colour(colourValues());
  const std::size_t step = grey_ ? 3 : 1;
  for (std::size_t i = 0; i < colour.size(); ++i) colour[i] = values[i / step];
  VOLUTE_ASSIGN(const FrameViews views, views_.read(numberOf(index)));
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < views.views.size(); ++i) {
    if (views.heldOut[i] || views.facts[i].missing)
      continue;
    const TomographyOptions& options = settings_.tomography;
    const Image seen = projectVolume(colour, geometry(), options.basis, views.views[i].camera,
                                     options.raysPerPixel);
    sum += volute::residualOf(views.views[i], seen, options.noiseSigma).relative;
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

Result<nlohmann::ordered_json> ReconstructedFrames::record(int index) const {
  return work_.record(numberOf(index), keys_[static_cast<std::size_t>(index)]);
}

/// Faults end the run unless it is forced.
Result<std::vector<std::string>> ReconstructedFrames::examine(const FrameViews& views,
                                                              const PictureFindings& findings) {
  std::vector<std::string> warnings = findings.warnings;
  if (!findings.faults.empty() && !settings_.force)
    return fail(ErrorCode::kInvalidData, Hint::set("force").so("goes on"), "{}",
                findings.faults.front());
  warnings.insert(warnings.end(), findings.faults.begin(), findings.faults.end());
  if (findings.dark)
    warnings.push_back(fmt::format("frame {}: no camera sees any {}; the volume is 0", views.frame,
                                   views.opticalDepth ? "medium" : "light"));
  return warnings;
}

/// The prior is chosen anew every few frames. Only where frames build upon each other anyway: else
/// they stay independent.
Result<TomographyOptions> ReconstructedFrames::optionsOf(int index) const {
  constexpr int kEvery = 10;
  TomographyOptions options = settings_.tomography;
  if (!settings_.warmStart || (index - chainOf(index)) % kEvery == 0)
    return options;
  VOLUTE_ASSIGN(const auto before, record(index - 1));
  const auto choice = before.find("choice");
  if (choice == before.end() || !choice->is_object())
    return options;
  options.choice = TomographyChoice{
      regularizationByName(choice->value("regularization", "none")).value_or(Regularization::kNone),
      choice->value("strength", 0.0), choice->value("sparsity", 0.0),
      choice->value("iterations", 1)};
  return options;
}

/// Whether the motion between the two frames before says what to expect of one.
bool ReconstructedFrames::carriesOn(int index) const {
  return settings_.tomography.temporal > 0 && index - chainOf(index) >= 2 &&
         numberOf(index) - numberOf(index - 1) == numberOf(index - 1) - numberOf(index - 2);
}

/// What a frame starts from: the one before in its chain, with a temporal prior carried on by the
/// motion between the two before; empty where there is none.
Result<std::vector<float>> ReconstructedFrames::frameBefore(int index) {
  const int begin = chainOf(index);
  if (index == begin)
    return std::vector<float>{};
  VOLUTE_ASSIGN(auto before, volume(index - 1));
  // A dark frame tells nothing, and multiplicative solvers never leave zero.
  if (std::ranges::none_of(before, [](float value) { return value != 0; }))
    return std::vector<float>{};
  if (!carriesOn(index))
    return before;
  VOLUTE_ASSIGN(const auto earlier, volume(index - 2));
  StopOnly quiet(progress_);
  VOLUTE_ASSIGN(const auto flow, flowBetween(greyVolume(earlier), greyVolume(before),
                                             geometry().resolution, {}, quiet));
  return carriedOn(before, 3, flow);
}

/// What stands in the way of a camera carves no hole.
Status ReconstructedFrames::leaveOutOccluded(FrameViews& views,
                                             std::vector<std::string>& warnings) {
  std::vector<std::size_t> cameras;
  for (std::size_t i = 0; i < views.views.size(); ++i) {
    if (!views.heldOut[i] && !views.facts[i].missing)
      cameras.push_back(i);
  }
  if (!settings_.tomography.hull || cameras.size() < 4)
    return {};
  std::vector<TomographyView> some;
  const bool all = cameras.size() == views.views.size();
  if (!all) {
    for (const std::size_t i : cameras) some.push_back(views.views[i]);
  }
  StopOnly quiet(progress_);
  VOLUTE_ASSIGN(
      const auto found,
      findOcclusions(all ? std::span<const TomographyView>(views.views) : some, geometry(), quiet));
  for (const Occlusion& occlusion : found) {
    TomographyView& view = views.views[cameras[occlusion.view]];
    leaveOut(occlusion, view);
    warnings.push_back(fmt::format(
        "camera {}, frame {}: something dark seems to be in front of the medium: {:.0f} % of its "
        "light is missing where the other cameras tell of it; these pixels are left out (state a "
        "\"mask\")",
        view.name, views.frame, 100 * occlusion.share));
  }
  if (!found.empty() && !views.chosen.empty())
    views.chosen = views.fittedWithout(views.views.size());
  return {};
}

std::vector<std::size_t> ReconstructedFrames::fittedOf(const FrameViews& views) {
  std::vector<std::size_t> fitted;
  for (std::size_t i = 0; i < views.views.size(); ++i) {
    if (!views.heldOut[i])
      fitted.push_back(i);
  }
  return fitted;
}

Result<Reconstruction> ReconstructedFrames::fitLit(FrameViews& views,
                                                   const TomographyOptions& options,
                                                   std::vector<float>& extinction,
                                                   Progress& progress) {
  VOLUTE_ASSIGN(auto lit, reconstructLit(views.views, fittedOf(views), geometry(), options,
                                         capture_.lighting, progress));
  if (!views.chosen.empty())
    views.chosen = views.fittedWithout(views.views.size());
  extinction = std::move(lit.extinction);
  return std::move(lit.fit);
}

/// @param extinction  of a medium that lamps light: [1/m], (z, y, x); the views are then those
///   without attenuation.
Result<Reconstruction> ReconstructedFrames::fit(int index, FrameViews& views,
                                                std::vector<float>& extinction) {
  std::vector<float> before;
  if (!settings_.singleScattering) {  // what is stored is not what is fitted
    VOLUTE_ASSIGN(before, frameBefore(index));
  }
  VOLUTE_ASSIGN(TomographyOptions options, optionsOf(index));
  if (!carriesOn(index) || settings_.singleScattering)
    options.temporal = 0;
  FrameProgress progress(progress_, views.frame, solved_, shares_ ? 0 : info_.frames - resumed_);
  auto result = settings_.singleScattering ? fitLit(views, options, extinction, progress)
                : settings_.flame
                    ? reconstructFlame(views.views, fittedOf(views), geometry(), options,
                                       Pyrometer(capture_.spectrum), before, progress)
                    : reconstruct(views.fitted(), geometry(), options, before, progress);
  if (settings_.flame && !views.chosen.empty())
    views.chosen = views.fittedWithout(views.views.size());
  if (result)
    return result;
  if (result.error().code == ErrorCode::kNotFound) {
    return fail(ErrorCode::kInvalidData, "{}",
                explainEmptyHull(views, geometry(), settings_.tomography.noiseSigma));
  }
  return fail(result.error().code, result.error().hints, "frame {}: {}", views.frame,
              result.error().message);
}

namespace {

/// The factor on what a camera saw that comes nearest to `seen`.
double bestGain(const TomographyView& view, const Image& inColour) {
  const Image seen = asSeenBy(view, inColour);
  double both = 0, own = 0;
  for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
    if (!view.counts(i / 3))
      continue;
    both += static_cast<double>(seen.pixels[i]) * view.radiance.pixels[i];
    own += static_cast<double>(view.radiance.pixels[i]) * view.radiance.pixels[i];
  }
  return both > 0 && own > 0 ? both / own : 1;
}

}  // namespace

/// A camera whose picture of a neighbouring frame fits what the others saw better than its own.
std::optional<std::string> ReconstructedFrames::outOfStep(std::size_t camera,
                                                          const FrameViews& views,
                                                          const Reconstruction& result) {
  constexpr int kIterations = 60;
  constexpr double kClearly = 0.8;
  TomographyOptions options = settings_.tomography;
  options.iterations = kIterations;
  StopOnly quiet(progress_);
  const auto fit =
      reconstruct(views.fittedWithout(camera), geometry(), options, result.volume, quiet);
  if (!fit)
    return std::nullopt;
  const Image seen = projectVolume(fit->volume, geometry(), options.basis,
                                   views.views[camera].camera, options.raysPerPixel);
  const double own = volute::residualOf(views.views[camera], seen, options.noiseSigma).relative;
  const double gain = bestGain(views.views[camera], seen);
  TomographyView brighter = views.views[camera];
  for (float& light : brighter.radiance.pixels) light *= static_cast<float>(gain);
  const double scaled = volute::residualOf(brighter, seen, options.noiseSigma).relative;
  double best = own;
  int shift = 0;
  for (const int by : {-2, -1, 1, 2}) {
    const auto view =
        views.frame + by < 0 ? std::nullopt : views_.neighbour(camera, views.frame + by);
    if (!view)
      continue;
    const double residual = volute::residualOf(*view, seen, options.noiseSigma).relative;
    if (residual < best) {
      best = residual;
      shift = by;
    }
  }
  if (!(best < kClearly * own))
    return std::nullopt;
  // Neighbours are nearly the same picture.
  constexpr double kAsGood = 1.2;
  if (scaled < kAsGood * best) {
    return fmt::format(
        "camera {}, frame {}: {:.0f} % too {}: its radiance times {:.3f} fits what the other "
        "cameras saw",
        views.views[camera].name, views.frame, 100 * std::abs(1 / gain - 1),
        gain < 1 ? "bright" : "dark", gain);
  }
  return fmt::format(
      "camera {}, frame {}: its picture of frame {} fits what the other cameras saw better "
      "(relative "
      "L2 {:.3f}) than its own ({:.3f}): it seems to run {} frame{} {}",
      views.views[camera].name, views.frame, views.frame + shift, best, own, std::abs(shift),
      std::abs(shift) == 1 ? "" : "s", shift > 0 ? "late" : "early");
}

/// A camera's warning; for one that does not fit, its clock's if its picture of another frame does.
std::optional<std::string> ReconstructedFrames::explained(std::size_t camera,
                                                          const CameraDiagnosis& found,
                                                          const FrameViews& views,
                                                          const Reconstruction& result) {
  // Another frame that fits better is evidence enough for a camera that stands out a little.
  constexpr double kSuspicious = 1.5;
  if (found.outOfStep || (!found.gainDrift && found.residualRatio > kSuspicious)) {
    if (auto text = outOfStep(camera, views, result))
      return text;
  }
  if (found.warning.empty())
    return std::nullopt;
  return fmt::format("camera {}, frame {}: {}", views.views[camera].name, views.frame,
                     found.warning);
}

/// All principal points half a pixel off, which most often is a wrong convention of pixel centres.
/// Other faults gain from such a shift too, but not most of their residual.
Result<std::optional<std::string>> ReconstructedFrames::commonShift(const FrameViews& views,
                                                                    const Reconstruction& result,
                                                                    bool othersWarn) {
  constexpr double kMin = 0.35;                   // pixels
  const double better = othersWarn ? 0.7 : 0.97;  // times the residual
  StopOnly quiet(progress_);
  VOLUTE_ASSIGN(const auto shift,
                findCommonShift(views.fitted(), geometry(), settings_.tomography, result, quiet));
  if (!shift || std::abs(shift->pixels) < kMin || shift->nearest > better * shift->residual)
    return std::nullopt;
  const bool right = shift->pixels > 0;
  const double centre = right ? 0 : 0.5;
  const std::string cause =
      centre != capture_.pixelCentre
          ? fmt::format("is the centre of the first pixel at {}, not at {}?", centre,
                        capture_.pixelCentre)
          : "was the calibration made with other pictures, or are they cropped?";
  return fmt::format(
      "frame {}: one volume fits all pictures better where principal points are half a pixel "
      "further to the {} (relative L2 {:.4f} instead of {:.4f}, least at {:+.2f} pixels): {}",
      views.frame, right ? "right and down" : "left and up", shift->nearest, shift->residual,
      shift->pixels, cause);
}

namespace {

/// What is left of the pictures, where it is much more than noise and the size of the voxels
/// explain and nothing else was said: some cause is there, known or not.
std::optional<std::string> unexplained(const FrameViews& views,
                                       const TomographyDiagnosis& diagnosis,
                                       const Reconstruction& result) {
  constexpr double kMuch = 0.15, kTimes = 2;
  std::vector<double> residuals, explained;
  for (std::size_t v = 0; v < diagnosis.cameras.size(); ++v) {
    residuals.push_back(diagnosis.cameras[v].residual);
    explained.push_back(diagnosis.cameras[v].explained);
  }
  const auto medianOf = [](std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return *middle;
  };
  if (residuals.empty())
    return std::nullopt;
  const double left = medianOf(residuals), voxels = medianOf(explained);
  if (left < std::max(kMuch, kTimes * voxels))
    return std::nullopt;
  return fmt::format(
      "frame {}: {:.0f} % of the pictures are not explained (relative L2 without noise, median), "
      "of "
      "which the size of the voxels explains {:.0f} %{}; check calibration, bounds and how values "
      "are "
      "stored, and do not trust the volume",
      views.frame, 100 * left, 100 * std::min(voxels, left),
      result.stoppedBy == "limit" || result.stoppedBy == "iterations"
          ? fmt::format("; the solver stopped after {} iterations", result.iterations)
          : std::string());
}

}  // namespace

Result<std::vector<std::string>> ReconstructedFrames::diagnosed(const FrameViews& views,
                                                                const Reconstruction& result,
                                                                nlohmann::ordered_json& cameras) {
  StopOnly quiet(progress_);
  const auto& named = settings_.causeNamedIn;
  const bool causeNamed =
      settings_.causeNamed || std::ranges::find(named, views.frame) != named.end();
  VOLUTE_ASSIGN(const auto diagnosis,
                diagnose(views.fitted(), geometry(), settings_.tomography, result, quiet));
  std::vector<std::string> warnings;
  for (const std::string& warning : causeNamed ? std::vector<std::string>{} : diagnosis.warnings)
    warnings.push_back(fmt::format("frame {}: {}", views.frame, warning));
  std::size_t next = 0;
  for (std::size_t camera = 0; camera < views.views.size(); ++camera) {
    if (views.heldOut[camera])
      continue;
    const CameraDiagnosis& found = diagnosis.cameras[next++];
    cameras[camera]["gain"] = jsonNumber(found.gain);
    cameras[camera]["residual_ratio"] = jsonNumber(found.residualRatio);
    if (causeNamed)
      continue;
    if (const auto warning = explained(camera, found, views, result))
      warnings.push_back(*warning);
  }
  if (!shiftJudged_ && !causeNamed) {
    VOLUTE_ASSIGN(const auto warning, commonShift(views, result, !warnings.empty()));
    if (warning)
      warnings.insert(warnings.begin(), *warning);  // what else was said may come of it
  }
  shiftJudged_ = shiftJudged_ || named.empty() || !causeNamed;
  if (warnings.empty() && !causeNamed) {
    if (const auto warning = unexplained(views, diagnosis, result))
      warnings.push_back(*warning);
  }
  return warnings;
}

/// Each camera's residual, held-out ones too, and what its picture said.
nlohmann::ordered_json ReconstructedFrames::measured(const FrameViews& views,
                                                     const Reconstruction& result) const {
  auto cameras = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < views.views.size(); ++i) {
    const TomographyView& view = views.views[i];
    const auto residual =
        volute::residualOf(view,
                           projectVolume(result.volume, geometry(), settings_.tomography.basis,
                                         view.camera, settings_.tomography.raysPerPixel),
                           settings_.tomography.noiseSigma);
    const bool missing = views.facts[i].missing;
    cameras.push_back({{"name", view.name},
                       {"held_out", views.heldOut[i] != 0},
                       {"residual", missing ? Json() : jsonNumber(residual.relative)},
                       {"psnr", missing ? Json() : jsonNumber(residual.psnr)},
                       {"saturated_share", views.facts[i].saturatedShare},
                       {"masked_share", views.facts[i].maskedShare}});
    if (views.opticalDepth)
      cameras.back()["opaque_share"] = views.facts[i].opaqueShare;
    if (views.facts[i].gain != 1)
      cameras.back()["gain_by_frame"] = views.facts[i].gain;
    if (const auto& drift = views.facts[i].drift)
      cameras.back()["background_drift"] = {{"gain", drift->gain}, {"offset", drift->offset}};
  }
  return cameras;
}

/// Before the frame itself is stored, so that both are there or none.
Status ReconstructedFrames::addErrorBars(int index, const FrameViews& views,
                                         const Reconstruction& result,
                                         nlohmann::ordered_json& record) {
  VoxelUncertainty bars;
  bars.sigma.assign(colourValues(), 0);
  if (result.stoppedBy != "dark") {
    FrameProgress progress(progress_, views.frame, solved_, shares_ ? 0 : info_.frames - resumed_);
    VOLUTE_ASSIGN(bars, estimateUncertainty(views.fitted(), geometry(), settings_.tomography,
                                            result, progress));
  }
  record["uncertainty"] = {{"expected_error", jsonNumber(bars.expectedError)},
                           {"channel_correlation", jsonNumber(bars.channelCorrelation)},
                           {"prior_share", jsonNumber(bars.priorShare)},
                           {"scale", bars.scale},
                           {"predicted_cameras", bars.heldOut}};
  return work_.store(numberOf(index), keys_[static_cast<std::size_t>(index)] + kDeviationKey,
                     bars.sigma, record["uncertainty"]);
}

Status ReconstructedFrames::solve(int index) {
  const auto start = std::chrono::steady_clock::now();
  const int number = numberOf(index);
  if (progress_.cancelled())
    return fail(ErrorCode::kCancelled, "stopped before frame {}", number);
  VOLUTE_ASSIGN(FrameViews views, views_.read(number));
  const auto findings =
      checkPictures(views, geometry(), settings_.tomography.noiseSigma, settings_.limits);
  VOLUTE_ASSIGN(auto warnings, examine(views, findings));
  if (settings_.flame && views.grey() && !findings.dark)
    return fail(ErrorCode::kInvalidData,
                "frame {}: its pictures are grey; a temperature needs the colours of a flame",
                number);
  Reconstruction result;
  std::vector<float> extinction;
  if (findings.dark) {
    result.volume.assign(colourValues(), 0);
    result.hullShare = 0;
    result.stoppedBy = "dark";
  } else {
    VOLUTE_TRY(leaveOutOccluded(views, warnings));
    auto fitted = fit(index, views, extinction);
    if (!fitted) {  // what was seen in the pictures may be why
      for (const std::string& warning : warnings) warn(warning);
      return tl::unexpected<Error>(fitted.error());
    }
    result = std::move(*fitted);
  }
  auto cameras = measured(views, result);
  if (!findings.dark) {
    VOLUTE_ASSIGN(const auto more, diagnosed(views, result, cameras));
    warnings.insert(warnings.end(), more.begin(), more.end());
  }
  for (const std::string& warning : warnings) warn(warning);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  nlohmann::ordered_json record = {{"frame", number},
                                   {"iterations", result.iterations},
                                   {"search_iterations", result.searchIterations},
                                   {"stopped_by", result.stoppedBy},
                                   {"regularization", regularizationName(result.regularization)},
                                   {"lambda", jsonNumber(result.lambda)},
                                   {"sparsity", jsonNumber(result.sparsity)},
                                   {"choice", choiceJson(result.choice)},
                                   {"hull_share", jsonNumber(result.hullShare)},
                                   {"pixels", result.pixels},
                                   {"held_out_pixel_error", jsonNumber(result.heldOutError)},
                                   {"seconds", jsonNumber(seconds.count())},
                                   {"cameras", cameras},
                                   {"warnings", warnings}};
  if (settings_.errorBars)
    VOLUTE_TRY(addErrorBars(index, views, result, record));
  ++solved_;
  for (std::size_t i = 0; i < 3 * extinction.size(); ++i) result.volume[i] = extinction[i / 3];
  VOLUTE_TRY(work_.store(number, keys_[static_cast<std::size_t>(index)], result.volume, record));
  finished_[static_cast<std::size_t>(index)] = 1;
  return {};
}

}  // namespace volute
