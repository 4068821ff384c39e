// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cluster/rank_streams.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "volute/base/interrupt.hpp"
#include "volute/cluster/cluster.hpp"

namespace volute {
namespace {

int realStandardError = STDERR_FILENO;

bool isOtherRank() {
  const auto launch = launchOfThisProcess();
  return launch && launch->size > 1 && launch->rank > 0;
}

}  // namespace

void silenceOtherRanks() {
  if (!isOtherRank())
    return;
  realStandardError = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  if (const int null = ::open("/dev/null", O_RDWR | O_CLOEXEC); null >= 0) {
    ::dup2(null, STDOUT_FILENO);
    ::dup2(null, STDERR_FILENO);
    ::close(null);
  }
}

void letFirstRankSpeak() {
  for (int i = 0; i < 150 && isOtherRank() && !Interrupt::requested(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

Error errorOfThisRank(Error error) {
  if (isOtherRank()) {
    letFirstRankSpeak();
    if (!Interrupt::requested())
      ::dup2(realStandardError, STDERR_FILENO);
    error.message = fmt::format("rank {}: {}", launchOfThisProcess()->rank, error.message);
    error.statement.clear();
  }
  return error;
}

}  // namespace volute
