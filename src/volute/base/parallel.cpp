// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/parallel.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#ifdef __SANITIZE_THREAD__
#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>
#endif

#include "volute/base/thread_priority.hpp"

namespace volute {

namespace {

#ifdef __SANITIZE_THREAD__

/// ThreadSanitizer does not see how the system's TBB orders its tasks and reports races that are
/// none, so loops run on threads that it sees. A loop within a loop stays on its thread.
thread_local bool insideLoop = false;

void forRanges(std::size_t count, std::size_t grain,
               const std::function<void(std::size_t, std::size_t)>& body) {
  const std::size_t parts = (count + grain - 1) / grain;
  std::atomic<std::size_t> next{0};
  std::exception_ptr error;
  std::mutex errorMutex;
  const auto work = [&] {
    const bool wasInside = std::exchange(insideLoop, true);
    try {
      for (std::size_t part = next++; part < parts; part = next++)
        body(part * grain, std::min(count, (part + 1) * grain));
    } catch (...) {
      const std::lock_guard lock(errorMutex);
      if (!error)
        error = std::current_exception();
      next = parts;
    }
    insideLoop = wasInside;
  };
  std::vector<std::jthread> workers;
  if (!insideLoop)
    for (std::size_t i = 1; i < std::min<std::size_t>(parts, threadCount()); ++i)
      workers.emplace_back([&] {
        detail::beginAsWorker();
        work();
      });
  work();
  workers.clear();  // joins
  if (error)
    std::rethrow_exception(error);
}

#else

/// The place that a loop's caller has among the threads that work on it.
constexpr int kCaller = 0;

void forRanges(std::size_t count, std::size_t grain,
               const std::function<void(std::size_t, std::size_t)>& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const auto& range) {
    if (tbb::this_task_arena::current_thread_index() != kCaller)
      detail::beginAsWorker();
    body(range.begin(), range.end());
  });
}

#endif

}  // namespace

void parallelRanges(std::size_t count, std::size_t grain,
                    const std::function<void(std::size_t, std::size_t)>& body) {
  forRanges(count, grain, body);
}

void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body) {
  forRanges(count, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

void isolated(const std::function<void()>& body) {
#ifdef __SANITIZE_THREAD__  // as above: what workers of others' loops do is not seen
  const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
#endif
  tbb::this_task_arena::isolate(body);
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
