// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>

#include "volute/base/result.hpp"

namespace volute::bench {

/// The largest tolerance > 0, about, whose error stays within `target` > 0: at least 98 % of it
/// where the error grows continuously with the tolerance. Starts at `start` > 0 and fails when
/// `error` does, or when no tolerance is small enough.
[[nodiscard]] Result<double> searchTolerance(
    double target, double start, const std::function<Result<double>(double tolerance)>& error);

}  // namespace volute::bench
