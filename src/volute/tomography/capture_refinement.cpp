// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/capture_refinement.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <optional>

#include "volute/report/json.hpp"
#include "volute/tomography/capture_faults.hpp"
#include "volute/tomography/frame_views.hpp"
#include "volute/tomography/occlusion.hpp"

namespace volute {
namespace {

constexpr std::size_t kFewestViews = 4;
constexpr std::size_t kMaxFrames = 8;
constexpr std::size_t kFew = 4;  // frames that take no more memory than one
constexpr double kDegrees = 180 / std::numbers::pi;

/// At most `most` places of so many, spread evenly.
std::vector<std::size_t> spread(std::size_t all, std::size_t most) {
  const std::size_t count = std::min(all, most);
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < count; ++i) places.push_back((2 * i + 1) * all / (2 * count));
  return places;
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) /
         static_cast<double>(std::max<std::size_t>(1, values.size()));
}

bool shinesEverywhere(const std::vector<TomographyView>& views) {
  return std::ranges::all_of(views, [](const TomographyView& view) {
    return std::ranges::any_of(view.radiance.pixels, [](float value) { return value > 0; });
  });
}

double medianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Root mean square over points of the volume [pixels].
double pixelsMoved(const Camera& from, const Camera& to, const Box3& bounds) {
  double squares = 0;
  int seen = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 side(corner & 1 ? 0.25 : -0.25, corner & 2 ? 0.25 : -0.25,
                    corner & 4 ? 0.25 : -0.25);
    const Vec3 point = bounds.centre() + side.cwiseProduct(bounds.size());
    const auto before = from.project(point), after = to.project(point);
    if (!before || !after)
      continue;
    squares += (*after - *before).squaredNorm();
    ++seen;
  }
  return std::sqrt(squares / std::max(1, seen));
}

/// Corrections that are worth it: what was left becomes clearly less. Voxels that are too coarse,
/// and noise, leave as much after as before; pictures of another camera or time leave much after.
bool pays(const CaptureRefinement& refinement) {
  constexpr double kWorthALook = 0.02, kBetter = 0.8, kMuchBetter = 0.65, kGood = 0.15;
  const double left = refinement.after / std::max(refinement.before, 1e-12);
  return refinement.before > kWorthALook &&
         (left < kMuchBetter || (left < kBetter && refinement.after < kGood));
}

/// Whether a mistake is a number that refinement has, if far off.
bool refinementMends(const CaptureFault& fault) {
  return !fault.cameras.empty() &&
         (fault.kind == CaptureFault::Kind::kGain || fault.kind == CaptureFault::Kind::kBalance ||
          fault.kind == CaptureFault::Kind::kZoom || fault.kind == CaptureFault::Kind::kLens);
}

using Frames = std::vector<std::vector<TomographyView>>;

/// What is wrong with single pictures.
struct PictureFault {
  std::string text;
  std::vector<std::size_t> views;
  std::vector<int> frames;  // numbers
};

/// Refines what was looked at, and finds clocks that are wrong by whole frames.
class Refiner {
 public:
  Refiner(const Capture& capture, ViewReader& reader, std::uint64_t maxMemory, Progress& progress)
      : capture_(capture), reader_(reader), maxMemory_(maxMemory), progress_(progress) {}

  /// Frames that can be read and in which every camera sees light; as many as fit. What stands in
  /// front of one camera does not count.
  Status read() {
    reader_.keepBackgrounds();
    frames_.clear();
    numbers_.clear();
    occlusions_.clear();
    // Trying other clocks copies them, and looking for mistakes reduces them.
    const std::uint64_t fitting = maxMemory_ / 6 / std::max<std::uint64_t>(1, frameBytes());
    const std::size_t most = std::clamp<std::uint64_t>(fitting, 1, kMaxFrames);
    for (const std::size_t place : spread(capture_.frames.size(), most)) {
      const int number = capture_.frames[place];
      if (std::ranges::find(faulty_, number) != faulty_.end())
        continue;
      auto read = reader_.read(number);
      // A frame that cannot be read is told when its turn comes, and so is a mosaic.
      if (!read || std::ranges::any_of(read->facts, &PictureFacts::mosaic))
        continue;
      const auto fitted = read->fitted();
      std::vector<TomographyView> views(fitted.begin(), fitted.end());
      if (!shinesEverywhere(views))
        continue;
      frames_.push_back(std::move(views));
      numbers_.push_back(number);
    }
    if (!frames_.empty())
      shifts_.assign(frames_[0].size(), 0);
    return findOccluded(nullptr);
  }

  /// Looks for what stands in front of one camera and leaves it out.
  /// @param fit  where cameras are now known to be; null: as given
  Status findOccluded(const CalibrationFit* fit) {
    for (const std::size_t f : someFrames()) {
      std::vector<TomographyView> placed = frames_[f];
      for (std::size_t v = 0; fit != nullptr && v < placed.size(); ++v) {
        placed[v].camera = fit->cameras[v];
        const auto gain = static_cast<float>(fit->corrections[v].gain());
        for (float& value : placed[v].radiance.pixels) value *= gain;
      }
      VOLUTE_ASSIGN(auto found, findOcclusions(placed, geometry(), progress_));
      std::ranges::move(found, std::back_inserter(occlusions_));
    }
    for (auto& views : frames_) {
      for (std::size_t v = 0; v < views.size(); ++v) leaveOutOccluded(v, views[v]);
    }
    return {};
  }

  const Frames& frames() const { return frames_; }

  const std::vector<int>& numbers() const { return numbers_; }

  const std::vector<int>& shifts() const { return shifts_; }

  /// Mistakes of all frames, as far as one in the middle and the others tell.
  /// @param own  gets those of single pictures; their frames are looked at no more
  Result<std::vector<CaptureFault>> faults(std::vector<PictureFault>& own) {
    const std::size_t middle = frames_.size() / 2;
    const std::vector<double> white = whites(frames_[middle]);
    VOLUTE_ASSIGN(auto found, findCaptureFaults(frames_[middle], white, geometry(), progress_,
                                                capture_.pixelCentre));
    for (CaptureFault& fault : found) tellByStatedCurve(fault, frames_[middle]);
    if (frames_.size() == 1)
      return found;
    std::vector<FramesFault> some;
    std::vector<CaptureFault> common;
    for (CaptureFault& fault : found) {
      if (isGainOfLight(fault)) {
        VOLUTE_TRY(compareGains(fault));
        common.push_back(std::move(fault));
        continue;
      }
      FramesFault one{std::move(fault), {middle}};
      for (std::size_t f = 0; f < frames_.size() && !one.fault.cameras.empty(); ++f) {
        if (f == middle)
          continue;
        VOLUTE_ASSIGN(const bool has,
                      hasCaptureFault(one.fault, frames_[f], white, geometry(), progress_));
        if (has)
          one.frames.push_back(f);
      }
      // Of two frames neither is the odd one.
      const bool all = one.fault.cameras.empty() || 2 * one.frames.size() > frames_.size() ||
                       frames_.size() == 2;
      if (all)
        common.push_back(std::move(one.fault));
      else
        some.push_back(std::move(one));
    }
    if (common.empty()) {
      VOLUTE_TRY(findOwnFaults(middle, some));
      VOLUTE_TRY(moveGains(some, common));
    }
    for (FramesFault& one : some) {
      std::ranges::sort(one.frames);
      std::vector<int> numbers;
      for (const std::size_t f : one.frames) numbers.push_back(numbers_[f]);
      own.push_back(
          {describeInFrames(one.fault, frames_[middle], numbers), one.fault.cameras, numbers});
      std::ranges::copy(numbers, std::back_inserter(faulty_));
    }
    forgetFaulty();
    return common;
  }

  /// Frames in which single pictures have mistakes.
  const std::vector<int>& faulty() const { return faulty_; }

  /// @param extended  lenses and responses, too
  Result<CalibrationFit> fit(bool fine, bool extended) const {
    return fitOf(frames_, fine, extended);
  }

  /// Changes the clocks of cameras that stand out even as refined and fit clearly better with the
  /// pictures of other times. Returns the fit with these.
  Result<CalibrationFit> withClocks(CalibrationFit fit) {
    for (std::size_t tried = 0; 3 * tried < shifts_.size(); ++tried) {
      const auto worst = outstanding(fit);
      if (!worst)
        break;
      VOLUTE_ASSIGN(auto better, otherClock(*worst, fit));
      if (!better)
        break;
      fit = std::move(*better);
    }
    return fit;
  }

 private:
  /// A mistake in some of the frames.
  struct FramesFault {
    CaptureFault fault;
    std::vector<std::size_t> frames;
  };

  /// Whether a camera's values are taken as linear: as floats are, and where the capture says so.
  bool takenAsLinear(const std::string& name) const {
    const auto camera = findCamera(capture_, name);
    if (!camera)
      return false;
    const PictureSource& pictures = capture_.cameras[*camera].pictures;
    return pictures.linear ||
           (pictures.response && pictures.response->kind() == Response::Kind::kLinear);
  }

  /// A curve that fits is another one than that which the capture states.
  void tellByStatedCurve(CaptureFault& fault, const std::vector<TomographyView>& views) const {
    constexpr double kLikeSrgb = 2.2;
    const bool encoded = fault.kind == CaptureFault::Kind::kEncoded;
    if (!encoded && fault.kind != CaptureFault::Kind::kDecoded)
      return;
    bool taken = true;  // as the fault says
    for (std::size_t v = 0; v < views.size(); ++v) {
      if (fault.cameras.empty() || std::ranges::find(fault.cameras, v) != fault.cameras.end())
        taken = taken && takenAsLinear(views[v].name) == encoded;
    }
    if (taken)
      return;
    CaptureFault curve = fault;
    curve.kind = CaptureFault::Kind::kExponent;
    curve.value = encoded ? kLikeSrgb : 1 / kLikeSrgb;
    fault.text = describeFault(curve, views, capture_.pixelCentre);
  }

  /// None: depths follow no response.
  std::vector<double> whites(const std::vector<TomographyView>& views) const {
    std::vector<double> white;
    for (const TomographyView& view : views) {
      if (!view.opticalDepth)
        white.push_back(capture_.white * known(view.name).pictures.lightGain());
    }
    return white;
  }

  bool isGainOfLight(const CaptureFault& fault) const {
    return fault.kind == CaptureFault::Kind::kGain && !frames_[0][fault.cameras[0]].opticalDepth;
  }

  /// Whether the gain of a camera is another one in other frames.
  Status compareGains(CaptureFault& fault) const {
    constexpr double kSteady = 1.08;
    const std::size_t camera = fault.cameras[0];
    std::vector<double> gains;
    for (const auto& views : frames_) {
      std::vector<TomographyView> others = views;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(camera));
      VOLUTE_ASSIGN(const double gain,
                    gainByOthers(views[camera], std::move(others), geometry(), progress_));
      gains.push_back(gain);
    }
    const auto [least, most] = std::ranges::minmax(gains);
    fault.byFrame = most > kSteady * least;
    if (fault.byFrame)
      fault.text = describeGains(frames_[0][camera].name, numbers_, gains);
    return {};
  }

  /// Gains of some frames are gains of all, as large or each another one.
  Status moveGains(std::vector<FramesFault>& some, std::vector<CaptureFault>& common) const {
    for (FramesFault& one : some) {
      const bool known = std::ranges::any_of(
          common, [&](const CaptureFault& other) { return other.cameras == one.fault.cameras; });
      if (!isGainOfLight(one.fault) || known)
        continue;
      VOLUTE_TRY(compareGains(one.fault));
      common.push_back(one.fault);
    }
    std::erase_if(some, [&](const FramesFault& one) { return isGainOfLight(one.fault); });
    return {};
  }

  /// Mistakes of the frames beside the middle one, added to those of its own.
  Status findOwnFaults(std::size_t middle, std::vector<FramesFault>& some) const {
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      const bool known = std::ranges::any_of(some, [&](const FramesFault& one) {
        return std::ranges::find(one.frames, f) != one.frames.end();
      });
      if (f == middle || known)
        continue;
      VOLUTE_ASSIGN(auto found, findPictureFaults(frames_[f], geometry(), progress_));
      for (CaptureFault& fault : found) {
        const auto same = std::ranges::find_if(some, [&](const FramesFault& one) {
          constexpr double kNearly = 1.1;
          const double ratio = one.fault.value / fault.value;
          return one.fault.kind == fault.kind && one.fault.cameras == fault.cameras &&
                 ratio < kNearly && ratio > 1 / kNearly;
        });
        if (same == some.end())
          some.push_back({std::move(fault), {f}});
        else
          same->frames.push_back(f);
      }
    }
    return {};
  }

  /// Leaves out frames with mistakes of their own, if others are left.
  void forgetFaulty() {
    Frames frames;
    std::vector<int> numbers;
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      if (std::ranges::find(faulty_, numbers_[f]) != faulty_.end())
        continue;
      frames.push_back(std::move(frames_[f]));
      numbers.push_back(numbers_[f]);
    }
    frames_ = std::move(frames);
    numbers_ = std::move(numbers);
  }

  Result<CalibrationFit> fitOf(const Frames& frames, bool fine, bool extended = false) const {
    CalibrationFitOptions options{
        .fine = fine, .lens = extended, .exponent = {}, .maxMemory = maxMemory_ / 2};
    for (std::size_t v = 0; extended && v < frames[0].size(); ++v)
      options.exponent.push_back(hasResponse(frames[0][v]) ? 1 : 0);
    auto fit = refineCalibration(frames, geometry(), options, progress_);
    if (fit || fit.error().code != ErrorCode::kTooLarge || frames.size() <= kFew)
      return fit;
    Frames few;
    for (const std::size_t f : spread(frames.size(), kFew)) few.push_back(frames[f]);
    return refineCalibration(few, geometry(), options, progress_);
  }

  /// Three of the frames, or as many as there are, for what is costly and looked for in each: an
  /// early one, one in the middle and a late one.
  std::vector<std::size_t> someFrames() const {
    constexpr std::size_t kSome = 3;
    return spread(frames_.size(), kSome);
  }

  /// Whether its exponent means anything: floats are linear, and an exponent of light is a
  /// factor of optical depths, which the gain has.
  bool hasResponse(const TomographyView& view) const {
    return !view.opticalDepth && !known(view.name).pictures.linear;
  }

  /// Pictures of one frame [bytes].
  std::uint64_t frameBytes() const {
    constexpr std::uint64_t kPixel = 12 + 12 + 4 + 1;
    std::uint64_t pixels = 0;
    for (const CaptureCamera& known : capture_.cameras)
      pixels += static_cast<std::uint64_t>(known.camera.width()) * known.camera.height();
    return pixels * kPixel;
  }

  /// What stands in front of a camera, in any of the frames that were looked at.
  void leaveOutOccluded(std::size_t camera, TomographyView& view) const {
    for (const Occlusion& one : occlusions_) {
      if (one.view == camera)
        leaveOut(one, view);
    }
  }

  VolumeGeometry geometry() const { return {capture_.volume.bounds, capture_.volume.resolution}; }

  const CaptureCamera& known(const std::string& name) const {
    return capture_.cameras[*findCamera(capture_, name)];
  }

  /// The camera that is explained least, where it is much less than the others.
  static std::optional<std::size_t> outstanding(const CalibrationFit& fit) {
    constexpr double kTimes = 1.5, kMin = 0.02;
    const auto worst =
        static_cast<std::size_t>(std::ranges::max_element(fit.after) - fit.after.begin());
    std::vector<double> others = fit.after;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(worst));
    if (fit.after[worst] < std::max(kMin, kTimes * medianOf(others)))
      return std::nullopt;
    return worst;
  }

  /// The frames with one camera's pictures of other times than its calibration says; without those
  /// of which there is none.
  /// @param numbers  gets those of the frames that are there
  Frames shifted(std::size_t camera, int by, std::vector<int>* numbers = nullptr) {
    const std::size_t position = *findCamera(capture_, frames_[0][camera].name);
    Frames frames;
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      auto view = reader_.neighbour(position, numbers_[f] + by);
      if (!view)
        continue;  // a later frame may do
      leaveOutOccluded(camera, *view);
      frames.push_back(frames_[f]);
      frames.back()[camera] = std::move(*view);
      if (numbers)
        numbers->push_back(numbers_[f]);
    }
    return frames;
  }

  /// Whether a camera's pictures of other times fit better in most of at least two frames: in one
  /// alone something else may be wrong with the picture.
  Result<bool> eachFrameAgrees(std::size_t camera, int by) {
    std::size_t better = 0, all = 0;
    for (const std::size_t f : someFrames()) {
      const std::size_t position = *findCamera(capture_, frames_[f][camera].name);
      auto view = reader_.neighbour(position, numbers_[f] + by);
      if (!view)
        continue;
      leaveOutOccluded(camera, *view);
      Frames one{frames_[f]};
      VOLUTE_ASSIGN(const auto before, fitOf(one, false));
      one[0][camera] = std::move(*view);
      VOLUTE_ASSIGN(const auto after, fitOf(one, false));
      ++all;
      better += after.after[camera] < before.after[camera];
    }
    return all >= 2 && 2 * better > all;
  }

  /// The best of the neighbouring times, further on while it gets better.
  Result<std::optional<CalibrationFit>> otherClock(std::size_t camera, const CalibrationFit& now) {
    constexpr int kFurthest = 4;
    constexpr double kClearly = 0.7;
    std::optional<CalibrationFit> best;
    int shift = 0;
    double least = now.after[camera];
    const auto attempt = [&](int by) -> Result<bool> {
      const Frames frames = shifted(camera, by);
      if (frames.empty())
        return false;
      VOLUTE_ASSIGN(auto fit, fitOf(frames, false));
      if (!(fit.after[camera] < least))
        return false;
      least = fit.after[camera];
      shift = by;
      best = std::move(fit);
      return true;
    };
    for (const int direction : {-1, 1}) {
      for (int by = direction; std::abs(by) <= kFurthest; by += direction) {
        VOLUTE_ASSIGN(const bool better, attempt(by));
        if (!better)
          break;
      }
    }
    if (!(least < kClearly * now.after[camera]) || !(mean(best->after) < mean(now.after)))
      return std::optional<CalibrationFit>();
    VOLUTE_ASSIGN(const bool agreed, eachFrameAgrees(camera, shift));
    if (!agreed)
      return std::optional<CalibrationFit>();
    std::vector<int> numbers;
    frames_ = shifted(camera, shift, &numbers);
    numbers_ = std::move(numbers);
    shifts_[camera] = shift;
    return best;
  }

  const Capture& capture_;
  ViewReader& reader_;
  std::uint64_t maxMemory_;
  Progress& progress_;
  Frames frames_;
  std::vector<int> numbers_, shifts_;
  std::vector<int> faulty_;  // numbers of frames in which single pictures have mistakes
  std::vector<Occlusion> occlusions_;
};

/// Of each view, the gain that was found where it is large; 1 where it is not, and where a response
/// was found with it.
std::vector<double> largeGains(const CalibrationFit& fit) {
  constexpr double kLarge = 0.15;
  std::vector<double> gains;
  for (const CameraCorrection& one : fit.corrections) {
    const bool large =
        std::abs(one.values[CameraCorrection::kGain]) > kLarge && one.exponent() == 1;
    gains.push_back(large ? one.gain() : 1);
  }
  return gains;
}

Result<CaptureRefinement> refined(const Capture& capture, const std::vector<std::string>& heldOut,
                                  Refine refine, std::uint64_t maxMemory, Progress& progress) {
  CaptureRefinement result;
  result.capture = capture;
  const auto leave = [&](std::string_view why) {
    if (refine == Refine::kAlways)
      progress.remark({RemarkCode::kDoubtful, fmt::format("calibration not refined: {}", why)});
    return result;
  };
  const bool flat = std::ranges::any_of(
      capture.cameras, [](const CaptureCamera& known) { return known.camera.isOrthographic(); });
  if (flat)
    return leave("orthographic cameras are taken as they are");
  VOLUTE_ASSIGN(auto reader, ViewReader::open(result.capture, heldOut, maxMemory, progress));
  progress.report("looking at the calibration", 0, 0);
  Refiner refiner(result.capture, reader, maxMemory, progress);
  VOLUTE_TRY(refiner.read());
  if (refiner.frames().empty())
    return leave("no frame that was looked at shows light in all cameras");
  const std::size_t views = refiner.frames()[0].size();
  if (views < kFewestViews)
    return leave(
        fmt::format("{} cameras do not determine it; at least {} do", views, kFewestViews));
  const auto failed = [&](const Error& error) -> Result<CaptureRefinement> {
    if (error.code == ErrorCode::kCancelled)
      return tl::unexpected<Error>(error);
    if (error.code == ErrorCode::kTooLarge && refine == Refine::kAuto)
      progress.remark(
          {RemarkCode::kDoubtful, fmt::format("calibration not refined: {}", error.message)});
    result.capture = capture;
    result.leftOut.clear();
    result.mended = false;
    return leave(error.message);
  };
  std::vector<std::string> seen;
  for (const TomographyView& view : refiner.frames()[0]) seen.push_back(view.name);
  std::vector<PictureFault> own;
  const auto faults = refiner.faults(own);
  if (!faults)
    return failed(faults.error());
  for (PictureFault& fault : own) {
    const bool leaves = refine != Refine::kNever && !fault.views.empty() &&
                        views >= kFewestViews + fault.views.size();
    for (const std::size_t v : fault.views) {
      auto& known = result.capture.cameras[*findCamera(capture, seen[v])];
      if (leaves)
        std::ranges::copy(fault.frames, std::back_inserter(known.pictures.leftOut));
    }
    result.pictureFaults.push_back(
        fault.text + (leaves ? "; left out there until they are mended"
                             : "; mend these pictures, or take them away: the camera then does not "
                               "count there"));
  }
  result.faultyFrames = refiner.faulty();
  std::vector<std::string> apart = heldOut;  // keep their calibration
  bool all = false;                          // whether a mistake is not of some cameras alone
  for (const CaptureFault& fault : *faults) {
    result.faults.push_back(fault.text);
    all = all || fault.cameras.empty();
    for (const std::size_t v : fault.cameras) {
      if (refinementMends(fault) || std::ranges::find(apart, seen[v]) != apart.end())
        continue;
      apart.push_back(seen[v]);
      result.leftOut.push_back(seen[v]);
    }
  }
  if (refine == Refine::kNever)
    return result;
  if (refiner.frames().empty())
    return leave("pictures have mistakes in each frame that was looked at");
  if (refine == Refine::kAuto && (all || views < kFewestViews + result.leftOut.size())) {
    result.leftOut.clear();
    return result;
  }
  if (refine == Refine::kAlways) {
    apart = heldOut;
    result.leftOut.clear();
  }
  if (!faults->empty() && !all) {
    // Far off it would not find them from where they are.
    for (const CaptureFault& fault : *faults) {
      if (!refinementMends(fault))
        continue;
      CaptureCamera& known = result.capture.cameras[*findCamera(capture, seen[fault.cameras[0]])];
      if (fault.byFrame)
        known.pictures.gainByFrame = true;
      else if (fault.kind == CaptureFault::Kind::kGain)
        known.pictures.gain *= fault.value;
      else if (fault.kind == CaptureFault::Kind::kBalance)
        known.pictures.channelGain *= fault.factors;
      else
        known.camera =
            corrected(known.camera, fault.kind == CaptureFault::Kind::kLens ? lensBy(fault.value)
                                                                            : zoomBy(fault.value))
                .value_or(known.camera);
      result.mended = true;
    }
    VOLUTE_ASSIGN(reader, ViewReader::open(result.capture, apart, maxMemory, progress));
    VOLUTE_TRY(refiner.read());
  }
  progress.report("refining the calibration", 0, 0);
  auto given = refiner.fit(false, true);
  if (!given)
    return failed(given.error());
  const auto before = given->before;
  // A gain far from 1 is held back by what is plausible: it is taken, and what it lacks is found.
  const std::vector<double> gains = largeGains(*given);
  const bool anyLarge = std::ranges::any_of(gains, [](double gain) { return gain != 1; });
  const auto applyGains = [&](double power) {
    for (std::size_t v = 0; v < gains.size(); ++v)
      result.capture.cameras[*findCamera(capture, refiner.frames()[0][v].name)].pictures.gain *=
          std::pow(gains[v], power);
  };
  if (anyLarge) {
    applyGains(1);
    VOLUTE_ASSIGN(reader, ViewReader::open(result.capture, apart, maxMemory, progress));
    VOLUTE_TRY(refiner.read());
    given = refiner.fit(false, true);
    if (!given)
      return failed(given.error());
  }
  const std::vector<int> unshifted = refiner.shifts();
  auto fit = refiner.withClocks(std::move(*given));
  if (!fit)
    return failed(fit.error());
  result.frames = refiner.numbers();
  result.shifts = refiner.shifts();
  for (const TomographyView& view : refiner.frames()[0]) result.names.push_back(view.name);
  result.before = mean(before);
  result.after = mean(fit->after);
  result.used = refine == Refine::kAlways || pays(result);
  if (result.used) {
    // Where they were given, cameras may have been too far off to tell.
    VOLUTE_TRY(refiner.findOccluded(&*fit));
    fit = refiner.fit(true, fit->lensOrResponse || refiner.shifts() != unshifted);
    if (!fit)
      return failed(fit.error());
  }
  result.fit = std::move(*fit);
  result.fit.before = before;
  if (!result.used) {
    applyGains(-1);
    return result;
  }
  for (std::size_t v = 0; v < result.names.size(); ++v) {
    CaptureCamera& camera = result.capture.cameras[*findCamera(capture, result.names[v])];
    result.moved.push_back(
        pixelsMoved(camera.camera, result.fit.cameras[v], capture.volume.bounds));
    camera.camera = result.fit.cameras[v];
    camera.reprojectionError = result.fit.sightError[v];
    const CameraCorrection correction = result.fit.corrections[v];
    PictureSource& pictures = camera.pictures;
    // pivot (light / pivot)^exponent, with light = white gain value^exponent.
    const double exponent = correction.exponent(), white = capture.white * pictures.lightGain();
    pictures.gain *= correction.gain() * std::pow(result.fit.pivot / white, 1 - exponent);
    pictures.exponent *= exponent;
    camera.pictures.frameShift += result.shifts[v];
    result.fit.corrections[v].values[CameraCorrection::kGain] += std::log(gains[v]);
  }
  return result;
}

}  // namespace

Result<CaptureRefinement> refineCapture(const Capture& capture,
                                        const std::vector<std::string>& heldOut, Refine refine,
                                        std::uint64_t maxMemory, Progress& progress) {
  VOLUTE_ASSIGN(auto result, refined(capture, heldOut, refine, maxMemory, progress));
  for (const auto* texts : {&result.faults, &result.pictureFaults})
    for (const std::string& text : *texts)
      progress.remark({RemarkCode::kDoubtful, "warning: " + text});
  if (!result.faults.empty() && result.mended)
    progress.remark("gains, focal lengths and lenses that were told are taken");
  if (!result.leftOut.empty())
    progress.remark(
        fmt::format("camera{} {}: not refined before that is mended; the others are where it helps",
                    result.leftOut.size() == 1 ? "" : "s", fmt::join(result.leftOut, ", ")));
  else if (!result.faults.empty() && !result.used && !result.mended)
    progress.remark("the calibration is not refined before that is mended");
  if (!result.used)
    return result;
  progress.remark(
      {RemarkCode::kChanged,
       fmt::format(
           "calibration refined with the volume on frame{} {}: {:.1f} % of the pictures are not "
           "explained, instead of {:.1f} % (relative L2, coarse voxels)",
           result.frames.size() == 1 ? "" : "s", fmt::join(result.frames, ", "), 100 * result.after,
           100 * result.before),
       {Hint::set("refine", "never").so("leaves it")}});
  for (const std::string& text : describeCorrections(result)) progress.remark(text);
  for (const std::string& text : outstandingCorrections(result))
    progress.remark({RemarkCode::kDoubtful, "warning: " + text});
  return result;
}

std::vector<std::string> describeCorrections(const CaptureRefinement& refinement) {
  std::vector<std::string> texts;
  for (std::size_t v = 0; v < refinement.names.size(); ++v) {
    const CameraCorrection& one = refinement.fit.corrections[v];
    texts.push_back(fmt::format(
        "{}: turned {:.2f} degrees, moved {:.1f} mm, focal length {:+.1f} %, principal point "
        "({:+.1f}, {:+.1f}) pixels, gain {:+.1f} %",
        refinement.names[v], one.turn().norm() * kDegrees, 1000 * one.shift().norm(),
        100 * (std::exp(one.values[CameraCorrection::kZoom]) - 1),
        one.values[CameraCorrection::kPrincipal], one.values[CameraCorrection::kPrincipal + 1],
        100 * (one.gain() - 1)));
    if (const double k1 = one.values[CameraCorrection::kLens]; k1 != 0)
      texts.back() += fmt::format(", lens k1 {:+.4f}", k1);
    if (one.exponent() != 1)
      texts.back() += fmt::format(", exponent {:.3f}", one.exponent());
  }
  return texts;
}

std::vector<std::string> outstandingCorrections(const CaptureRefinement& refinement) {
  constexpr double kTimes = 3, kPixels = 0.4, kGain = 0.05, kExponent = 0.05;
  std::vector<std::string> texts;
  std::vector<double> gains;
  for (const CameraCorrection& one : refinement.fit.corrections)
    gains.push_back(std::abs(one.values[CameraCorrection::kGain]));
  for (std::size_t v = 0; v < refinement.moved.size(); ++v) {
    const auto others = [&](std::vector<double> values) {
      values.erase(values.begin() + static_cast<std::ptrdiff_t>(v));
      return medianOf(std::move(values));
    };
    const double pixels = others(refinement.moved), gain = others(gains);
    if (const int shift = refinement.shifts[v]; shift != 0) {
      texts.push_back(fmt::format(
          "camera {}: its pictures of {} frame{} {} fit the others: its clock runs {}, and that "
          "was "
          "taken (\"frame_shift\": {})",
          refinement.names[v], std::abs(shift), std::abs(shift) == 1 ? "" : "s",
          shift > 0 ? "later" : "earlier", shift > 0 ? "late" : "early",
          refinement.capture.cameras[*findCamera(refinement.capture, refinement.names[v])]
              .pictures.frameShift));
    }
    if (refinement.moved[v] > std::max(kPixels, kTimes * pixels)) {
      texts.push_back(fmt::format(
          "camera {}: its calibration does not fit the others and was refined: it sees the volume "
          "{:.1f} pixels from where it was said, the others {:.1f} (median): was it moved, or its "
          "lens changed?",
          refinement.names[v], refinement.moved[v], pixels));
    }
    if (gains[v] > std::max(kGain, kTimes * gain)) {
      const double factor = refinement.fit.corrections[v].gain();
      texts.push_back(fmt::format(
          "camera {}: {:.0f} % too {}: its radiance times {:.3f} fits the others, and was taken",
          refinement.names[v], 100 * std::abs(1 / factor - 1), factor < 1 ? "bright" : "dark",
          factor));
    }
    const double exponent = refinement.fit.corrections[v].exponent();
    if (std::abs(exponent - 1) > kExponent) {
      texts.push_back(fmt::format(
          "camera {}: its linear values to the power of {:.2f} fit the others, and were taken "
          "(\"exponent\"): is its \"color\" right?",
          refinement.names[v], exponent));
    }
  }
  return texts;
}

nlohmann::ordered_json refinementJson(const CaptureRefinement& refinement) {
  std::vector<std::string> faults = refinement.faults;
  std::ranges::copy(refinement.pictureFaults, std::back_inserter(faults));
  if (refinement.frames.empty() && faults.empty())
    return {};
  auto cameras = nlohmann::ordered_json::array();
  for (std::size_t v = 0; v < refinement.names.size(); ++v) {
    const auto& one = refinement.fit.corrections[v].values;
    const auto& off = refinement.fit.uncertain[v].values;
    cameras.push_back(
        {{"name", refinement.names[v]},
         {"reprojection_error",
          refinement.used
              ? jsonNumber(
                    refinement.capture.cameras[*findCamera(refinement.capture, refinement.names[v])]
                        .reprojectionError)
              : Json()},
         {"pixels_moved", refinement.used ? jsonNumber(refinement.moved[v]) : Json()},
         {"residual_before", jsonNumber(refinement.fit.before[v])},
         {"residual_after", jsonNumber(refinement.fit.after[v])},
         {"frame_shift", refinement.shifts[v]},
         {"turn_degrees", {kDegrees * one[0], kDegrees * one[1], kDegrees * one[2]}},
         {"turn_uncertain", {kDegrees * off[0], kDegrees * off[1], kDegrees * off[2]}},
         {"shift", {one[3], one[4], one[5]}},
         {"shift_uncertain", {off[3], off[4], off[5]}},
         {"focal_factor", std::exp(one[CameraCorrection::kZoom])},
         {"focal_uncertain", off[CameraCorrection::kZoom]},
         {"principal_point", {one[7], one[8]}},
         {"principal_uncertain", {off[7], off[8]}},
         {"gain", std::exp(one[CameraCorrection::kGain])},
         {"gain_uncertain", off[CameraCorrection::kGain]},
         {"k1", one[CameraCorrection::kLens]},
         {"k1_uncertain", off[CameraCorrection::kLens]},
         {"exponent", std::exp(one[CameraCorrection::kExponent])},
         {"exponent_uncertain", off[CameraCorrection::kExponent]}});
  }
  return {{"used", refinement.used},
          {"frames", refinement.frames},
          {"residual_before", jsonNumber(refinement.before)},
          {"residual_after", jsonNumber(refinement.after)},
          {"faults", faults},
          {"cameras", cameras}};
}

}  // namespace volute
