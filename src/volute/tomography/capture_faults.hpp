// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/tomography/view.hpp"

namespace volute {

/// A mistake in a capture that is not a number a little off.
struct CaptureFault {
  enum class Kind {
    kMirrored,    ///< left and right
    kFlipped,     ///< above and below
    kUpsideDown,  ///< turned by half a turn
    kExchanged,   ///< two cameras' pictures, or calibrations
    kEncoded,     ///< stored as sRGB and taken as linear
    kDecoded,     ///< stored linearly and taken as sRGB
  };

  Kind kind = Kind::kMirrored;
  std::vector<std::size_t> cameras;  ///< positions among the views; empty: all of them
  double before = 0, after = 0;      ///< misfit of the views, as matchOf() has it, root mean square
  std::string text;                  ///< for people: what it is, the evidence, what to do
};

/// Where no coarse volume explains the pictures: tries each mistake by a fit of a coarse volume to
/// the pictures without it, and names those that explain it, one after the other. Nothing for
/// pictures that agree, for fewer than four views, and where nothing that is tried explains them.
/// Only cameras that stand out most are tried; exchanges need pictures of one size.
/// @param white  one a view: the radiance of a stored value of 1; empty where views do not hold
///   light: responses are then not tried.
[[nodiscard]] Result<std::vector<CaptureFault>> findCaptureFaults(std::vector<TomographyView> views,
                                                                  std::span<const double> white,
                                                                  const VolumeGeometry& geometry,
                                                                  Progress& progress);

}  // namespace volute
