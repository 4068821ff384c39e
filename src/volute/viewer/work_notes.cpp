// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/work_notes.hpp"

#include <fmt/format.h>

#include "volute/viewer/language.hpp"

namespace volute {
namespace {

constexpr double kBlink = 0.4;  ///< [s] of work that nothing need be said of
constexpr double kStale = 0.5;  ///< [s]
constexpr std::chrono::seconds kToast{6};

std::string timeLeft(double seconds) {
  if (seconds < 1)
    return "";
  return seconds < 100 ? fmt::format(fmt::runtime(tr(", {:.0f} s left")), seconds)
                       : fmt::format(fmt::runtime(tr(", {:.0f} min left")), seconds / 60);
}

}  // namespace

/// How long it has been so [s]; 0 where it is not.
double WorkNotes::lasting(bool is, std::optional<Clock::time_point>& since) {
  if (!is) {
    since.reset();
    return 0;
  }
  if (!since)
    since = Clock::now();
  return std::chrono::duration<double>(Clock::now() - *since).count();
}

void WorkNotes::update(const Seen& seen, const std::string& message) {
  work_ = {};
  const double working = lasting(seen.loads || seen.draws, workingSince_);
  work_.stale = lasting(seen.late, staleSince_) > kStale;
  if (working < kBlink && seen.shown) {
    // Nothing is said yet.
  } else if (seen.loads) {
    work_.text = seen.stage.empty() ? std::string(tr("loading")) : trName(seen.stage);
    work_.share = seen.loaded;
  } else if (seen.draws) {
    work_.text = fmt::format(fmt::runtime(tr("drawing, {:.0f} %{}")), 100 * seen.drawn.share,
                             timeLeft(seen.drawn.secondsLeft));
    work_.share = seen.drawn.share;
    work_.stops = seen.shown;
  }
  if (seen.report && work_.text.empty()) {
    work_.text = tr("writing the report") + timeLeft(seen.reportLeft.value_or(0));
    work_.share = *seen.report;
  }
  if (work_.stale && work_.text.empty())
    work_.text = seen.lack;
  if (message != toasted_) {
    toast_ = toasted_ = message;
    toastUntil_ = Clock::now() + kToast;
  }
  if (toastUntil_ && Clock::now() > *toastUntil_) {
    toastUntil_.reset();
    toast_.clear();
  }
}

}  // namespace volute
