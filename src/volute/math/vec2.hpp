// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <Eigen/Core>

namespace volute {

/// A point of a plane: of an image [pixels], or of a floor [m].
using Vec2 = Eigen::Vector2d;

}  // namespace volute
