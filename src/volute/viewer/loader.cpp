// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/loader.hpp"

#include <algorithm>
#include <chrono>

#include "volute/base/thread_priority.hpp"

namespace volute {
namespace {

constexpr double kLookEvery = 0.5;     ///< [s]
constexpr std::size_t kLookAt = 1000;  ///< files at a time: the window waits for it

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
  /// @param yields  stops for whatever is wanted, not for another file alone
  explicit Reporter(Loader& loader, bool yields = false) : loader_(loader), yields_(yields) {}

  void report(std::string_view stage, double done, double total) override {
    const std::lock_guard lock(loader_.mutex_);
    loader_.state_.stage = stage;
    loader_.state_.share = total > 0 ? done / total : -1;
  }

  bool cancelled() const override {
    if (!yields_)
      return loader_.overtaken();
    const std::lock_guard lock(loader_.mutex_);
    return loader_.ends_ || loader_.wanted();
  }

 private:
  Loader& loader_;
  bool yields_;
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

void Loader::setOpenGl(bool draws) {
  const std::lock_guard lock(mutex_);
  if (std::exchange(openGl_, draws) == draws || !draws || path_.empty() || wantedTime_)
    return;
  wantedTime_ = time_;
  wake_.notify_all();
}

void Loader::watch() {
  const std::lock_guard lock(mutex_);
  if (working_ || wantedPath_ || seconds() - lastLook_ < kLookEvery)
    return;
  lastLook_ = seconds();
  const std::size_t count = std::min(watched_.size(), kLookAt);
  for (std::size_t i = 0; i < count; ++i) {
    const Watched& watched = watched_[nextLook_++ % watched_.size()];
    if (changedAt(watched.path) == watched.time)
      continue;
    wantedPath_ = path_;
    wantedTime_ = time_;
    wake_.notify_all();
    return;
  }
}

void Loader::change(const std::string& key, DocumentChange what) {
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(wantedChanges_, [&](const auto& waiting) { return waiting.first == key; });
    wantedChanges_.emplace_back(key, std::move(what));
  }
  wake_.notify_all();
}

LoaderState Loader::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

bool Loader::idle() const {
  const std::lock_guard lock(mutex_);
  return !working_ && !wanted() && !unchecked_;
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

/// With the lock held.
bool Loader::wanted() const {
  return wantedPath_ || wantedTime_ || !wantedChanges_.empty();
}

/// What is wanted comes first; a document is looked through for damage when there is time.
void Loader::work() {
  letOthersFirst();
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return ends_ || wanted() || unchecked_; });
    if (ends_)
      return;
    if (!wanted()) {
      working_ = true;
      lock.unlock();
      checkNow();
      lock.lock();
      working_ = false;
      continue;
    }
    const auto path = std::exchange(wantedPath_, std::nullopt);
    auto time = std::exchange(wantedTime_, std::nullopt);
    if (path)
      wantedChanges_.clear();  // they were meant for what was open
    const auto changes = std::exchange(wantedChanges_, {});
    if (!changes.empty() && !time)
      time = time_;
    working_ = true;
    state_.busy = true;
    lock.unlock();
    const bool opened = !path || openNow(*path);
    for (const auto& [key, what] : changes) changeNow(what);
    if (opened && time && document_ && !overtaken())
      loadNow(*time);
    const bool checked = !document_ || document_->checked();
    lock.lock();
    working_ = false;
    unchecked_ = !checked;
    state_.busy = wanted();
  }
}

std::vector<Loader::Watched> Loader::look(const std::vector<std::filesystem::path>& files) {
  std::vector<Watched> watched;
  for (const auto& file : files) watched.push_back({file, changedAt(file)});
  return watched;
}

DocumentInfo Loader::describe() const {
  return {document_->title(),      document_->bounds(),   document_->times(),
          document_->grey(),       document_->measured(), document_->startView(),
          document_->background(), document_->remarks(),  document_->look(),
          document_->parameters(), document_->canvases(), document_->stations(),
          document_->sceneName(),  openedCount_,          document_->editable(),
          document_->canUndo(),    document_->canRedo()};
}

/// False, with the error noted, when it stays with what was open.
bool Loader::openNow(const std::string& path) {
  Reporter reporter(*this);
  reporter.report("opening", 0, 0);
  // Whatever is wrong with a file that was open, it is tried again when one of its parts changes.
  std::vector<std::filesystem::path> files{path};
  if (document_ && path == path_)
    files = document_->files();
  std::vector<Watched> watched = look(files);
  auto document = open_(path, reporter);
  std::optional<DocumentInfo> info;
  if (document) {
    watched = look((*document)->files());
    document_ = std::move(*document);
    ++openedCount_;
    info = describe();  // before the lock: the window never waits for it
  }
  const std::lock_guard lock(mutex_);
  path_ = path;
  watched_ = std::move(watched);
  if (!document) {
    if (document.error().code != ErrorCode::kCancelled)
      state_.error = document.error().message;
    return false;
  }
  state_.error.clear();
  opened_ = std::move(info);
  loaded_.reset();
  return true;
}

void Loader::changeNow(const DocumentChange& what) {
  if (!document_)
    return;
  Reporter reporter(*this);
  auto done = what(*document_, reporter);
  auto watched = look(document_->files());  // what it wrote itself is no news
  DocumentInfo info = describe();
  const std::lock_guard lock(mutex_);
  watched_ = std::move(watched);
  opened_ = std::move(info);
  if (!done) {
    state_.error = done.error().message;
    return;
  }
  state_.error.clear();
  if (!done->empty())
    state_.message = std::move(*done);
}

void Loader::checkNow() {
  Reporter reporter(*this, true);
  document_->check(reporter);
  const bool checked = document_->checked();
  DocumentInfo info = describe();
  const std::lock_guard lock(mutex_);
  unchecked_ = !checked;
  if (checked)
    opened_ = std::move(info);
}

void Loader::loadNow(double time) {
  Reporter reporter(*this);
  SceneWish wish{.time = time, .coarse = true};
  {
    const std::lock_guard lock(mutex_);
    time_ = time;
    wish.openGl = openGl_;
  }
  if (document_->coarseHelps(time))
    deliver(document_->sceneAt(wish, reporter), time, true);
  wish.coarse = false;
  if (!overtaken())
    deliver(document_->sceneAt(wish, reporter), time, false);
}

void Loader::deliver(Result<ViewScene> scene, double time, bool coarse) {
  const std::lock_guard lock(mutex_);
  if (scene) {
    loaded_ = LoadedScene{std::make_shared<const ViewScene>(std::move(*scene)), time, coarse};
    if (std::exchange(errorIsOfScene_, false))
      state_.error.clear();
  } else if (scene.error().code != ErrorCode::kCancelled) {
    state_.error = scene.error().message;
    errorIsOfScene_ = true;
  }
}

}  // namespace volute
