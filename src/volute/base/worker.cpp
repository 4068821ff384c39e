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
  changed_.wait(lock, [&] { return works_.size() < pending_ || failed(); });
  if (!failed())
    works_.push_back(std::move(work));
  changed_.notify_all();
  return outcome();
}

Status Worker::finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return !busy_ && (works_.empty() || failed()); });
  return outcome();
}

Status Worker::outcome() const {
  if (thrown_)
    std::rethrow_exception(thrown_);
  return status_;
}

void Worker::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return ends_ || (!failed() && !works_.empty()); });
    if (ends_)
      return;
    const std::function<Status()> work = std::move(works_.front());
    works_.pop_front();
    busy_ = true;
    lock.unlock();
    changed_.notify_all();
    Status done;
    std::exception_ptr thrown;
    try {
      done = work();
    } catch (...) {  // out of memory: for whoever waits
      thrown = std::current_exception();
    }
    lock.lock();
    busy_ = false;
    status_ = std::move(done), thrown_ = thrown;
    if (failed())
      works_.clear();
    changed_.notify_all();
  }
}

}  // namespace volute
