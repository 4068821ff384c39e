// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <mutex>

#include "volute/base/parallel.hpp"
#include "volute/base/result.hpp"

namespace volute {

/// parallelFor over a body that can fail: `Status body(i)`. All calls are made; the error of the
/// lowest i comes back, so that it does not depend on the threads.
template <class Body>
[[nodiscard]] Status parallelTry(std::size_t count, const Body& body) {
  std::mutex mutex;
  std::size_t firstAt = count;
  Status first;
  parallelFor(count, [&](std::size_t i) {
    Status status = body(i);
    if (status)
      return;
    const std::lock_guard lock(mutex);
    if (i >= firstAt)
      return;
    firstAt = i;
    first = std::move(status);
  });
  return first;
}

}  // namespace volute
