// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

namespace volute {

/// A named line of a plot; values that are not finite leave a gap.
struct PlotLine {
  std::string name;
  std::vector<double> y;
  bool dashed = false;
};

/// An SVG with labelled axes, from 0 up, one line a series in the colours of viridis. `x` ascends
/// and has as many values as each line.
std::string linePlot(const std::string& title, const std::string& xLabel, const std::string& yLabel,
                     const std::vector<double>& x, const std::vector<PlotLine>& lines);

}  // namespace volute
