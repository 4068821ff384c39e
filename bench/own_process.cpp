// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/own_process.hpp"

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "volute/base/process_usage.hpp"

namespace volute::bench {

Result<Outcome> measured(const std::function<Result<double>()>& step) {
  constexpr double kMegabyte = 1 << 20;
  int ends[2];
  if (::pipe(ends) != 0)
    return fail(ErrorCode::kIo, "cannot make a pipe to another process");
  const pid_t child = ::fork();
  if (child < 0)
    return fail(ErrorCode::kIo, "cannot start another process");
  if (child == 0) {
    Outcome outcome;
    // What is free would be taken again without growth, and the peak of the process that this one
    // was forked from is not its own.
    ::malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << 5;
    const double before = static_cast<double>(peakMemoryBytes()) / kMegabyte;
    const auto value = step();
    outcome.value = value.value_or(0);
    if (!value)
      value.error().message.copy(outcome.problem, sizeof outcome.problem - 1);
    outcome.seconds = cpuSeconds();
    outcome.megabytes = static_cast<double>(peakMemoryBytes()) / kMegabyte;
    outcome.growth = outcome.megabytes - before;
    ::_exit(::write(ends[1], &outcome, sizeof outcome) == sizeof outcome ? 0 : 1);
  }
  ::close(ends[1]);
  Outcome outcome;
  const bool whole = ::read(ends[0], &outcome, sizeof outcome) == sizeof outcome;
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  if (!whole)
    return fail(ErrorCode::kIo, "the process of a step ended early");
  if (outcome.problem[0] != 0)
    return fail(ErrorCode::kUnsupported, "{}", outcome.problem);
  return outcome;
}

}  // namespace volute::bench
