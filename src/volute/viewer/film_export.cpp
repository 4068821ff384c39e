// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/film_export.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "volute/base/content_hash.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/thread_priority.hpp"
#include "volute/io/film.hpp"
#include "volute/io/image_file.hpp"
#include "volute/viewer/camera_path.hpp"
#include "volute/viewer/shown_picture.hpp"

namespace volute {
namespace {

constexpr std::size_t kMaxWaiting = 3;  ///< pictures that the encoder has not come to
constexpr int kLargestSide = 8192;

}  // namespace

int FilmOrder::frames() const {
  const double seconds = length > 0 ? length : (end - begin) / speed;
  return 1 + static_cast<int>(std::floor(seconds * rate + 1e-9));
}

ViewCamera FilmOrder::cameraOf(int frame) const {
  ViewCamera there = camera;
  if (!keys.empty())
    return alongKeys(camera, keys, timeOf(frame));
  if (turns)  // the last picture is one step before the first
    there.turn(2 * std::numbers::pi * frame / frames());
  return there;
}

double FilmOrder::timeOf(int frame) const {
  const double since = frame * speed / rate;
  if (length > 0)
    return end > begin ? begin + std::fmod(since, end - begin) : begin;
  return std::min(begin + since, end);
}

std::string FilmOrder::key() const {
  ContentHash hash;
  const auto text = [&](const std::string& part) {
    hash.add(static_cast<double>(part.size()));
    hash.add(std::span<const char>(part));
  };
  const auto view = [&](const Vec3& v) { hash.add(std::span<const double>(v.data(), 3)); };
  text(target), text(content), text(look.view ? look.view->name() : "");
  for (const double value :
       {double(width), double(height), rate, begin, end, speed, length, double(turns),
        double(renderer == ViewRenderer::kGl), double(surfaces), look.exposure, double(look.tone),
        look.map ? double(*look.map) : -1, camera.fov(), camera.ortho()})
    hash.add(value);
  view(camera.eye()), view(camera.forward()), view(camera.view().up), view(camera.pivot());
  view(Vec3(look.background.matrix()));
  for (const CameraKey& key : keys) hash.add(key.time), view(key.eye), view(key.target);
  return hash.digits();
}

std::filesystem::path FilmOrder::pictureOf(int frame) const {
  return folder / key() / fmt::format("{:06d}.png", frame);
}

Result<std::unique_ptr<FilmExport>> FilmExport::begin(const FilmOrder& order,
                                                      const PictureMakers& makers) {
  const bool good = order.width >= 16 && order.height >= 16 && order.width <= kLargestSide &&
                    order.height <= kLargestSide && order.rate > 0 && order.speed > 0 &&
                    order.end >= order.begin &&
                    (order.end - order.begin) / order.speed * order.rate < 1e6;
  if (!good)
    return fail(ErrorCode::kInvalidArgument,
                "{}: a film of {} x {} pixels from {} to {} s cannot be made", order.target,
                order.width, order.height, plainNumber(order.begin), plainNumber(order.end));
  VOLUTE_ASSIGN(auto picture, ViewPicture::create(makers));
  return std::unique_ptr<FilmExport>(new FilmExport(order, std::move(picture)));
}

FilmExport::FilmExport(const FilmOrder& order, ViewPicture picture)
    : order_(order), picture_(std::move(picture)) {
  colors_ = makeTexture2d(GL_RGBA8, order.width, order.height);
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  frame_ = GlFramebuffer(name);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, colors_.name(), 0);
  thread_ = std::thread([this] { encode(); });
}

FilmExport::~FilmExport() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

/// What an earlier film of the same order left of the next picture.
bool FilmExport::takeKept() {
  std::error_code none;
  if (order_.folder.empty() || drawing_ || !std::filesystem::exists(order_.pictureOf(next_), none))
    return false;
  ++resumed_;
  push({}, false);
  return true;
}

bool FilmExport::keeps() const {
  std::error_code none;
  return !order_.folder.empty() && std::filesystem::exists(order_.pictureOf(0).parent_path(), none);
}

void FilmExport::push(Image image, bool slow) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back({std::move(image), next_, slow && !order_.folder.empty()});
    all_ = ++next_ >= order_.frames();
  }
  wake_.notify_all();
}

std::optional<double> FilmExport::wantedTime() const {
  if (next_ >= order_.frames())
    return std::nullopt;
  return order_.timeOf(next_);
}

Status FilmExport::failure() const {
  const std::lock_guard lock(mutex_);
  return error_ ? Status(tl::unexpected<Error>(*error_)) : Status();
}

bool FilmExport::finished() const {
  const std::lock_guard lock(mutex_);
  return finished_;
}

double FilmExport::share() const {
  const std::lock_guard lock(mutex_);
  return static_cast<double>(encoded_) / order_.frames();
}

std::optional<double> FilmExport::secondsLeft() const {
  constexpr double kLittle = 0.02;
  const double done = share();
  if (done < kLittle)
    return std::nullopt;
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begun_;
  return spent.count() * (1 - done) / done;
}

Status FilmExport::step(const std::shared_ptr<const ViewScene>& scene) {
  VOLUTE_TRY(failure());
  if (next_ >= order_.frames())
    return {};
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() >= kMaxWaiting)
      return {};
  }
  if (takeKept())
    return {};
  if (!scene)
    return {};
  const PictureRequest request{.camera = order_.cameraOf(next_),
                               .width = order_.width,
                               .height = order_.height,
                               .quality = Quality::kFull,
                               .renderer = order_.renderer,
                               .surfaces = order_.surfaces,
                               .single = true,
                               .exactAfter = 0};
  if (!drawing_) {
    picture_.setScene(scene);
    drawnFrom_ = std::chrono::steady_clock::now();
  }
  drawing_ = true;
  VOLUTE_TRY(picture_.update(request));
  if (!picture_.settled(request) || !picture_.exact(request))
    return {};  // the CPU is at it, or surfaces
  drawing_ = false;
  if (!picture_.remark().empty())
    remark_ = picture_.remark();
  glBindFramebuffer(GL_FRAMEBUFFER, frame_.name());
  picture_.show(order_.look, order_.width, order_.height);
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - drawnFrom_;
  push(shownPicture(order_.width, order_.height), spent.count() >= order_.slow);
  return {};
}

/// In a thread of its own.
void FilmExport::encode() {
  lowerThreadPriority();
  const auto stop = [&](const Error& error) {
    const std::lock_guard lock(mutex_);
    error_ = error;
  };
  auto writer = FilmWriter::create(order_.target, order_.width, order_.height, order_.rate);
  if (!writer)
    return stop(writer.error());
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return ends_ || all_ || !waiting_.empty(); });
    if (ends_)
      return;
    if (waiting_.empty())
      break;
    Waiting next = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    if (next.image.pixels.empty()) {
      auto kept = readImage(order_.pictureOf(next.frame));
      if (!kept || kept->width != order_.width || kept->height != order_.height)
        return stop({ErrorCode::kInvalidData,
                     fmt::format("{}: no picture of the film; remove the folder and make it anew",
                                 order_.pictureOf(next.frame).string())});
      next.image = std::move(*kept);
    } else if (next.keep) {
      std::error_code failed;  // then it is drawn again
      std::filesystem::create_directories(order_.pictureOf(0).parent_path(), failed);
      (void)writeImage(order_.pictureOf(next.frame), next.image);
    }
    if (const auto added = (*writer)->addFrame(next.image); !added)
      return stop(added.error());
    lock.lock();
    ++encoded_;
  }
  lock.unlock();
  if (const auto written = (*writer)->finish(); !written)
    return stop(written.error());
  std::error_code gone;
  if (!order_.folder.empty())
    std::filesystem::remove_all(order_.pictureOf(0).parent_path(), gone);
  lock.lock();
  finished_ = true;
}

}  // namespace volute
