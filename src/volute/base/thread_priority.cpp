// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/thread_priority.hpp"

#include <atomic>

#ifdef __linux__
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#endif

namespace volute {
namespace {

std::atomic<bool> workersWait = false;

}  // namespace

void lowerThreadPriority() {
#ifdef __linux__
  constexpr int kNice =
      10;  // a ninth of what a busy thread beside it gets; each thread's own on Linux
  const auto thread = static_cast<id_t>(::gettid());
  ::setpriority(PRIO_PROCESS, thread, std::max(kNice, ::getpriority(PRIO_PROCESS, thread)));
#endif
}

void lowerWorkerPriority() {
  workersWait.store(true, std::memory_order_relaxed);
}

void detail::beginAsWorker() {
  thread_local bool waits = false;
  if (waits || !workersWait.load(std::memory_order_relaxed))
    return;
  lowerThreadPriority();
  waits = true;
}

}  // namespace volute
