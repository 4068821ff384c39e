// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "volute/gl/gl_object.hpp"

namespace volute {

/// What the device did, and how long it took.
struct GlPassTime {
  std::string name;
  std::string media;  ///< what it drew: "volume", "fog", "volume + smoke"; empty: none of them
  int times = 0;
  double milliseconds = 0;  ///< on the device, summed
};

/// Times passes by pairs of GL_TIMESTAMP (GL_TIME_ELAPSED is nonsense on llvmpipe).
class GlPasses {
 public:
  /// Does `work` and notes when the device began and ended it.
  template <class Work>
  void run(std::string name, Work&& work) {
    run(std::move(name), {}, std::forward<Work>(work));
  }

  template <class Work>
  void run(std::string name, std::string media, Work&& work) {
    Pair pair{std::move(name), std::move(media), stamp(), {}};
    work();
    pair.end = stamp();
    open_.push_back(std::move(pair));
  }

  /// Adds what has been run since the last call to the sums; waits for the device.
  void collect();

  /// In the order in which they were first run; empties the sums.
  std::vector<GlPassTime> take() {
    collect();
    return std::exchange(times_, {});
  }

  const std::vector<GlPassTime>& times() const { return times_; }

 private:
  struct Pair {
    std::string name, media;
    GlQuery begin, end;
  };

  static GlQuery stamp();

  std::vector<Pair> open_;
  std::vector<GlPassTime> times_;
};

}  // namespace volute
