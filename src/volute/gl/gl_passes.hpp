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
  /// Does `work`, notes when the device began and ended it, and gives what it gives.
  template <class Work>
  decltype(auto) run(std::string name, Work&& work) {
    return run(std::move(name), {}, std::forward<Work>(work));
  }

  template <class Work>
  decltype(auto) run(std::string name, std::string media, Work&& work) {
    const Running running(*this, std::move(name), std::move(media));
    return work();
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

  /// Notes the end when it ends.
  class Running {
   public:
    Running(GlPasses& passes, std::string name, std::string media)
        : passes_(passes), pair_{std::move(name), std::move(media), stamp(), {}} {}

    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;

    ~Running() {
      pair_.end = stamp();
      passes_.open_.push_back(std::move(pair_));
    }

   private:
    GlPasses& passes_;
    Pair pair_;
  };

  static GlQuery stamp();

  std::vector<Pair> open_;
  std::vector<GlPassTime> times_;
};

}  // namespace volute
