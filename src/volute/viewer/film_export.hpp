// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "volute/viewer/view_picture.hpp"

namespace volute {

/// A film that a person asked for.
struct FilmOrder {
  std::string target;  ///< .mp4 or .webm
  int width = 1280, height = 720;
  double rate = 25;               ///< pictures a second
  double begin = 0, end = 0;      ///< [s] of the document
  double speed = 1;               ///< document seconds a film second
  double length = 0;              ///< [s] of the film, in which its times come again; 0: once
  bool turns = false;             ///< the camera goes once around what it looks at
  std::vector<CameraKey> keys{};  ///< its path; empty: it stays
  ViewCamera camera;
  ViewRenderer renderer = ViewRenderer::kAuto;
  bool surfaces = true;
  DisplayLook look{};     ///< whatever the window's becomes
  std::string content{};  ///< stands for the document as it is, and for its files
  /// Where pictures that took long are kept until the film is written, so that one that was stopped
  /// goes on where it was; empty: nowhere.
  std::filesystem::path folder{};
  double slow = 0.1;  ///< [s] from which on a picture is kept

  int frames() const;
  double timeOf(int frame) const;  ///< [s] of the document
  ViewCamera cameraOf(int frame) const;
  std::filesystem::path pictureOf(int frame) const;  ///< where it is kept

 private:
  std::string key() const;  ///< of all that its pictures depend on
};

/// Makes a film while the window goes on: the window's thread draws a picture at a time, as the
/// scenes of its times arrive, another one encodes. Needs the context that it was made in.
class FilmExport {
 public:
  [[nodiscard]] static Result<std::unique_ptr<FilmExport>> begin(const FilmOrder& order,
                                                                 const PictureMakers& makers);

  /// Unless finished() said so, no file appears.
  ~FilmExport();
  FilmExport(const FilmExport&) = delete;
  FilmExport& operator=(const FilmExport&) = delete;

  /// The scene of which time [s] it waits for; nothing once all pictures are drawn.
  std::optional<double> wantedTime() const;

  /// Goes on as far as it can without waiting. `scene` is that of wantedTime(), or null.
  [[nodiscard]] Status step(const std::shared_ptr<const ViewScene>& scene);

  /// Whether the file is there.
  bool finished() const;

  double share() const;  ///< 0..1

  /// By what it took so far [s]; nothing where that says little yet.
  std::optional<double> secondsLeft() const;

  /// Of the pictures that an earlier one left.
  int resumed() const { return resumed_; }

  /// Whether some of its pictures are kept.
  bool keeps() const;

  /// Remark of a picture that lacked something; empty: none did.
  const std::string& remark() const { return remark_; }

  const FilmOrder& order() const { return order_; }

 private:
  FilmExport(const FilmOrder& order, ViewPicture picture);

  void encode();
  bool takeKept();
  void push(Image image, bool slow);
  Status failure() const;

  FilmOrder order_;
  ViewPicture picture_;
  GlTexture colors_;
  GlFramebuffer frame_;
  int next_ = 0;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::string remark_;
  bool drawing_ = false;
  std::chrono::steady_clock::time_point drawnFrom_{};
  int resumed_ = 0;

  mutable std::mutex mutex_;
  std::condition_variable wake_;

  /// A picture on its way to the encoder; an empty one is in its file.
  struct Waiting {
    Image image;
    int frame = 0;
    bool keep = false;
  };

  std::deque<Waiting> waiting_;
  bool all_ = false, ends_ = false, finished_ = false;
  int encoded_ = 0;
  std::optional<Error> error_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace volute
