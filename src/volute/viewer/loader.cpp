// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/loader.hpp"

#include <chrono>

namespace volute {
namespace {

constexpr double kLookEvery = 0.5;  ///< [s]

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::filesystem::file_time_type changedAt(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::last_write_time(path, ignored);
}

}  // namespace

/// Tells the viewer how far the thread is, and the thread when to stop.
class Loader::Reporter final : public Progress {
 public:
  explicit Reporter(Loader& loader) : loader_(loader) {}

  void report(std::string_view stage, double done, double total) override {
    const std::lock_guard lock(loader_.mutex_);
    loader_.state_.stage = stage;
    loader_.state_.share = total > 0 ? done / total : -1;
  }

  bool cancelled() const override { return loader_.overtaken(); }

 private:
  Loader& loader_;
};

Loader::Loader(OpenDocument open) : open_(std::move(open)), thread_([this] { work(); }) {}

Loader::~Loader() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Loader::open(std::string path, double time) {
  {
    const std::lock_guard lock(mutex_);
    wantedPath_ = std::move(path);
    wantedTime_ = time;
  }
  wake_.notify_all();
}

void Loader::request(double time) {
  {
    const std::lock_guard lock(mutex_);
    wantedTime_ = time;
  }
  wake_.notify_all();
}

void Loader::watch() {
  const std::lock_guard lock(mutex_);
  if (working_ || wantedPath_ || seconds() - lastLook_ < kLookEvery)
    return;
  lastLook_ = seconds();
  for (const Watched& watched : watched_) {
    if (changedAt(watched.path) == watched.time)
      continue;
    wantedPath_ = path_;
    wantedTime_ = time_;
    wake_.notify_all();
    return;
  }
}

LoaderState Loader::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

bool Loader::idle() const {
  const std::lock_guard lock(mutex_);
  return !working_ && !wantedPath_ && !wantedTime_;
}

std::optional<DocumentInfo> Loader::takeDocument() {
  const std::lock_guard lock(mutex_);
  return std::exchange(opened_, std::nullopt);
}

std::optional<LoadedScene> Loader::takeScene() {
  const std::lock_guard lock(mutex_);
  return std::exchange(loaded_, std::nullopt);
}

/// A newer path ends whatever runs; a newer time does not, or a film that is read slower than it
/// plays would never show a frame.
bool Loader::overtaken() const {
  const std::lock_guard lock(mutex_);
  return ends_ || wantedPath_.has_value();
}

void Loader::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return ends_ || wantedPath_ || wantedTime_; });
    if (ends_)
      return;
    const auto path = std::exchange(wantedPath_, std::nullopt);
    const auto time = std::exchange(wantedTime_, std::nullopt);
    working_ = true;
    state_.busy = true;
    lock.unlock();
    const bool opened = !path || openNow(*path);
    if (opened && time && document_ && !overtaken())
      loadNow(*time);
    lock.lock();
    working_ = false;
    state_.busy = wantedPath_ || wantedTime_;
  }
}

/// False, with the error noted, when it stays with what was open.
bool Loader::openNow(const std::string& path) {
  Reporter reporter(*this);
  reporter.report("opening", 0, 0);
  std::vector<Watched> watched{{path, changedAt(path)}};
  auto document = open_(path, reporter);
  if (document) {
    watched.clear();
    for (const auto& file : (*document)->files()) watched.push_back({file, changedAt(file)});
  }
  const std::lock_guard lock(mutex_);
  path_ = path;
  watched_ = std::move(watched);
  if (!document) {
    if (document.error().code != ErrorCode::kCancelled)
      state_.error = document.error().message;
    return false;
  }
  document_ = std::move(*document);
  state_.error.clear();
  opened_ = DocumentInfo{document_->title(),  document_->bounds(),    document_->times(),
                         document_->grey(),   document_->startView(), document_->background(),
                         document_->remarks()};
  loaded_.reset();
  return true;
}

void Loader::loadNow(double time) {
  Reporter reporter(*this);
  {
    const std::lock_guard lock(mutex_);
    time_ = time;
  }
  if (document_->coarseHelps(time))
    deliver(document_->sceneAt(time, true, reporter), time, true);
  if (!overtaken())
    deliver(document_->sceneAt(time, false, reporter), time, false);
}

void Loader::deliver(Result<GlScene> scene, double time, bool coarse) {
  const std::lock_guard lock(mutex_);
  if (scene) {
    loaded_ = LoadedScene{std::move(*scene), time, coarse};
    state_.error.clear();
  } else if (scene.error().code != ErrorCode::kCancelled) {
    state_.error = scene.error().message;
  }
}

}  // namespace volute
