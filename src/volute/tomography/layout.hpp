// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/base/progress.hpp"
#include "volute/capture/capture.hpp"
#include "volute/tomography/diagnostics.hpp"

namespace volute {

/// How the cameras of a capture stand around its volume.
struct CameraLayout {
  std::vector<std::string> names;  ///< of the cameras
  std::vector<SightAngle> angles;  ///< of all pairs

  explicit CameraLayout(const Capture& capture);

  /// "c0-c4 10, c1-c5 12": the `most` narrowest pairs, the narrowest first [degrees].
  std::string narrowest(std::size_t most) const;

  /// See layoutAdvice().
  std::optional<Remark> advice() const { return layoutAdvice(names, angles); }

  /// Remarks on the narrowest angles, or on all, and on the advice.
  void remark(bool all, Progress& progress) const;
};

}  // namespace volute
