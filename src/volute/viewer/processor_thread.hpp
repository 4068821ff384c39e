// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "volute/viewer/view_scene.hpp"

namespace volute {

/// A picture to be taken by the processor.
struct ProcessorJob {
  ProcessorPicture take;
  Camera camera;
  int number = 0;    ///< the asker's own
  double scale = 1;  ///< likewise
};

/// A picture as a texture holds it.
struct PictureTexels {
  int width = 0, height = 0;
  std::vector<float> rgba{};  ///< light, and an optical depth that nothing is seen through
};

struct ProcessorResult {
  Result<PictureTexels> picture;
  int number = 0;
  double scale = 1;
  double seconds = 0;  ///< that it took
};

/// Takes pictures beside the window's thread, one at a time.
class ProcessorThread {
 public:
  ProcessorThread();
  ~ProcessorThread();
  ProcessorThread(const ProcessorThread&) = delete;
  ProcessorThread& operator=(const ProcessorThread&) = delete;

  /// Instead of one that has not begun.
  void request(ProcessorJob job);

  /// Stops the one that runs, if it is of another number, and forgets it.
  void stopUnless(int number);

  /// Whether one runs or waits.
  bool busy() const;

  /// What was finished since the last call.
  std::optional<ProcessorResult> take();

 private:
  class Stop;
  void work();

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::atomic<bool> ends_ = false, stops_ = false;  ///< changed with the lock
  std::optional<ProcessorJob> waiting_;
  std::optional<int> running_;
  std::optional<ProcessorResult> done_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace volute
