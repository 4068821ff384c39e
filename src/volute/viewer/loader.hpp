// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "volute/viewer/document.hpp"
#include "volute/viewer/snapshot_ring.hpp"

namespace volute {

/// The state of the loader.
struct LoaderState {
  bool busy = false;
  std::string stage;              ///< what it does
  double share = 0;               ///< 0..1; negative when nobody knows
  std::optional<Error> error{};   ///< the last one, until something succeeds
  std::string message;            ///< what was done last
  std::vector<double> decoded{};  ///< times whose snapshots are kept, ascending [s]
};

/// A loaded snapshot.
struct LoadedScene {
  std::shared_ptr<const ViewScene> scene;
  double time = 0;
  bool coarse = false;
};

/// The values of all fields at a point and time [s].
struct LoadedFields {
  Vec3 place = Vec3::Zero();
  double time = 0;
  Result<std::vector<PlaceFields>> fields{};
};

/// What has come since the viewer last looked.
struct LoaderNews {
  LoaderState state;
  bool idle = false;  ///< nothing is left to be done: `opened` and `loaded` are the last for now
  std::optional<DocumentInfo> opened{};  ///< a document, or one that has changed
  std::optional<LoadedScene> loaded{};
  std::optional<Result<LoadedScene>> frozen{};  ///< of requestFrozen()
  std::optional<LoadedFields> fields{};         ///< of requestFields()
};

/// Something to be done with the document that is open. Says in a sentence what was done, or
/// nothing.
using DocumentChange = std::function<Result<std::string>(Document&, Progress&)>;

/// Opens documents and their snapshots in a thread of its own, so that the picture never waits.
/// Requests that are overtaken by newer ones are dropped, the one that runs is cancelled. Opens the
/// same file again if one of its files changes on disk, with what was changed of it; looks every
/// half second, between two requests.
class Loader {
 public:
  explicit Loader(OpenDocument open);
  ~Loader();
  Loader(const Loader&) = delete;
  Loader& operator=(const Loader&) = delete;

  /// Opens a file instead of what is open, and loads its first picture at `time`, or else at
  /// DocumentInfo::firstTime.
  void open(std::string path, std::optional<double> time);

  /// Loads another snapshot, which is there at once if it was kept; the newest request counts. A
  /// coarse one comes first where that helps, unless `ahead` says that the document is played: the
  /// times that are wanted next, in order, which are loaded while there is nothing else to do.
  /// Where whole ones are too slow for the `period` [s] that each is shown, they are provisional;
  /// one that rests is whole in the end.
  void request(double time, std::vector<double> ahead = {}, double period = 0);

  /// Says which times are wanted next, as request() does.
  void prepare(std::vector<double> ahead, double period = 0);

  /// Counts what news() would tell.
  int changes() const { return changes_; }

  /// Says who draws, of which SceneRequest tells documents. Loads the snapshot again if OpenGL
  /// draws from now on.
  void setOpenGl(bool draws);

  /// Does this with the document, then loads its snapshot again. Changes run in order; one that has
  /// not begun is replaced by a newer one of the same key.
  void change(const std::string& key, DocumentChange what);

  /// Keeps the document as it is after the changes asked for so far, whatever is changed or opened
  /// later, until thaw(): for jobs that take long. There is one at a time.
  void freeze();

  /// Loads a time of what freeze() keeps, in turn with everything else; news() has it.
  void requestFrozen(const SceneRequest& request);

  void thaw();

  /// Asks what all fields are at a place of the snapshot that is shown, once there is nothing to be
  /// loaded for it; the newest request counts.
  void requestFields(const Vec3& place);

  /// Nothing where the thread is just writing its own down: the window does not wait for a thread
  /// that lets others first (base/thread_priority.hpp), but asks again in its next frame.
  std::optional<LoaderNews> news();

  /// Whether there is nothing that it still has to do.
  bool idle() const;

  /// Gives back what is no longer shown: freeing a large scene takes longer than a frame may.
  void discard(std::shared_ptr<const ViewScene> scene);

 private:
  class Reporter;

  struct Watched {
    std::filesystem::path path;
    std::filesystem::file_time_type time;
  };

  void work();
  void serve(std::unique_lock<std::mutex>& lock);
  bool openNow(const std::string& path, bool again);
  void loadNow(double time);
  void changeNow(const DocumentChange& what);
  void checkNow(std::unique_lock<std::mutex>& lock);
  void loadAhead(std::unique_lock<std::mutex>& lock);
  void loadFrozen(std::unique_lock<std::mutex>& lock);
  void readFields(std::unique_lock<std::mutex>& lock);
  void freeThawed(std::unique_lock<std::mutex>& lock);
  void forgetSnapshots(std::unique_lock<std::mutex>& lock);
  DocumentInfo describe() const;
  static std::vector<Watched> look(const std::vector<std::filesystem::path>& files,
                                   std::span<const Watched> before = {});
  void deliver(Result<ViewScene> scene, double time, bool coarse);
  bool changedOnDisk();
  void freeDiscarded(std::unique_lock<std::mutex>& lock);
  bool wanted() const;
  bool freezes() const;
  bool hurries() const;
  bool mayBeWhole(double time);
  bool idleNow() const;
  void noteRequests();

  OpenDocument open_;
  std::shared_ptr<Document> document_;  // the thread's, as the next four
  std::shared_ptr<Document> frozen_;
  double firstTime_ = 0;  ///< of the document [s]
  std::vector<Watched> watched_;
  std::size_t nextLook_ = 0;  ///< at which of them

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool ends_ = false;
  std::atomic<bool> overtaken_ = false;  ///< ends_, or another path is wanted: what runs stops
  std::atomic<bool> disturbed_ = false;  ///< overtaken_, or anything else is wanted
  SnapshotRing ring_;
  std::vector<double> ahead_;             ///< times that are wanted next
  std::optional<double> loadingAhead_;    ///< which of them is being loaded
  std::optional<double> awaited_;         ///< it is to be shown
  bool playing_ = false;                  ///< the last request had such
  double period_ = 0;                     ///< [s] that each is shown; 0: as long as it takes
  double wholeSeconds_ = 0;               ///< that the last whole snapshot took
  bool triesWhole_ = false;               ///< how long one takes is to be found again
  bool changing_ = false;                 ///< the document is about to be another
  std::atomic<bool> aheadStops_ = false;  ///< what is loaded ahead is given up for something else
  std::atomic<bool> openGl_ = true;
  std::atomic<int> changes_ = 0;
  bool unchecked_ = false;  ///< the document has still to look for damage
  std::optional<std::string> wantedPath_;
  bool again_ = false;  ///< it is what is open, which has changed on disk
  std::optional<double> wantedTime_;
  /// By their keys; one without a function is a freeze().
  std::vector<std::pair<std::string, DocumentChange>> wantedChanges_;
  std::optional<SceneRequest> wantedFrozen_;
  std::optional<Vec3> wantedFields_;
  std::optional<LoadedFields> readFields_;
  bool thaws_ = false;
  std::atomic<bool> frozenStops_ = false;  ///< what is loaded of it is no longer wanted
  std::optional<Result<LoadedScene>> loadedFrozen_;
  int openedCount_ = 0;
  bool working_ = false;
  LoaderState state_;
  bool errorIsOfScene_ = false;  ///< it goes when the next snapshot is there
  std::optional<DocumentInfo> opened_;
  std::optional<LoadedScene> loaded_;
  std::string path_;
  double time_ = 0;
  std::vector<std::shared_ptr<const ViewScene>> discarded_;

  std::thread thread_;  // last: it uses the others
};

}  // namespace volute
