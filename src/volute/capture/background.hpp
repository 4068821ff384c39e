// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <functional>

#include "volute/base/result.hpp"
#include "volute/image/image.hpp"

namespace volute {

/// The median of `count` pictures of one size, for each pixel and channel: what stays when sparks
/// and people pass by. For an even count the mean of the two middle ones. More pictures than
/// `maxMemory` holds are thinned evenly.
[[nodiscard]] Result<Image> medianImage(std::size_t count, std::uint64_t maxMemory,
                                        const std::function<Result<Image>(std::size_t)>& picture);

}  // namespace volute
