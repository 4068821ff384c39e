// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/processor_thread.hpp"

#include <chrono>
#include <utility>

namespace volute {

class ProcessorThread::Stop final : public Progress {
 public:
  explicit Stop(ProcessorThread& owner) : owner_(owner) {}

  bool cancelled() const override {
    const std::lock_guard lock(owner_.mutex_);
    return owner_.ends_ || owner_.stops_;
  }

 private:
  ProcessorThread& owner_;
};

ProcessorThread::ProcessorThread() : thread_([this] { work(); }) {}

ProcessorThread::~ProcessorThread() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void ProcessorThread::request(ProcessorJob job) {
  {
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(job);
  }
  wake_.notify_all();
}

void ProcessorThread::stopUnless(int number) {
  const std::lock_guard lock(mutex_);
  if (waiting_ && waiting_->number != number)
    waiting_.reset();
  if (running_ && *running_ != number)
    stops_ = true;
}

bool ProcessorThread::busy() const {
  const std::lock_guard lock(mutex_);
  return waiting_ || running_;
}

std::optional<ProcessorResult> ProcessorThread::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(done_, std::nullopt);
}

void ProcessorThread::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return ends_ || waiting_; });
    if (ends_)
      return;
    ProcessorJob job = *std::exchange(waiting_, std::nullopt);
    running_ = job.number;
    stops_ = false;
    lock.unlock();
    Stop stop(*this);
    const auto begun = std::chrono::steady_clock::now();
    Result<Image> image = job.take(job.camera, stop);
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begun;
    job.take = nullptr;
    lock.lock();
    running_.reset();
    if (!stops_)
      done_ = ProcessorResult{std::move(image), job.number, job.scale, spent.count()};
  }
}

}  // namespace volute
