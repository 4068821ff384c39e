// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

#include "volute/base/result.hpp"

namespace volute {

/// A stage of a pipeline: does what it is given on a thread of its own, one after the other, while
/// whoever gives it goes on. Loops of the work use all threads as loops elsewhere do.
class Worker {
 public:
  /// @param pending  works that may wait; give() waits for room
  explicit Worker(std::size_t pending) : pending_(pending) {}

  /// Waits for the task that runs; tasks that have not begun are dropped.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// The error of an earlier work, after which nothing more is done. What a work throws, give() and
  /// finish() throw.
  [[nodiscard]] Status give(std::function<Status()> work);

  /// Waits for all that was given; the first error, of any work.
  [[nodiscard]] Status finish();

 private:
  void run();

  bool failed() const { return !status_ || thrown_; }

  Status outcome() const;

  std::size_t pending_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<Status()>> works_;
  bool busy_ = false, ends_ = false;
  Status status_;
  std::exception_ptr thrown_;
  std::thread thread_;  ///< begins with the first work
};

}  // namespace volute
