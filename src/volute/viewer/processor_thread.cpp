// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/processor_thread.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "volute/base/thread_priority.hpp"

namespace volute {
namespace {

/// Here, since a window waits for no copy of a picture.
Result<PictureTexels> texelsOf(const Result<Image>& image) {
  if (!image)
    return tl::unexpected<Error>(image.error());
  constexpr float kOpaque = 1e30F;
  const std::size_t count = image->pixels.size() / 3;
  PictureTexels texels{image->width, image->height, std::vector<float>(4 * count)};
  const float* from = image->pixels.data();
  float* to = texels.rgba.data();
  for (std::size_t i = 0; i < count; ++i, from += 3, to += 4) {
    std::copy_n(from, 3, to);
    to[3] = kOpaque;
  }
  return texels;
}

}  // namespace

class ProcessorThread::Stop final : public Progress {
 public:
  explicit Stop(ProcessorThread& owner) : owner_(owner) {}

  bool cancelled() const override { return owner_.ends_ || owner_.stops_; }

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
  letOthersFirst();
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
    auto picture = texelsOf(job.take(job.camera, stop));
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begun;
    job.take = nullptr;
    lock.lock();
    running_.reset();
    if (!stops_)
      done_ = ProcessorResult{std::move(picture), job.number, job.scale, spent.count()};
  }
}

}  // namespace volute
