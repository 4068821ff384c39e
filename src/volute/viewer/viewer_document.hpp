// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>

#include "volute/viewer/document_files.hpp"
#include "volute/viewer/loader.hpp"
#include "volute/viewer/viewer_settings.hpp"

namespace volute {

/// What came from the loader for a frame.
struct DocumentNews {
  bool idle = false;        ///< nothing more is on its way
  bool changed = false;     ///< ViewerDocument::info() is another
  bool another = false;     ///< and of another document, or the same read again
  bool otherTimes = false;  ///< or of other times
  bool scene = false;       ///< ViewerDocument::scene() is another
  /// A person opened it: at this time [s], or at none of their own.
  std::optional<std::optional<double>> begun{};
  std::optional<Result<LoadedScene>> frozen{};  ///< of Loader::requestFrozen()
};

/// The document that is open, as it last said of itself, the snapshot of it that is shown, and the
/// changes on their way to it.
class ViewerDocument {
 public:
  ViewerDocument(OpenDocument open, const ViewerOptions& options)
      : loader_(std::move(open)), files_(options.recent, options.desktop) {}

  /// What is unsaved of the document before is lost. Until the file is open, what is shown stays.
  void open(const std::string& path, std::optional<double> time);

  bool opening() const { return opening_.has_value(); }

  /// Null: nothing is open.
  const DocumentInfo* info() const { return info_ ? &*info_ : nullptr; }

  const LoadedScene* scene() const { return scene_ ? &*scene_ : nullptr; }

  const LoaderState& loading() const { return loading_; }

  /// Why nothing is shown or was done, in the viewer's words; empty: no error.
  const std::string& error() const { return error_; }

  /// The error of the last failure, as it came.
  const std::optional<Error>& failure() const { return failure_; }

  /// The scene cannot be drawn.
  void refuseScene(Error why);

  /// A sentence about what was done last.
  const std::string& message() const { return message_; }

  /// @param failed  it was not done
  void say(std::string message, bool failed = false) {
    message_ = std::move(message);
    failed_ = failed;
  }

  /// Whether message() is of something that failed.
  bool saysFailure() const { return failed_; }

  /// Whether all that was asked of it is done.
  bool idle() const;

  /// Whether take() would give something.
  bool hasNews() const { return loader_.changes() != changes_; }

  /// Nothing: ask again in the next frame.
  std::optional<DocumentNews> take();

  /// Whether changes are on their way.
  bool changing() const { return loading_.busy || !pending_.empty(); }

  /// Changes a parameter, as soon as the loader comes to it.
  void set(const Parameter& parameter, const std::vector<double>& value);

  /// Changes signs and lights, as soon as the loader comes to it.
  void edit(const SceneEdit& edit);

  /// Adds what another file holds.
  void add(const std::string& path);

  void undo();
  void redo();

  /// What all fields are at a place of the snapshot that is shown, once it is known; null until
  /// then.
  const LoadedFields* fieldsAt(const Vec3& place);

  /// How files are named, and which may be written.
  DocumentFiles& files() { return files_; }

  Loader& loader() { return loader_; }

 private:
  void change(std::function<Result<std::string>(Document&, Progress&)> what);
  void setFailure(std::optional<Error> failure);

  Loader loader_;
  LoaderState loading_;
  std::optional<DocumentInfo> info_;
  std::optional<LoadedScene> scene_;
  std::optional<LoadedFields> fields_;                  ///< the last that were read,
  std::optional<Vec3> fieldsAsked_;                     ///< and asked for
  std::map<std::string, std::vector<double>> pending_;  ///< parameters on their way,
  std::map<std::string, std::vector<double>> held_;     ///< and what the document has of them
  int edits_ = 0;                                       ///< that were asked for
  DocumentFiles files_;
  std::string requested_;  ///< the file that is opened
  std::optional<Error> failure_;
  std::optional<Error> sceneFailure_;  ///< why the scene that was loaded last cannot be shown
  std::string error_, message_, lastMessage_;
  bool failed_ = false;                           ///< saysFailure()
  std::optional<std::optional<double>> opening_;  ///< at this time, if a person said so
  int changes_ = 0;
};

/// Asks what to do with what is in no file, before another file is opened or the viewer ends.
class LeaveQuestion {
 public:
  enum class What { kMap, kScene };

  struct Actions {
    /// Whether there is such a thing, but for the first `passed`; it then is what save() saves.
    std::function<bool(What, std::size_t passed)> unsaved;
    std::function<void(What)> save;
    std::function<void(const std::string& path)> open;
  };

  struct Asked {
    std::string path;  ///< empty: the viewer ends
    What what = What::kMap;
    bool saving = false;     ///< it is being written
    std::size_t passed = 0;  ///< of its kind, that a person discarded
  };

  explicit LeaveQuestion(Actions actions) : actions_(std::move(actions)) {}

  /// Opens a file, or ends the viewer (an empty name), at once if all is saved.
  void leaveFor(const std::string& path);

  const Asked* asked() const { return asked_ ? &*asked_ : nullptr; }

  // The answers.
  void save();
  void discard();

  void stay() { asked_.reset(); }

  /// Nothing is on its way any more: goes on where what was saved is, else its error is shown.
  void goOn();

  /// Whether a person wants the viewer to end, and nothing has still to be saved.
  bool ends() const { return ends_; }

 private:
  void go(const std::string& path);

  Actions actions_;
  std::optional<Asked> asked_;
  bool ends_ = false;
};

}  // namespace volute
