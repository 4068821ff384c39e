// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <set>

#include "volute/viewer/film_export.hpp"
#include "volute/viewer/timeline.hpp"
#include "volute/viewer/viewer_document.hpp"

namespace volute {

/// Which time is shown, which times the loader is asked for, and the film that is made of them.
class Playback {
 public:
  explicit Playback(ViewerDocument& document) : document_(document) {}

  Timeline& timeline() { return timeline_; }

  const Timeline& timeline() const { return timeline_; }

  /// Another document begins here, whose times are not known yet [s].
  void begin(double time);

  /// The frames of the document. `another`: the time that was asked for may be there only now.
  void setFrames(const DocumentInfo& info, bool another);

  /// Asks for the time that is to be shown, and while it plays for those that follow.
  void request();

  /// Times that a person wants to find again, ascending [s].
  const std::set<double>& marks() const { return marks_; }

  /// Where the timeline is: sets one, or removes the one that is there.
  void toggleMark();

  /// To the next mark of this side: 1 or -1.
  void seekMark(int side);

  /// A frame of so many seconds showed the picture of this time [s].
  void noteShown(double seconds, double time);

  /// Frames of the document that are shown a second while it plays; 0: not known yet.
  double shownRate() const { return shownRate_; }

  /// What a picture may take while it plays: its share of the time until the next one [s].
  double budget(double most) const;

  /// Of the document as it is now, whatever becomes of it.
  void beginFilm(const FilmOrder& order, const PictureMakers& makers);

  /// The pictures that took long stay: the same film goes on with them.
  void cancelFilm();

  const FilmExport* film() const { return film_.get(); }

  /// Why there is none, until the next one begins; empty: nothing failed.
  const std::string& filmFailure() const { return filmFailure_; }

  /// Takes the scene that the loader opened for a film.
  void takeFilmScene(Result<LoadedScene> scene);

  /// @param picture  says who draws
  void goOnWithFilm(const ViewPicture& picture);

 private:
  void endFilm(std::string message);
  void failFilm(std::string why);

  ViewerDocument& document_;
  Timeline timeline_;
  double requested_ = 0;  ///< the time that the loader was asked for
  bool played_ = false;   ///< in the last frame
  std::set<double> marks_;
  double shownTime_ = 0, counting_ = 0, shownRate_ = 0;
  int shownCount_ = 0;
  std::unique_ptr<FilmExport> film_;
  std::string filmFailure_;
  std::optional<double> filmAsked_;                 ///< the time that the loader was asked for it
  std::optional<Result<LoadedScene>> filmScene_{};  ///< the last that came for it
};

}  // namespace volute
