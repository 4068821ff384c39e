// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace volute {

/// Calls body(begin, end) for ranges that together cover [0, count), on all threads; `grain` is the
/// least range worth a task. The body must not depend on how the ranges are cut. Returns when all
/// are done.
void parallelRanges(std::size_t count, std::size_t grain,
                    const std::function<void(std::size_t, std::size_t)>& body);

/// Calls body(i) for each i in [0, count), each as a task of its own.
void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body);

/// Calls body() so that its thread, while it waits for loops inside, takes no part of loops
/// outside: those could wait for what body() has locked.
void isolated(const std::function<void()>& body);

/// While it lives, parallel loops use at most this many threads (`--threads N`). 0 = as many as
/// there are.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

int threadCount();

}  // namespace volute
