// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/residual.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/tomography/hull.hpp"
#include "volute/tomography/project.hpp"

namespace volute {

ViewResidual residualOf(const TomographyView& view, const Image& inColour,
                        std::optional<double> noiseSigma) {
  const Image projected = asSeenBy(view, inColour);
  const auto& given = view.radiance.pixels;
  VOLUTE_ASSERT(given.size() == projected.pixels.size());
  const auto lit = dilatedSilhouette(view, noiseSigma);
  double error = 0, shown = 0, norm = 0, low = std::numeric_limits<double>::infinity(), high = -low;
  std::size_t count = 0;
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (!view.weight.empty() && view.weight[i / 3] == 0)
      continue;
    const double value = given[i], off = projected.pixels[i] - value;
    error += off * off;
    if (lit[i / 3] != 0 || projected.pixels[i] != 0) {
      shown += off * off;
      norm += value * value;
    }
    low = std::min(low, value);
    high = std::max(high, value);
    ++count;
  }
  ViewResidual residual;
  residual.relative = norm > 0 ? std::sqrt(shown / norm) : 0;
  const double rms = std::sqrt(error / static_cast<double>(std::max<std::size_t>(1, count)));
  residual.psnr =
      rms > 0 ? 20 * std::log10((high - low) / rms) : std::numeric_limits<double>::infinity();
  return residual;
}

}  // namespace volute
