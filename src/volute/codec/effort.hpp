// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

namespace volute {

/// From 1, the fastest, to 9, the smallest files. docs/measurements has what each costs.
inline constexpr int kMinEffort = 1, kMaxEffort = 9;
inline constexpr int kDefaultEffort = 5;
inline constexpr int kFastEffort = 2;

}  // namespace volute
