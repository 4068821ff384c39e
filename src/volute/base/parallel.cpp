// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/parallel.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#ifdef __unix__
#include <pthread.h>
#endif

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "volute/base/thread_priority.hpp"

namespace volute {

namespace {

/// Whether loops run on threads that each of them begins instead of on the workers of TBB.
/// ThreadSanitizer does not see how the system's TBB orders its tasks and reports races that are
/// none. And the child of a fork has none of its parent's workers, of which one may have held a
/// lock of TBB's: what asks TBB for anything there may wait for ever.
#ifdef __SANITIZE_THREAD__
std::atomic<bool> ownThreads = true;
#else
std::atomic<bool> ownThreads = false;
#endif

/// The limit of the own threads of this one; 0: none.
thread_local int ownLimit = 0;

/// Before TBB is asked for anything: children of a fork are not to ask it.
void begin() {
#ifdef __unix__
  static const int watched = ::pthread_atfork(nullptr, nullptr, [] { ownThreads = true; });
  static_cast<void>(watched);
#endif
}

/// A loop within a loop on own threads stays on its thread.
thread_local bool insideLoop = false;

void onOwnThreads(std::size_t count, std::size_t grain,
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

/// The place that a loop's caller has among the threads that work on it.
constexpr int kCaller = 0;

void forRanges(std::size_t count, std::size_t grain,
               const std::function<void(std::size_t, std::size_t)>& body) {
  begin();
  if (ownThreads)
    return onOwnThreads(count, grain, body);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const auto& range) {
    if (tbb::this_task_arena::current_thread_index() != kCaller)
      detail::beginAsWorker();
    body(range.begin(), range.end());
  });
}

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
  begin();
#ifdef __SANITIZE_THREAD__  // what workers of other libraries' loops do is not seen
  const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
#endif
  if (ownThreads)
    return body();  // they take no part of other loops
  tbb::this_task_arena::isolate(body);
}

struct ThreadLimit::Impl {
  explicit Impl(int threads) : before(std::exchange(ownLimit, threads)) {
    begin();
    if (!ownThreads)
      control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                      static_cast<std::size_t>(threads));
  }

  ~Impl() {
    ownLimit = before;
    if (ownThreads)
      static_cast<void>(control.release());  // of the parent's TBB
  }

  int before;
  std::unique_ptr<tbb::global_control> control;
};

ThreadLimit::ThreadLimit(int threads)
    : impl_(threads > 0 ? std::make_unique<Impl>(threads) : nullptr) {}

ThreadLimit::~ThreadLimit() = default;

int threadCount() {
  if (!ownThreads)
    return static_cast<int>(
        tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));

  const int all = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return ownLimit > 0 ? std::min(ownLimit, all) : all;
}

}  // namespace volute
