// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/medium/conformance/support.hpp"

namespace volute::conformance {

std::vector<Check> checks() {
  std::vector<Check> all;
  for (const auto& group :
       {callChecks(), linearChecks(), depthChecks(), pieceChecks(), radianceChecks()}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

}  // namespace volute::conformance
