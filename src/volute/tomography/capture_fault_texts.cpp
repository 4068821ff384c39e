// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "volute/tomography/capture_faults.hpp"
#include "volute/tomography/fault_level.hpp"

namespace volute {
namespace {

using FaultKind = CaptureFault::Kind;
using Views = std::vector<TomographyView>;

std::string orderText(double value) {
  constexpr std::array<const char*, 6> kTexts{"",
                                              "red and blue exchanged (BGR)",
                                              "red and green exchanged",
                                              "green and blue exchanged",
                                              "stored as blue, red, green",
                                              "stored as green, blue, red"};
  return kTexts[static_cast<std::size_t>(value)];
}

std::string factorsText(const Rgb& factors) {
  return fmt::format("{:.3g}, {:.3g}, {:.3g}", factors[0], factors[1], factors[2]);
}

/// Whose calibrations the pictures fit.
std::string othersText(int order, const Views& views) {
  constexpr std::size_t kMax = 3;
  const auto whose = cameraOrder(order, views.size());
  std::vector<std::string> texts;
  for (std::size_t v = 0; v < views.size() && texts.size() < kMax; ++v) {
    if (whose[v] != v)
      texts.push_back(fmt::format("{}'s pictures fit the calibration of {}", views[v].name,
                                  views[whose[v]].name));
  }
  return fmt::format("{} and so on", fmt::join(texts, ", "));
}

std::string namesOf(const CaptureFault& fault, const Views& views) {
  std::vector<std::string> names;
  for (const std::size_t v : fault.cameras) names.push_back(views[v].name);
  return names.empty() ? std::string("all cameras")
                       : fmt::format("camera {}", fmt::join(names, ", "));
}

}  // namespace

std::string describeFault(const CaptureFault& fault, const Views& views, double pixelCentre) {
  std::vector<std::string> names;
  for (const std::size_t v : fault.cameras) names.push_back(views[v].name);
  const std::string who = namesOf(fault, views);
  const auto evidence = fmt::format("(what is left of the pictures: {:.0f} % instead of {:.0f} %)",
                                    100 * fault.after, 100 * fault.before);
  switch (fault.kind) {
    case FaultKind::kMirrored:
      return fmt::format(
          "{}: mirrored: left and right exchanged, the pictures fit {}; mirror them "
          "back",
          who, evidence);
    case FaultKind::kFlipped:
      return fmt::format(
          "{}: flipped: above and below exchanged, the pictures fit {}; set "
          "\"bottom_up\": true, or check the rows of R, for y is down",
          who, evidence);
    case FaultKind::kUpsideDown:
      return fmt::format(
          "{}: upside down: turned by half a turn, the pictures fit {}; turn them, "
          "or the calibration",
          who, evidence);
    case FaultKind::kTurnedLeft:
    case FaultKind::kTurnedRight:
      return fmt::format(
          "{}: turned by a quarter turn to the {}, the pictures fit {}; turn them back, or the "
          "calibration",
          who, fault.kind == FaultKind::kTurnedLeft ? "left" : "right", evidence);
    case FaultKind::kExchanged:
      return fmt::format(
          "cameras {} and {}: exchanged: each fits as the other {}; exchange their "
          "pictures, or their calibrations",
          names[0], names[1], evidence);
    case FaultKind::kOrder:
      return fmt::format(
          "all cameras: in another order: {} {}; are the pictures, or the calibrations, sorted by "
          "other names?",
          othersText(static_cast<int>(fault.value), views), evidence);
    case FaultKind::kEncoded:
      return fmt::format(
          "{}: the pictures are stored as sRGB and taken as linear {}; set \"color\": "
          "\"srgb\"",
          who, evidence);
    case FaultKind::kDecoded:
      return fmt::format(
          "{}: the pictures are stored linearly and taken as sRGB {}; set \"color\": "
          "\"linear\"",
          who, evidence);
    case FaultKind::kExponent:
      return fmt::format(
          "{}: the light is stored by another curve: to the power of about {:.2f} it fits {}; set "
          "\"color\" to that of the camera, or \"exponent\"",
          who, fault.value, evidence);
    case FaultKind::kGain:
      return fmt::format(
          "{}: {:.0f} % too {}: its radiance times {:.3g} fits the others {}; set its \"gain\"",
          who, 100 * std::abs(1 / fault.value - 1), fault.value < 1 ? "bright" : "dark",
          fault.value, evidence);
    case FaultKind::kZoom:
      return fmt::format(
          "{}: another focal length, about {:.3g} times as long, fits {}; calibrate with the lens "
          "and the size of these pictures",
          who, fault.value, evidence);
    case FaultKind::kLens:
      return fmt::format(
          "{}: a lens that its calibration does not have: with k1 {:+.2g} more it fits {}; "
          "calibrate the lens",
          who, fault.value, evidence);
    case FaultKind::kShift: {
      const bool right = fault.value > 0;
      const double centre = right ? 0 : 0.5;
      return fmt::format(
          "{}: one volume fits the pictures where principal points are half a pixel further to the "
          "{}, least at {:+.2f} pixels {}: {}",
          who, right ? "right and down" : "left and up", fault.value, evidence,
          centre != pixelCentre
              ? fmt::format("is the centre of the first pixel at {}, not at {}?", centre,
                            pixelCentre)
              : "was the calibration made with other pictures, or are they cropped?");
    }
    case FaultKind::kChannels:
      return fmt::format("{}: {}, against the others: put in order its pictures fit {}", who,
                         orderText(fault.value), evidence);
    case FaultKind::kBalance:
      return fmt::format(
          "{}: white balance: red, green and blue times {} fit the others {}; set its \"gain\" to "
          "these three",
          who, factorsText(fault.factors), evidence);
    case FaultKind::kBox:
      if (fault.value < 0.1)
        return fmt::format(
            "the volume's bounds seem to cut what the cameras see: bounds half as large again on "
            "each side explain the pictures {}; enlarge them",
            evidence);
      return fmt::format(
          "the volume's bounds cut what the cameras see: up to {:.0f} % of a camera's light lies "
          "outside, and bounds half as large again on each side explain the pictures {}; enlarge "
          "them",
          100 * fault.value, evidence);
  }
  return {};
}

std::string describeGains(const std::string& camera, std::span<const int> frames,
                          std::span<const double> gains) {
  constexpr double kOff = 1.1;
  std::vector<double> sorted(gains.begin(), gains.end());
  std::ranges::sort(sorted);
  const double usual = sorted[sorted.size() / 2];
  std::vector<std::string> off, all;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    all.push_back(fmt::format("{:.3g} in frame {}", gains[f], frames[f]));
    if (gains[f] > kOff * usual || gains[f] < usual / kOff)
      off.push_back(all.back());
  }
  const bool few = 3 * off.size() <= frames.size();
  return fmt::format(
      "camera {}: not as bright in all frames: its radiance times {}{} fits the others (auto "
      "exposure?); set its \"gain_by_frame\"",
      camera, fmt::join(few ? off : all, ", "), few ? fmt::format(" and {:.3g} else", usual) : "");
}

std::string describeInFrames(const CaptureFault& fault, const std::vector<TomographyView>& views,
                             std::span<const int> frames) {
  const auto what = [&]() -> std::string {
    switch (fault.kind) {
      case FaultKind::kMirrored:
        return "mirrored";
      case FaultKind::kFlipped:
        return "flipped";
      case FaultKind::kUpsideDown:
        return "upside down";
      case FaultKind::kTurnedLeft:
        return "turned to the left by a quarter turn";
      case FaultKind::kTurnedRight:
        return "turned to the right by a quarter turn";
      case FaultKind::kExchanged:
        return "exchanged";
      case FaultKind::kGain:
        return fmt::format("{:.0f} % too {}: its radiance times {:.3g} fits the others",
                           100 * std::abs(1 / fault.value - 1), fault.value < 1 ? "bright" : "dark",
                           fault.value);
      case FaultKind::kChannels:
        return orderText(fault.value);
      case FaultKind::kBalance:
        return fmt::format("white balance: red, green and blue times {} fit the others",
                           factorsText(fault.factors));
      default:
        return "does not fit the others";
    }
  };
  return fmt::format(
      "{}, frame{} {} alone: {} (what is left of the pictures: {:.0f} % instead of {:.0f} %)",
      namesOf(fault, views), frames.size() == 1 ? "" : "s", fmt::join(frames, ", "), what(),
      100 * fault.after, 100 * fault.before);
}

}  // namespace volute
