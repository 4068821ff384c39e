// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

namespace volute {

/// How much of the light at both ends of a stretch of smoke comes out at its near end.
struct SegmentWeights {
  double w0 = 0;             ///< of E at the near end
  double w1 = 0;             ///< of E at the far end
  double transmittance = 1;  ///< 1 - w0 - w1; Staubli et al. 2005, after equation 9, print + w1
};

/// Staubli et al. 2005, equations 6 and 7, with E and tau linear over a length L: the weights
/// depend on d0 = tau0 L and d1 = tau1 L alone, both >= 0. Double, by quadrature where there is no
/// closed form; errors below 1e-12.
SegmentWeights segmentWeights(double d0, double d1);

}  // namespace volute
