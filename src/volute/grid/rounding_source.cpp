// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/rounding_source.hpp"

namespace volute {

double roundingOf(const FrameSource& source) {
  const auto* rounds = dynamic_cast<const RoundingSource*>(&source);
  return rounds ? rounds->rounding() : 0;
}

}  // namespace volute
