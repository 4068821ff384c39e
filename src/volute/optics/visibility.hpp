// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// How far one sees in smoke of extinction K [1/m]: S = C / K. An empirical rule, not physics: C
/// holds for the signs and the illumination of the experiments behind it.
struct VisibilityLaw {
  std::string name;
  double c = 3;                  ///< the optical depth at which a thing is no longer seen, > 0
  std::string_view source = {};  ///< where C comes from; empty for a custom one
  bool checked = true;           ///< the source was read, not quoted from memory
};

/// A least distance of sight that a way of escape is asked to keep, about smoke where the eye is:
/// S = C / K there. Rules differ by country and by building: each has its source.
struct SightLimit {
  std::string_view name;
  double distance = 0;   ///< [m]
  std::string_view law;  ///< of visibilityLaws(), for S
  std::string_view source;
  bool checked = false;  ///< the source was read, not quoted from memory
};

std::span<const SightLimit> sightLimits();

/// Their names.
std::vector<std::string_view> sightLimitNames();

/// One of sightLimits(). An error lists them.
[[nodiscard]] Result<SightLimit> sightLimit(std::string_view name);

/// What a rule's limit is, where it comes from, and whether that was looked up.
/// @param extinction  where one stands [1/m]
std::string limitRemark(const std::string& name, double extinction);

/// jin-reflecting 3, jin-emitting 8 (Jin's experiments: reflecting and light-emitting signs),
/// reciprocal-od ln 10 (S = 1/D, 10 % of the light left: Staubli et al. 2005, section 3).
std::span<const VisibilityLaw> visibilityLaws();

/// One of visibilityLaws(), or a number C > 0, whose law is called "custom".
[[nodiscard]] Result<VisibilityLaw> visibilityLaw(std::string_view nameOrC);

/// [m]; infinite in clear air.
double visibilityDistance(double extinction, const VisibilityLaw& law);

/// What a picture's transmittance means. One picture has one mode.
enum class PictureMode {
  kPhotometric,  ///< e^-depth: the share of light that passes
  kThreshold,  ///< 10^(-depth / C): what has faded to 10 % is what the law calls no longer visible
};

std::string_view nameOf(PictureMode mode);
[[nodiscard]] Result<PictureMode> pictureMode(std::string_view name);

/// What everything in one picture is seen through, signs apart, which have a C of their own.
struct PictureLaw {
  PictureMode mode = PictureMode::kPhotometric;
  double c = 3;  ///< of threshold mode

  /// The picture's transmittance is e^(-factor depth): 1, or ln 10 / C.
  double factor() const;
  bool operator==(const PictureLaw&) const = default;
};

/// The share of light that passes an optical depth (natural logarithm).
double photometricTransmittance(double depth);

/// 10^(-depth / C): Staubli et al. 2005, equation 2, whose "optical density" is K / 3 (C = 3).
double thresholdTransmittance(double depth, double c);

/// Through what a surface or a sign is seen: in threshold mode each thing has its own C (3, or 8
/// for one that emits light), in photometric mode none has. From a threshold transmittance T of C =
/// 3 this is T^(3/8) for an emitting sign (Staubli et al. 2005, section 4.4); applied to e^-depth
/// that power would be wrong.
double seenTransmittance(double depth, PictureMode mode, double c);

}  // namespace volute
