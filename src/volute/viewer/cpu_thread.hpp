// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "volute/viewer/view_camera.hpp"
#include "volute/viewer/view_scene.hpp"

namespace volute {

/// A picture to be taken by the CPU: first quickly, then finer and finer.
struct CpuJob {
  CpuPicture take;
  CpuPicture preview{};  ///< the same sooner, without shadows; empty: there is none
  ViewCamera camera{};
  int width = 0, height = 0;  ///< [pixels] of a picture of scale 1
  double first = 1;           ///< scale of the first picture: of the pixels a side
  double finest = 1;          ///< and of the last one,
  bool refines = true;        ///< where it is to be finer than the first
  bool newCosts = false;      ///< what pictures took before says nothing of these
  bool previewFirst = false;  ///< the first one is a preview
  bool inTiles = true;        ///< a rectangle costs its share
  bool continues = false;     ///< goes on where the last job stopped: all of it is refinement
  int number = 0;             ///< the caller's own, ascending
  double time = 0;            ///< likewise
};

/// A rectangle of a picture as a texture holds it: light, and an optical depth that nothing is seen
/// through.
struct CpuPart {
  int number = 0;
  double time = 0, scale = 1;
  int width = 0, height = 0;                             ///< [pixels] of the whole picture
  int left = 0, top = 0, partWidth = 0, partHeight = 0;  ///< [pixels], of the rectangle
  std::vector<float> rgba{};                             ///< row by row
  bool preview = false;
  bool complete = false;  ///< the last part of its picture
  double seconds = 0;     ///< that the picture took so far
};

/// How far the picture that is being refined has come.
struct CpuProgress {
  bool busy = false;  ///< one is taken, or waits
  double share = 0;   ///< 0..1 of the whole job, by pixels
  double secondsLeft = 0;
};

/// Takes pictures beside the window's thread, one job at a time. What is refined is given up for a
/// newer job, but not the first quick picture of a job: else a film would never show a frame.
/// Pictures that take long come in tiles, the middle first, over what the coarser picture showed.
class CpuThread {
 public:
  /// @param clock  [s] from any origin, by which the cost of pictures is measured; empty: real time
  explicit CpuThread(std::function<double()> clock = {});
  ~CpuThread();
  CpuThread(const CpuThread&) = delete;
  CpuThread& operator=(const CpuThread&) = delete;

  /// Instead of one that has not begun.
  void request(CpuJob job);

  /// Gives up refining; what was delivered stays.
  void stop();

  /// What was finished since the last call, in order; an error ends its job.
  std::vector<Result<CpuPart>> take();

  /// Whether take() has something.
  bool has() const;

  CpuProgress progress() const;

  /// Is called, in the thread, after each delivery.
  void onDelivery(std::function<void()> wake);

 private:
  class Stop;

  struct Costs {  ///< [s] a pixel, of the last pictures
    double fine = 0, preview = 0;
  };

  void work();
  void run(const CpuJob& job);
  /// False if it was stopped.
  bool takePicture(const CpuJob& job, double scale, bool preview);
  void beginPicture(int width, int height);
  void deliver(Result<CpuPart> part);

  std::function<double()> clock_;
  Costs costs_;  ///< the thread's, as the next ones
  int canvasWidth_ = 0, canvasHeight_ = 0;
  std::vector<float> canvas_;  ///< what was delivered last
  bool canvasShown_ = false;   ///< something of it was

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::atomic<bool> ends_ = false, stops_ = false;  ///< changed with the lock
  std::optional<CpuJob> waiting_;
  bool running_ = false, refining_ = false;
  CpuProgress progress_;
  std::deque<Result<CpuPart>> done_;
  std::function<void()> delivered_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace volute
