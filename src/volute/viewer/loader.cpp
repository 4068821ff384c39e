// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/loader.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <unordered_map>

#include "volute/base/content_hash.hpp"
#include "volute/base/thread_priority.hpp"

namespace volute {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr auto kLookEvery = std::chrono::milliseconds(500);
constexpr std::size_t kLookAt = 1000;  ///< files at a time: requests wait for it

std::filesystem::file_time_type changedAt(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::last_write_time(path, ignored);
}

}  // namespace

/// Tells the viewer how far the thread is, and the thread when to stop.
class Loader::Reporter final : public Progress {
 public:
  explicit Reporter(Loader& loader) : Reporter(loader, loader.overtaken_) {}

  /// @param stops  for what
  Reporter(Loader& loader, const std::atomic<bool>& stops) : loader_(loader), stops_(stops) {}

  void report(std::string_view stage, double done, double total) override {
    const std::lock_guard lock(loader_.mutex_);
    loader_.state_.stage = stage;
    loader_.state_.share = total > 0 ? done / total : -1;
    ++loader_.changes_;
  }

  bool cancelled() const override { return stops_; }

 private:
  Loader& loader_;
  const std::atomic<bool>& stops_;
};

namespace {

/// Of work that nobody waits for.
class QuietUntil final : public Progress {
 public:
  explicit QuietUntil(const std::atomic<bool>& stops) : stops_(stops) {}

  bool cancelled() const override { return stops_; }

 private:
  const std::atomic<bool>& stops_;
};

}  // namespace

Loader::Loader(OpenDocument open) : open_(std::move(open)), thread_([this] { work(); }) {}

Loader::~Loader() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = frozenStops_ = true;
    noteRequests();
  }
  thread_.join();
}

/// With the lock held, after what is requested for has changed.
void Loader::noteRequests() {
  overtaken_ = ends_ || wantedPath_;
  disturbed_ = ends_ || wanted();
  aheadStops_ = overtaken_ || !wantedChanges_.empty() || (wantedTime_ && !playing_);
  ++changes_;
  wake_.notify_all();
}

void Loader::open(std::string path, std::optional<double> time) {
  const std::lock_guard lock(mutex_);
  wantedPath_ = std::move(path);
  again_ = false;
  wantedTime_ = time;
  noteRequests();
}

void Loader::request(double time, std::vector<double> ahead, double period) {
  const std::lock_guard lock(mutex_);
  playing_ = !ahead.empty();
  ahead_ = std::move(ahead);
  period_ = period;
  const bool kept = !wantedPath_ && wantedChanges_.empty() && !changing_;
  if (auto snapshot = kept ? ring_.find(time) : nullptr) {
    if (loaded_)
      discarded_.push_back(std::move(loaded_->scene));
    wantedTime_.reset();
    if (snapshot->provisional && !playing_)
      wantedTime_ = time;
    loaded_ = LoadedScene{std::move(snapshot), time, false};
    time_ = time;
  } else if (playing_ && kept && loadingAhead_ == time) {
    awaited_ = time;  // it is about to be there
  } else {
    wantedTime_ = time;
  }
  noteRequests();
}

void Loader::prepare(std::vector<double> ahead, double period) {
  const std::lock_guard lock(mutex_);
  ahead_ = std::move(ahead);
  period_ = period;
  triesWhole_ = true;
  wake_.notify_all();
}

void Loader::setOpenGl(bool draws) {
  if (openGl_.exchange(draws) == draws || !draws)
    return;
  const std::lock_guard lock(mutex_);
  for (auto& snapshot : ring_.clear()) discarded_.push_back(std::move(snapshot));
  if (path_.empty() || wantedTime_)
    return;
  wantedTime_ = time_;
  noteRequests();
}

void Loader::change(const std::string& key, DocumentChange what) {
  const std::lock_guard lock(mutex_);
  const auto frozen = std::ranges::find_if(wantedChanges_.rbegin(), wantedChanges_.rend(),
                                           [](const auto& waiting) { return !waiting.second; });
  const auto [gone, end] = std::ranges::remove(frozen.base(), wantedChanges_.end(), key,
                                               &std::pair<std::string, DocumentChange>::first);
  wantedChanges_.erase(gone, end);
  wantedChanges_.emplace_back(key, std::move(what));
  noteRequests();
}

void Loader::freeze() {
  const std::lock_guard lock(mutex_);
  wantedChanges_.emplace_back("", DocumentChange());
  noteRequests();
}

void Loader::requestFrozen(const SceneRequest& request) {
  const std::lock_guard lock(mutex_);
  wantedFrozen_ = request;
  frozenStops_ = false;
  wake_.notify_all();
}

void Loader::thaw() {
  const std::lock_guard lock(mutex_);
  if (loadedFrozen_ && *loadedFrozen_)
    discarded_.push_back(std::move((*loadedFrozen_)->scene));
  loadedFrozen_.reset();
  wantedFrozen_.reset();
  frozenStops_ = thaws_ = true;
  wake_.notify_all();
}

std::optional<LoaderNews> Loader::news() {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock)
    return std::nullopt;
  state_.decoded = ring_.times();
  return LoaderNews{state_,
                    idleNow(),
                    std::exchange(opened_, std::nullopt),
                    std::exchange(loaded_, std::nullopt),
                    std::exchange(loadedFrozen_, std::nullopt),
                    std::exchange(readFields_, std::nullopt)};
}

bool Loader::idle() const {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  return lock && idleNow();
}

void Loader::discard(std::shared_ptr<const ViewScene> scene) {
  if (!scene)
    return;
  const std::lock_guard lock(mutex_);
  discarded_.push_back(std::move(scene));
  wake_.notify_all();
}

/// With the lock held.
bool Loader::idleNow() const {
  return !working_ && !wanted() && !unchecked_ && !wantedFields_;
}

/// With the lock held.
bool Loader::wanted() const {
  return wantedPath_ || wantedTime_ || !wantedChanges_.empty();
}

/// With the lock held: whether whole snapshots would be late.
bool Loader::hurries() const {
  constexpr double kShare = 0.4;  // of a period: pictures are drawn meanwhile
  return period_ > 0 && wholeSeconds_ > kShare * period_;
}

/// With the lock held: whether a snapshot that is loaded ahead is whole. One tells again how long
/// they take, once there is time for it: the first one after a file is opened takes longer.
bool Loader::mayBeWhole(double time) {
  constexpr std::ptrdiff_t kFar = 8;
  if (!hurries())
    return true;
  const bool far = std::ranges::find(ahead_, time) - ahead_.begin() >= kFar;
  return far && std::exchange(triesWhole_, false);
}

/// With the lock held.
bool Loader::freezes() const {
  return std::ranges::any_of(wantedChanges_, [](const auto& waiting) { return !waiting.second; });
}

/// What is wanted comes first; a document is looked through for damage when there is time.
void Loader::work() {
  lowerThreadPriority();
  auto nextLook = SteadyClock::now() + kLookEvery;
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait_until(lock, nextLook, [&] {
      return ends_ || wanted() || wantedFrozen_ || thaws_ || unchecked_ || !discarded_.empty() ||
             wantedFields_ || ring_.missing(ahead_);
    });
    if (ends_)
      return;
    if (!discarded_.empty())
      freeDiscarded(lock);
    if (thaws_)
      freeThawed(lock);
    const bool asked = wanted();
    if (asked)
      serve(lock);
    if (wantedFrozen_ && !freezes() && !ends_)
      loadFrozen(lock);  // by turns: neither waits for ever
    else if (asked)
      continue;
    else if (wantedFields_)
      readFields(lock);
    else if (ring_.missing(ahead_))
      loadAhead(lock);
    else if (unchecked_)
      checkNow(lock);
    if (SteadyClock::now() < nextLook)
      continue;
    lock.unlock();
    const bool changed = changedOnDisk();
    lock.lock();
    nextLook = SteadyClock::now() + kLookEvery;
    if (!changed || wantedPath_)
      continue;
    wantedPath_ = path_;
    again_ = true;
    wantedTime_ = wantedTime_.value_or(time_);
    noteRequests();
  }
}

/// Does what is wanted; the lock is held before and after.
void Loader::serve(std::unique_lock<std::mutex>& lock) {
  const auto path = std::exchange(wantedPath_, std::nullopt);
  auto time = std::exchange(wantedTime_, std::nullopt);
  auto changes = std::exchange(wantedChanges_, {});
  const auto isFreeze = [](const auto& change) { return !change.second; };
  const bool again = path && again_;
  if (path && !again) {  // they were meant for what is open still
    const auto last = std::find_if(changes.rbegin(), changes.rend(), isFreeze);
    changes.erase(last.base(), changes.end());
  }
  const bool changed = !std::ranges::all_of(changes, isFreeze);
  changing_ = path || changed;
  working_ = true;  // before the lock is given up
  state_.busy = true;
  if (changing_)
    forgetSnapshots(lock);
  if (changed && !path && !time)
    time = time_;
  noteRequests();
  lock.unlock();
  for (const auto& [key, what] : changes) changeNow(what);
  const bool opened = !path || openNow(*path, again);
  if (path && opened && document_ && !time)
    time = firstTime_;
  if (opened && time && document_ && !overtaken_)
    loadNow(*time);
  const bool checked = !document_ || document_->checked();
  lock.lock();
  working_ = changing_ = false;
  ++changes_;
  unchecked_ = !checked;
  state_.busy = wanted();
}

/// What was loaded is no longer what the document shows. The lock is held before and after.
void Loader::forgetSnapshots(std::unique_lock<std::mutex>& lock) {
  auto gone = ring_.clear();
  ahead_.clear();
  lock.unlock();
  gone.clear();
  lock.lock();
}

/// The lock is held before and after.
void Loader::loadAhead(std::unique_lock<std::mutex>& lock) {
  const double time = *ring_.missing(ahead_);
  if (!document_) {
    ahead_.clear();
    return;
  }
  loadingAhead_ = time;
  awaited_.reset();
  const SceneRequest request{.time = time, .moving = !mayBeWhole(time), .openGl = openGl_};
  lock.unlock();
  Reporter reporter(*this, aheadStops_);
  const auto begun = SteadyClock::now();
  auto scene = document_->sceneAt(request, reporter);
  const std::chrono::duration<double> spent = SteadyClock::now() - begun;
  std::vector<SnapshotRing::Held> gone;
  lock.lock();
  loadingAhead_.reset();
  if (scene && !request.moving)
    wholeSeconds_ = spent.count();
  if (!scene) {  // request() will say why
    if (scene.error().code != ErrorCode::kCancelled)
      ahead_.clear();
    if (awaited_ && !wantedTime_)
      wantedTime_ = awaited_;
    return;
  }
  if (!wantedPath_ && wantedChanges_.empty()) {
    const auto snapshot = std::make_shared<const ViewScene>(std::move(*scene));
    gone = ring_.add(time, snapshot, ahead_);
    if (awaited_ == time) {
      if (loaded_)
        gone.push_back(std::move(loaded_->scene));
      loaded_ = LoadedScene{snapshot, time, false};
      time_ = time;
      ++changes_;
    }
  }
  lock.unlock();
  gone.clear();
  lock.lock();
}

/// The lock is held before and after.
void Loader::loadFrozen(std::unique_lock<std::mutex>& lock) {
  const SceneRequest request = *std::exchange(wantedFrozen_, std::nullopt);
  lock.unlock();
  QuietUntil progress(frozenStops_);
  auto scene = frozen_ ? frozen_->sceneAt(request, progress)
                       : fail(ErrorCode::kNotFound, "the file was closed before this began");
  auto loaded = scene ? Result<LoadedScene>(LoadedScene{
                            std::make_shared<const ViewScene>(std::move(*scene)), request.time})
                      : tl::unexpected<Error>(scene.error());
  std::optional<Result<LoadedScene>> gone;
  lock.lock();
  if (wantedFrozen_ || thaws_) {
    gone = std::move(loaded);
  } else {
    gone = std::exchange(loadedFrozen_, std::move(loaded));
    ++changes_;
  }
  lock.unlock();
  gone.reset();
  lock.lock();
}

/// The lock is held before and after.
void Loader::freeThawed(std::unique_lock<std::mutex>& lock) {
  thaws_ = false;
  lock.unlock();
  frozen_.reset();
  lock.lock();
}

void Loader::requestFields(const Vec3& place) {
  const std::lock_guard lock(mutex_);
  wantedFields_ = place;
  wake_.notify_all();
}

/// The lock is held before and after.
void Loader::readFields(std::unique_lock<std::mutex>& lock) {
  LoadedFields read{*std::exchange(wantedFields_, std::nullopt), time_};
  if (!document_)
    return;
  working_ = true;
  lock.unlock();
  read.fields = document_->fieldsAt(read.time, read.place);
  lock.lock();
  working_ = false;
  readFields_ = std::move(read);
  ++changes_;
}

void Loader::freeDiscarded(std::unique_lock<std::mutex>& lock) {
  auto discarded = std::exchange(discarded_, {});
  lock.unlock();
  discarded.clear();
  lock.lock();
}

bool Loader::changedOnDisk() {
  const std::size_t count = std::min(watched_.size(), kLookAt);
  for (std::size_t i = 0; i < count; ++i) {
    const Watched& watched = watched_[nextLook_++ % watched_.size()];
    if (changedAt(watched.path) != watched.time)
      return true;
  }
  return false;
}

/// @param before  keep their times
std::vector<Loader::Watched> Loader::look(const std::vector<std::filesystem::path>& files,
                                          std::span<const Watched> before) {
  std::unordered_map<std::string, std::filesystem::file_time_type> times;
  for (const Watched& file : before) times.emplace(file.path.native(), file.time);
  std::vector<Watched> watched;
  for (const auto& path : files) {
    const auto old = times.find(path.native());
    watched.push_back({path, old == times.end() ? changedAt(path) : old->second});
  }
  return watched;
}

DocumentInfo Loader::describe() const {
  DocumentInfo info = document_->info();
  info.path = path_;
  ContentHash files;
  for (const Watched& file : watched_) {
    files.add(std::span(file.path.native()));
    files.add(static_cast<double>(file.time.time_since_epoch().count()));
  }
  info.files = files.digits();
  info.opened = openedCount_;
  return info;
}

/// False, with the error noted, when it stays with what was open.
bool Loader::openNow(const std::string& path, bool again) {
  Reporter reporter(*this);
  reporter.report("opening", 0, 0);
  // Whatever is wrong with a file that was open, it is tried again when one of its parts changes.
  std::vector<std::filesystem::path> files{path};
  if (document_ && path == path_)
    files = document_->files();
  watched_ = look(files);
  auto document = open_(path, reporter);
  auto goesOn = Result<std::string>("");
  if (document && document_ && again)
    goesOn = (*document)->goOnFrom(*document_, reporter);
  if (!goesOn)
    document = tl::unexpected<Error>(goesOn.error());
  std::optional<DocumentInfo> info;
  std::uint64_t memory = 0;
  if (document) {
    // What changed while it was read is news.
    watched_ = look((*document)->files(), watched_);
    document_ = std::move(*document);
    ++openedCount_;
    info = describe();  // before the lock: the window never waits for it
    info->path = path;
    memory = info->snapshotMemory;
    firstTime_ = info->firstTime;
  }
  std::optional<LoadedScene> before;  // freed without the lock
  const std::lock_guard lock(mutex_);
  path_ = path;
  if (!document) {
    if (document.error().code != ErrorCode::kCancelled)
      state_.error = document.error();
    return false;
  }
  state_.error.reset();
  if (!goesOn->empty())
    state_.message = *std::move(goesOn);
  ring_.setLimit(memory);
  opened_.swap(info);
  loaded_.swap(before);
  ++changes_;
  return true;
}

void Loader::changeNow(const DocumentChange& what) {
  if (!document_)
    return;
  if (!what) {
    frozen_ = document_->frozen();
    if (!frozen_)
      frozen_ = document_;
    return;
  }
  Reporter reporter(*this);
  std::vector<Watched> news;  // that others wrote, to be read again after this
  std::ranges::copy_if(watched_, std::back_inserter(news),
                       [](const Watched& file) { return changedAt(file.path) != file.time; });
  auto done = what(*document_, reporter);
  watched_ = look(document_->files(), news);  // what it wrote itself is no news
  std::optional<DocumentInfo> info = describe();
  const std::lock_guard lock(mutex_);
  opened_.swap(info);
  if (!done) {
    state_.error = done.error();
    return;
  }
  state_.error.reset();
  if (!done->empty())
    state_.message = std::move(*done);
  ++changes_;
}

void Loader::checkNow(std::unique_lock<std::mutex>& lock) {
  working_ = true;
  lock.unlock();
  Reporter reporter(*this, disturbed_);
  document_->check(reporter);
  const bool checked = document_->checked();
  std::optional<DocumentInfo> info = describe();
  lock.lock();
  working_ = false;
  unchecked_ = !checked;
  if (checked)
    opened_.swap(info);
  ++changes_;
}

void Loader::loadNow(double time) {
  Reporter reporter(*this);
  SceneRequest request{.time = time, .openGl = openGl_};
  bool seeks = false;
  {
    const std::lock_guard lock(mutex_);
    time_ = time;
    seeks = !playing_;
    request.moving = playing_ && hurries();
  }
  if (seeks && document_->coarseHelps(time)) {
    SceneRequest sooner = request;
    sooner.coarse = true;
    deliver(document_->sceneAt(sooner, reporter), time, true);
  }
  if (overtaken_)
    return;
  const auto begun = SteadyClock::now();
  auto scene = document_->sceneAt(request, reporter);
  const std::chrono::duration<double> spent = SteadyClock::now() - begun;
  if (scene && !request.moving) {
    const std::lock_guard lock(mutex_);
    wholeSeconds_ = spent.count();
  }
  deliver(std::move(scene), time, false);
}

void Loader::deliver(Result<ViewScene> scene, double time, bool coarse) {
  std::optional<LoadedScene> loaded;  // what was there before is freed without the lock
  if (scene)
    loaded = LoadedScene{std::make_shared<const ViewScene>(std::move(*scene)), time, coarse};
  std::vector<SnapshotRing::Held> gone;
  const std::lock_guard lock(mutex_);
  ++changes_;
  if (loaded) {
    if (!coarse && !wantedPath_ && wantedChanges_.empty())
      gone = ring_.add(time, loaded->scene, ahead_);
    loaded_.swap(loaded);
    if (std::exchange(errorIsOfScene_, false))
      state_.error.reset();
  } else if (scene.error().code != ErrorCode::kCancelled) {
    state_.error = scene.error();
    errorIsOfScene_ = true;
  }
}

}  // namespace volute
