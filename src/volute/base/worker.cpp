// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/worker.hpp"

#include <utility>

namespace volute {

Worker::~Worker() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
    works_.clear();
  }
  changed_.notify_all();
  if (thread_.joinable())
    thread_.join();
}

Status Worker::give(std::function<Status()> work) {
  std::unique_lock lock(mutex_);
  if (!thread_.joinable())
    thread_ = std::thread([this] { run(); });
  changed_.wait(lock, [&] { return works_.size() < pending_ || !status_; });
  if (status_)
    works_.push_back(std::move(work));
  changed_.notify_all();
  return status_;
}

Status Worker::finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return (works_.empty() && !busy_) || (!status_ && !busy_); });
  return status_;
}

void Worker::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return ends_ || (status_ && !works_.empty()); });
    if (ends_)
      return;
    const std::function<Status()> work = std::move(works_.front());
    works_.pop_front();
    busy_ = true;
    lock.unlock();
    changed_.notify_all();
    Status done = work();
    lock.lock();
    busy_ = false;
    if (!done) {
      status_ = std::move(done);
      works_.clear();
    }
    changed_.notify_all();
  }
}

}  // namespace volute
