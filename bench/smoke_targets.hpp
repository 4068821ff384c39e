// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "bench/benchmark.hpp"
#include "bench/smoke_drawers.hpp"

namespace volute::bench {

/// What is asked of Volute's pictures of smoke, and the worst that a run has found: the last rows
/// of its table.
class SmokeTargets {
 public:
  /// A picture took so much less time than VTK's projected tetrahedra.
  void addRatio(SmokeRole role, const SmokeMode& mode, const SmokeSetting& setting, double ratio);

  /// The largest error of a picture's opacity, or of its lit colour.
  void addError(SmokeRole role, const SmokeSetting& setting, double error);

  /// Of what reaches vertices of a lamp's light.
  void addLight(double error, const std::string& where);

  void addSeconds(SmokeRole role, const SmokeSetting& setting, double seconds);

  void report(BenchRows& rows) const;

 private:
  struct Target {
    std::string what, unit;
    double asked = 0;
    bool atLeast = true;
    double found = 0;
    std::string where;  // empty: nothing was found
  };

  void add(const std::string& what, const char* unit, double asked, bool atLeast, double found,
           const std::string& where);

  std::vector<Target> targets_;
};

}  // namespace volute::bench
