// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/cpu_thread.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "volute/base/thread_priority.hpp"
#include "volute/image/picture_tiles.hpp"

namespace volute {
namespace {

constexpr double kSoon = 0.35;     ///< [s]: a picture that takes longer comes in tiles,
constexpr double kTileTime = 0.2;  ///< [s] each, about
constexpr double kFiner = 2;       ///< times as many pixels a side in the next picture

/// From texel centres to texel centres, bilinearly.
std::vector<float> resampled(const std::vector<float>& from, int fromWidth, int fromHeight,
                             int width, int height) {
  std::vector<float> to(4 * static_cast<std::size_t>(width) * height);
  const auto place = [](int i, int length, int fromLength, int& low, int& high) {
    const double at = std::clamp((i + 0.5) * fromLength / length - 0.5, 0.0, fromLength - 1.0);
    low = static_cast<int>(at);
    high = std::min(low + 1, fromLength - 1);
    return static_cast<float>(at - low);
  };
  for (int y = 0; y < height; ++y) {
    int y0 = 0, y1 = 0;
    const float down = place(y, height, fromHeight, y0, y1);
    for (int x = 0; x < width; ++x) {
      int x0 = 0, x1 = 0;
      const float right = place(x, width, fromWidth, x0, x1);
      const auto at = [&](int column, int row, int c) {
        return from[4 * (static_cast<std::size_t>(row) * fromWidth + column) + c];
      };
      for (int c = 0; c < 4; ++c) {
        const float above = (1 - right) * at(x0, y0, c) + right * at(x1, y0, c);
        const float below = (1 - right) * at(x0, y1, c) + right * at(x1, y1, c);
        to[4 * (static_cast<std::size_t>(y) * width + x) + c] = (1 - down) * above + down * below;
      }
    }
  }
  return to;
}

int pixelsOf(double scale, int side) {
  return std::max(8, static_cast<int>(std::lround(scale * side)));
}

double realSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

class CpuThread::Stop final : public Progress {
 public:
  /// @param always  only the end of the program stops it
  Stop(CpuThread& owner, bool always) : owner_(owner), always_(always) {}

  bool cancelled() const override { return owner_.ends_ || (!always_ && owner_.stops_); }

 private:
  CpuThread& owner_;
  bool always_;
};

CpuThread::CpuThread(std::function<double()> clock)
    : clock_(clock ? std::move(clock) : realSeconds), thread_([this] { work(); }) {}

CpuThread::~CpuThread() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void CpuThread::request(CpuJob job) {
  {
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(job);
    stops_ = running_ && refining_;
    progress_.busy = true;
  }
  wake_.notify_all();
}

void CpuThread::stop() {
  const std::lock_guard lock(mutex_);
  waiting_.reset();
  stops_ = running_ && refining_;
  progress_.busy = running_ && !stops_;
}

std::vector<Result<CpuPart>> CpuThread::take() {
  const std::lock_guard lock(mutex_);
  std::vector<Result<CpuPart>> parts(std::make_move_iterator(done_.begin()),
                                     std::make_move_iterator(done_.end()));
  done_.clear();
  return parts;
}

bool CpuThread::has() const {
  const std::lock_guard lock(mutex_);
  return !done_.empty();
}

CpuProgress CpuThread::progress() const {
  const std::lock_guard lock(mutex_);
  return progress_;
}

void CpuThread::onDelivery(std::function<void()> wake) {
  const std::lock_guard lock(mutex_);
  delivered_ = std::move(wake);
}

void CpuThread::work() {
  lowerThreadPriority();
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return ends_ || waiting_; });
    if (ends_)
      return;
    const CpuJob job = *std::exchange(waiting_, std::nullopt);
    running_ = true;
    refining_ = job.continues;
    stops_ = false;
    lock.unlock();
    run(job);
    lock.lock();
    running_ = refining_ = stops_ = false;
    progress_.busy = waiting_.has_value();
  }
}

/// Until the finest picture is there: at once if that will not take long, else over ones of twice
/// as many pixels a side.
void CpuThread::run(const CpuJob& job) {
  double scale = job.first;
  if (job.newCosts)
    costs_ = {};
  bool preview = job.previewFirst && job.preview;
  canvasShown_ = canvasShown_ && job.continues;  // another view's is no ground for this one
  for (;;) {
    const bool finest = !preview && scale >= job.finest;
    if (!takePicture(job, scale, preview) || finest || !job.refines)
      return;
    const double pixels = static_cast<double>(job.width) * job.height;
    const double whole = costs_.fine * pixels * job.finest * job.finest;
    {
      const std::lock_guard lock(mutex_);
      if (waiting_ || ends_)
        return;
      refining_ = true;
    }
    if (preview && costs_.fine == 0)
      scale = std::max(scale / kFiner, job.first / kFiner);  // nobody knows what shadows cost
    else if (preview)
      scale = std::min(scale, job.finest);
    else
      scale = std::min(scale * kFiner, job.finest);
    if (costs_.fine > 0 && whole < kSoon)
      scale = job.finest;
    preview = false;
  }
}

/// The canvas has this size, and shows what the last picture showed.
void CpuThread::beginPicture(int width, int height) {
  if (canvasShown_ && canvasWidth_ > 0 && (canvasWidth_ != width || canvasHeight_ != height))
    canvas_ = resampled(canvas_, canvasWidth_, canvasHeight_, width, height);
  else if (!canvasShown_)
    canvas_.assign(4 * static_cast<std::size_t>(width) * height, 0);
  canvasWidth_ = width, canvasHeight_ = height;
}

bool CpuThread::takePicture(const CpuJob& job, double scale, bool preview) {
  const int width = pixelsOf(scale, job.width), height = pixelsOf(scale, job.height);
  const Camera camera = job.camera.camera(width, height);
  const double pixels = static_cast<double>(width) * height;
  double& cost = preview ? costs_.preview : costs_.fine;
  bool always = false;
  {
    const std::lock_guard lock(mutex_);
    always = !refining_;
  }
  Stop stop(*this, always);
  const double expected = cost * pixels;
  const bool inTiles = !always && job.inTiles && expected > kSoon;
  const auto tiles =
      pictureTiles(width, height, inTiles ? static_cast<int>(expected / kTileTime) + 1 : 1);
  if (inTiles && !canvasShown_)
    return false;  // there is always a coarser one
  beginPicture(width, height);
  const double begun = clock_();
  double done = 0, spent = 0;
  for (const PictureTile& tile : tiles) {
    const auto image = (preview ? job.preview : job.take)(
        tiles.size() == 1 ? camera : camera.cropped(tile.left, tile.top, tile.width, tile.height),
        stop);
    if (!image) {
      if (image.error().code != ErrorCode::kCancelled)
        deliver(tl::unexpected<Error>(image.error()));
      return false;
    }
    constexpr float kOpaque = 1e30F;
    const float* from = image->pixels.data();
    for (int y = 0; y < tile.height; ++y) {
      float* to = &canvas_[4 * (static_cast<std::size_t>(tile.top + y) * width + tile.left)];
      for (int x = 0; x < tile.width; ++x, from += 3, to += 4) {
        std::copy_n(from, 3, to);
        to[3] = kOpaque;
      }
    }
    spent = clock_() - begun;
    const double all = static_cast<double>(tile.width) * tile.height;
    done += all;
    CpuPart part{.number = job.number,
                 .time = job.time,
                 .scale = scale,
                 .width = width,
                 .height = height,
                 .preview = preview};
    const bool whole = &tile == &tiles.front();  // what is under the tiles comes with the first one
    if (whole) {
      part.partWidth = width, part.partHeight = height;
      part.rgba = canvas_;
    } else {
      part.left = tile.left, part.top = tile.top;
      part.partWidth = tile.width, part.partHeight = tile.height;
      for (int y = 0; y < tile.height; ++y) {
        const auto row =
            canvas_.begin() + 4 * (static_cast<std::ptrdiff_t>(tile.top + y) * width + tile.left);
        part.rgba.insert(part.rgba.end(), row, row + 4 * static_cast<std::ptrdiff_t>(tile.width));
      }
    }
    part.complete = &tile == &tiles.back();
    part.seconds = spent;
    {
      const std::lock_guard lock(mutex_);
      progress_.share = done * (scale * scale) / (pixels * job.finest * job.finest);
      progress_.secondsLeft = spent / done * (pixels - done);
    }
    deliver(std::move(part));
  }
  cost = spent / pixels;
  canvasShown_ = true;
  return true;
}

void CpuThread::deliver(Result<CpuPart> part) {
  std::function<void()> wake;
  {
    const std::lock_guard lock(mutex_);
    // Of an older picture nothing is needed once a newer one is whole.
    if (part && part->partWidth == part->width && part->partHeight == part->height)
      std::erase_if(done_, [](const auto& older) { return older.has_value(); });
    done_.push_back(std::move(part));
    wake = delivered_;
  }
  if (wake)
    wake();
}

}  // namespace volute
