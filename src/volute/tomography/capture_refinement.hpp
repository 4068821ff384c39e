// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "volute/capture/capture.hpp"
#include "volute/tomography/calibration_fit.hpp"

namespace volute {

/// When a calibration is refined with the volume.
enum class Refine {
  kAuto,  ///< where the cameras disagree, and agree much better for it
  kNever,
  kAlways,
};

/// A capture's calibration as refined.
struct CaptureRefinement {
  bool used = false;        ///< whether `capture` has the corrections
  bool mended = false;      ///< whether it has the gains and focal lengths that are among `faults`
  Capture capture;          ///< held-out cameras as they were
  std::vector<int> frames;  ///< that were looked at
  std::vector<std::string> names;  ///< of the refined cameras
  CalibrationFit fit;              ///< one of `names` each
  double before = 0, after = 0;    ///< relative L2, the mean over the cameras
  /// For each of `names`, how many frames later its pictures are taken from: its clock runs late by
  /// so many.
  std::vector<int> shifts;
  std::vector<std::string> faults;  ///< mistakes that were found: sentences for people
  /// Mistakes of single pictures of the frames that were looked at: sentences, and these frames,
  /// which tell nothing of calibrations.
  std::vector<std::string> pictureFaults;
  std::vector<int> faultyFrames;
  std::vector<std::string> leftOut;  ///< cameras that keep their calibration, for what is wrong
                                     ///< with them is no number a little off

  /// Whether it is said why cameras do not fit.
  bool namesCause() const { return !leftOut.empty() || (!faults.empty() && !used && !mended); }

  std::vector<double> moved;  ///< for each of `names`, how far what it sees of the volume moved in
                              ///< its picture, root mean square [pixels]
};

/// Looks at up to eight frames, spread over the film. First for mistakes, see findCaptureFaults(),
/// in one of them, and whether the others have them: what is in few frames alone is told with these
/// and not taken for the others. Gains and focal lengths of some cameras are taken; cameras with
/// others keep their calibration, and all do where a mistake is of all, or fewer than four are
/// left. Then refines it, and, where a camera is left that does not fit, its clock by whole frames.
/// Orthographic cameras, fewer than four cameras, and frames without light are left as they are,
/// with the reason as a remark if `refine` is kAlways. Pixels in which something dark stands in
/// front of one camera, see findOcclusions(), do not count. What was found and corrected is
/// remarked on.
[[nodiscard]] Result<CaptureRefinement> refineCapture(const Capture& capture,
                                                      const std::vector<std::string>& heldOut,
                                                      Refine refine, std::uint64_t maxMemory,
                                                      Progress& progress);

/// "cam1: turned 0.12 degrees, moved 6.3 mm, focal length -3.8 %, gain -2.6 %", one a camera.
std::vector<std::string> describeCorrections(const CaptureRefinement& refinement);

/// A sentence on each camera whose calibration was off by much more than the others'.
std::vector<std::string> outstandingCorrections(const CaptureRefinement& refinement);

/// For the report; null where nothing was looked at.
nlohmann::ordered_json refinementJson(const CaptureRefinement& refinement);

}  // namespace volute
