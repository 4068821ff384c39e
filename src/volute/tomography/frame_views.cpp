// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/frame_views.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "volute/tomography/capture_faults.hpp"

namespace volute {

namespace {

enum class Colours { kUnknown, kNone, kSome };

/// What the three channels of a picture that has them show. Some pixels may be white, or dark.
Colours coloursOf(const TomographyView& view) {
  constexpr std::size_t kFewest = 16;
  std::size_t grey = 0;
  const std::span<const float> light = view.radiance.pixels;
  for (std::size_t i = 0; i + 2 < light.size(); i += 3) {
    if (!view.counts(i / 3) || view.isSaturated(i / 3))
      continue;
    if (light[i] != light[i + 1] || light[i] != light[i + 2])
      return Colours::kSome;
    grey += light[i] != 0 ? 1 : 0;
  }
  return grey < kFewest ? Colours::kUnknown : Colours::kNone;
}

constexpr std::size_t kFewestSteady = 2;  // cameras that tell the gains of others

Status checkGainsByFrame(const Capture& capture, const std::vector<char>& heldOut) {
  std::size_t steady = 0;
  std::string first;
  for (std::size_t v = 0; v < capture.cameras.size(); ++v) {
    const CaptureCamera& known = capture.cameras[v];
    if (known.pictures.gainByFrame && first.empty())
      first = known.name;
    steady += !known.pictures.gainByFrame && heldOut[v] == 0 ? 1 : 0;
  }
  if (first.empty())
    return {};
  if (capture.measured == Measured::kAbsorption)
    return fail(ErrorCode::kInvalidArgument,
                "camera {}: \"gain_by_frame\" is for emission, and absorption is measured", first);
  if (steady < kFewestSteady)
    return fail(ErrorCode::kInvalidArgument,
                "camera {}: \"gain_by_frame\": of the fitted cameras {} have none, which tell its "
                "gain; expected {} or more",
                first, steady, kFewestSteady);
  return {};
}

}  // namespace

std::vector<TomographyView> FrameViews::fittedWithout(std::size_t view) const {
  std::vector<TomographyView> others;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!heldOut[i] && i != view)
      others.push_back(views[i]);
  }
  return others;
}

bool FrameViews::grey() const {
  return std::ranges::all_of(facts,
                             [](const PictureFacts& fact) { return fact.grey || fact.missing; });
}

Result<ViewReader> ViewReader::open(const Capture& capture, const std::vector<std::string>& heldOut,
                                    std::uint64_t maxMemory, Progress& progress) {
  std::vector<char> marks(capture.cameras.size(), 0);
  for (const std::string& name : heldOut) {
    const auto camera = findCamera(capture, name);
    if (!camera) {
      std::vector<std::string> names;
      for (const CaptureCamera& known : capture.cameras) names.push_back(known.name);
      return failFor("hold_out", ErrorCode::kInvalidArgument,
                     "there is no camera '{}'; the capture has {}", name, fmt::join(names, ", "));
    }
    marks[*camera] = 1;
  }
  VOLUTE_TRY(checkGainsByFrame(capture, marks));
  VOLUTE_ASSIGN(auto images, CaptureImages::open(capture, maxMemory, progress));
  return ViewReader(capture, std::move(images), std::move(marks));
}

TomographyView ViewReader::viewOf(std::size_t camera, CameraPicture picture) const {
  const bool allCount = std::ranges::all_of(picture.weight, [](float w) { return w == 1; });
  const bool bounds = std::ranges::any_of(picture.atLeast, [](std::uint8_t b) { return b != 0; });
  const CaptureCamera& known = capture_->cameras[camera];
  return {known.name,
          known.camera,
          std::move(picture.radiance),
          allCount ? std::vector<float>{} : std::move(picture.weight),
          bounds ? std::move(picture.atLeast) : std::vector<std::uint8_t>{},
          capture_->measured == Measured::kAbsorption,
          {},
          known.reprojectionError,
          keepsBackgrounds_ ? std::move(picture.background) : Image{}};
}

Result<FrameViews> ViewReader::read(int frame) {
  FrameViews result;
  result.frame = frame;
  result.heldOut = heldOut_;
  result.opticalDepth = capture_->measured == Measured::kAbsorption;
  std::optional<Error> first;
  for (std::size_t camera = 0; camera < capture_->cameras.size(); ++camera) {
    const CaptureCamera& known = capture_->cameras[camera];
    const auto& leftOut = known.pictures.leftOut;
    const bool isLeftOut = std::ranges::find(leftOut, frame) != leftOut.end();
    auto picture = isLeftOut
                       ? fail(ErrorCode::kNotFound, "{}: frame {} is left out", known.name, frame)
                       : images_.read(camera, frame);
    PictureFacts facts;
    const bool mayBeMissing =
        known.pictures.frameShift != 0 || known.pictures.video.empty() || isLeftOut;
    if (!picture && picture.error().code == ErrorCode::kNotFound && mayBeMissing) {
      // The others tell what they saw; this one has seen nothing, not even darkness.
      if (!first)
        first = picture.error();
      picture.emplace();
      picture->radiance = Image(known.camera.width(), known.camera.height());
      picture->weight.assign(picture->radiance.pixels.size() / 3, 0);
      picture->atLeast.assign(picture->weight.size(), 0);
      facts.missing = true;
      facts.maskedShare = 1;
    } else if (!picture) {
      return tl::unexpected<Error>(picture.error());
    } else {
      facts = {picture->brightest,
               picture->saturatedShare,
               picture->maskedShare,
               picture->transparentShare,
               picture->opaqueShare,
               picture->grey,
               false,
               picture->drift,
               picture->mosaic,
               picture->plateau,
               picture->bitsHolding,
               picture->storedPedestal,
               picture->largest,
               picture->litBackgroundSaturated,
               picture->transparentMask,
               picture->channelLimits,
               1,
               picture->counts,
               picture->dividedIntegers,
               picture->levelLeft};
    }
    result.facts.push_back(facts);
    result.views.push_back(viewOf(camera, std::move(*picture)));
  }
  if (first && std::ranges::all_of(result.facts, &PictureFacts::missing))
    return tl::unexpected<Error>(*first);
  // Of cameras that all are grey the channels are one.
  const bool allGrey = result.grey();
  std::vector<Colours> colours;
  for (std::size_t i = 0; i < result.views.size(); ++i)
    colours.push_back(result.facts[i].grey ? Colours::kUnknown : coloursOf(result.views[i]));
  const bool anyColour = std::ranges::find(colours, Colours::kSome) != colours.end();
  for (std::size_t i = 0; i < result.views.size(); ++i) {
    const bool storedInColour = anyColour && colours[i] == Colours::kNone;
    greyAmongColours_[i] = storedInColour || (!allGrey && result.facts[i].grey) ? 1 : 0;
    result.views[i].grey = greyAmongColours_[i] != 0;
  }
  VOLUTE_TRY(findGains(result));
  if (std::ranges::find(heldOut_, 1) != heldOut_.end())
    result.chosen = result.fittedWithout(result.views.size());
  return result;
}

Status ViewReader::findGains(FrameViews& frame) const {
  const auto isByFrame = [&](std::size_t v) {
    return capture_->cameras[v].pictures.gainByFrame && !frame.opticalDepth &&
           !frame.facts[v].missing;
  };
  std::vector<TomographyView> others;
  for (std::size_t v = 0; v < frame.views.size(); ++v) {
    if (!isByFrame(v) && heldOut_[v] == 0 && !frame.facts[v].missing)
      others.push_back(frame.views[v]);
  }
  for (std::size_t v = 0; v < frame.views.size(); ++v) {
    if (!isByFrame(v))
      continue;
    frame.facts[v].gainUntold = others.size() < kFewestSteady;
    if (frame.facts[v].gainUntold)
      continue;
    const VolumeGeometry geometry{capture_->volume.bounds, capture_->volume.resolution};
    VOLUTE_ASSIGN(const double gain, gainByOthers(frame.views[v], others, geometry, Progress()));
    for (float& light : frame.views[v].radiance.pixels) light *= static_cast<float>(gain);
    frame.facts[v].gain = gain;
    frame.facts[v].brightest *= gain;
  }
  return {};
}

std::optional<TomographyView> ViewReader::neighbour(std::size_t camera, int frame) {
  auto picture = images_.read(camera, frame);
  if (!picture)
    return std::nullopt;
  TomographyView view = viewOf(camera, std::move(*picture));
  view.grey = greyAmongColours_[camera] != 0;
  return view;
}

}  // namespace volute
