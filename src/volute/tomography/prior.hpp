// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/tomography/support.hpp"
#include "volute/wavelet/lifting.hpp"

namespace volute {

/// A prior: R(a) of min 1/2 |S a - p|^2 + R(a), and the constraint a >= 0. Vectors hold four floats
/// for each unknown.
class Prior {
 public:
  virtual ~Prior() = default;

  /// a = argmin 1/2 sum of |x_i - a_i|^2 / step[i] + R(x), x >= 0; R's smooth part left out.
  /// Approximate: it may keep what it found for the next call.
  /// @param step  one for each unknown.
  virtual void proximal(std::span<float> a, std::span<const float> step) = 0;

  /// Whether steps may differ between unknowns.
  virtual bool takesSteps() const { return true; }

  /// gradient += the gradient of R's smooth part.
  virtual void addGradient(std::span<const float> a, std::span<float> gradient) const {
    (void)a, (void)gradient;
  }

  /// The largest curvature of R's smooth part.
  virtual double curvature() const { return 0; }
};

/// No prior but a >= 0, if `nonNegative`.
std::unique_ptr<Prior> makeNoPrior(bool nonNegative);

/// A liking for few voxels that shine: each voxel pays strength * scale / (scale + a) for its
/// light, the less the brighter it is (reweighted l1, Candes, Wakin and Boyd 2008).
struct Sparsity {
  double strength = 0;
  double scale = 1;  ///< what counts as bright [radiance/m]
};

/// strength * sum over voxels of the singular values of the differences to the three next voxels, a
/// matrix of 3 axes by 3 channels (total nuclear variation, Rigie and La Riviere 2015): channels
/// whose differences point the same way cost less than those whose differences do not. Of grey
/// volumes this is sqrt(3) times a channel's total variation. Voxels outside the support count as
/// 0. Sparsity needs `nonNegative`.
std::unique_ptr<Prior> makeTotalVariation(std::shared_ptr<const Support> support, double strength,
                                          const Sparsity& sparsity, bool nonNegative);

/// strength / 2 * the squared differences of neighbours.
std::unique_ptr<Prior> makeSmoothness(std::shared_ptr<const Support> support, double strength,
                                      bool nonNegative);

/// strength * the length of each wavelet coefficient over the channels, at another shift of the
/// lattice for each call (cycle spinning, Coifman and Donoho 1995).
std::unique_ptr<Prior> makeWaveletSparsity(std::shared_ptr<const Support> support, Wavelet wavelet,
                                           double strength, bool nonNegative, std::uint32_t seed);

}  // namespace volute
