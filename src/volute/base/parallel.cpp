// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/parallel.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "volute/base/thread_priority.hpp"

namespace volute {

namespace {

/// The place that a loop's caller has among the threads that work on it.
constexpr int kCaller = 0;

void beginPart() {
  if (tbb::this_task_arena::current_thread_index() != kCaller)
    detail::beginAsWorker();
}

}  // namespace

void parallelRanges(std::size_t count, std::size_t grain,
                    const std::function<void(std::size_t, std::size_t)>& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const auto& range) {
    beginPart();
    body(range.begin(), range.end());
  });
}

void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1), [&](const auto& range) {
    beginPart();
    for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
  });
}

struct ThreadLimit::Impl {
  explicit Impl(int threads)
      : control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)) {}

  tbb::global_control control;
};

ThreadLimit::ThreadLimit(int threads)
    : impl_(threads > 0 ? std::make_unique<Impl>(threads) : nullptr) {}

ThreadLimit::~ThreadLimit() = default;

int threadCount() {
  return static_cast<int>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

}  // namespace volute
