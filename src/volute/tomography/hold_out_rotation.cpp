// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/hold_out_rotation.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/report/json.hpp"
#include "volute/tomography/layout.hpp"

namespace volute {

/// All but one camera.
struct HoldOutRotation::Run {
  CaptureRefinement refinement;
  ReconstructionSettings settings;
  std::unique_ptr<Progress> progress;
  std::unique_ptr<ReconstructedFrames> frames;
};

namespace {

/// Says which camera is left out; remarks of each run would come once a camera.
class RotationProgress final : public Progress {
 public:
  RotationProgress(Progress& whole, const std::string& camera, std::size_t run, std::size_t runs)
      : whole_(whole), camera_(camera), run_(run), runs_(runs) {}

  void report(std::string_view stage, double done, double total) override {
    whole_.detail(fmt::format("without {}, {}", camera_, stage));
    const double share = total > 0 ? std::clamp(done / total, 0.0, 1.0) : 0;
    whole_.report("leaving out cameras", static_cast<double>(run_) + share,
                  static_cast<double>(runs_));
  }

  bool cancelled() const override { return whole_.cancelled(); }

 private:
  Progress& whole_;
  std::string camera_;
  std::size_t run_, runs_;
};

/// The mean of a camera's figure over the frames.
Result<double> meanOfFrames(const ReconstructedFrames& frames, std::size_t camera,
                            const char* figure) {
  double sum = 0;
  int count = 0;
  for (int i = 0; i < frames.info().frames; ++i) {
    VOLUTE_ASSIGN(const auto record, frames.record(i));
    const auto& value = record["cameras"][camera][figure];
    if (!value.is_number())
      continue;
    sum += value.get<double>();
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

double medianAmong(std::vector<double> values) {
  std::ranges::sort(values);
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

}  // namespace

HoldOutRotation::~HoldOutRotation() {
  for (const auto& run : runs_) {
    if (run->frames)
      run->frames->work().remove();
  }
}

Result<std::unique_ptr<HoldOutRotation>> HoldOutRotation::run(
    const Capture& capture, const ReconstructionSettings& settings, Refine refine,
    const std::filesystem::path& output, std::uint64_t maxMemory, Progress& progress) {
  constexpr std::size_t kFewestLeft = 3;
  const std::size_t n = capture.cameras.size();
  if (n <= kFewestLeft)
    return failFor("hold_out", ErrorCode::kInvalidArgument,
                   "auto leaves out one camera of {}, which leaves too few to reconstruct "
                   "from; expected at least {} cameras",
                   n, kFewestLeft + 1);
  std::unique_ptr<HoldOutRotation> rotation(new HoldOutRotation);
  for (std::size_t v = 0; v < n; ++v) {
    const std::string& name = capture.cameras[v].name;
    auto& run = *rotation->runs_.emplace_back(std::make_unique<Run>());
    run.progress = std::make_unique<RotationProgress>(progress, name, v, n);
    Progress& own = *run.progress;
    run.settings = settings;
    run.settings.errorBars = false;
    run.settings.causeNamed = true;  // the run with all cameras tells what is wrong
    VOLUTE_ASSIGN(run.refinement, refineCapture(capture, {name}, refine, maxMemory, own));
    const Capture& refined = run.refinement.capture;
    VOLUTE_ASSIGN(run.frames,
                  ReconstructedFrames::open(refined, run.settings, {name},
                                            output.string() + fmt::format(".without{}", v), own));
    VOLUTE_TRY(run.frames->solveAll());
    LeftOutCamera camera{name, 0, 0};
    VOLUTE_ASSIGN(camera.psnr, meanOfFrames(*run.frames, v, "psnr"));
    VOLUTE_ASSIGN(camera.residual, meanOfFrames(*run.frames, v, "residual"));
    rotation->cameras_.push_back(camera);
  }
  return rotation;
}

double HoldOutRotation::psnr() const {
  double sum = 0;
  for (const LeftOutCamera& camera : cameras_) sum += camera.psnr;
  return sum / static_cast<double>(cameras_.size());
}

void HoldOutRotation::addTo(nlohmann::ordered_json& json, const Capture& capture) const {
  const double fitted = json["residual"].is_number() ? json["residual"].get<double>() : 0;
  json["held_out_psnr"] = jsonNumber(psnr());
  json["held_out_in_turn"] = this->json();
  json["verdict"] = captureVerdict(capture, cameras_, fitted);
}

nlohmann::ordered_json HoldOutRotation::json() const {
  auto json = nlohmann::ordered_json::array();
  for (const LeftOutCamera& camera : cameras_)
    json.push_back({{"name", camera.name},
                    {"psnr", jsonNumber(camera.psnr)},
                    {"residual", jsonNumber(camera.residual)}});
  return json;
}

std::string captureVerdict(const Capture& capture, std::span<const LeftOutCamera> cameras,
                           double fitted) {
  constexpr double kMuchWorse = 3;    // [dB] below the median
  constexpr double kFewViews = 2;     // times what is left of the fitted pictures
  constexpr double kDisagree = 0.05;  // left of the fitted pictures
  const auto worst = std::ranges::min_element(cameras, {}, &LeftOutCamera::psnr);
  std::vector<double> psnrs, residuals;
  for (const LeftOutCamera& camera : cameras) {
    psnrs.push_back(camera.psnr);
    residuals.push_back(camera.residual);
  }
  // The camera that is furthest from its nearest neighbour, in angle modulo 180 degrees.
  const CameraLayout layout(capture);
  std::vector<double> nearest(cameras.size(), 90);
  for (const SightAngle& pair : layout.angles) {
    nearest[pair.a] = std::min(nearest[pair.a], pair.degrees);
    nearest[pair.b] = std::min(nearest[pair.b], pair.degrees);
  }
  const auto lonely = static_cast<std::size_t>(std::ranges::max_element(nearest) - nearest.begin());
  const double left = medianAmong(residuals);
  const std::string head = fmt::format(
      "a new view comes out with {:.1f} dB (cameras left out in turn, median; worst {} "
      "with {:.1f})",
      medianAmong(psnrs), worst->name, worst->psnr);
  if (worst->psnr < medianAmong(psnrs) - kMuchWorse)
    return fmt::format(
        "{}; check camera {}'s calibration and exposure, or put another camera "
        "beside it",
        head, worst->name);
  if (fitted > kDisagree && left < kFewViews * fitted)
    return fmt::format(
        "{}; the cameras disagree ({:.0f} % of the fitted pictures is left): a better "
        "calibration, or light that shines alike in all directions, would help more "
        "than another camera",
        head, 100 * fitted);
  return fmt::format(
      "{}; there are few views ({:.0f} % of a new one is left, {:.0f} % of the fitted "
      "ones): another camera would help, furthest from others is {} ({:.0f} degrees)",
      head, 100 * left, 100 * fitted, layout.names[lonely], nearest[lonely]);
}

}  // namespace volute
