// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>

#include "volute/io/reader_job.hpp"

namespace volute::detail {

/// The exit code of a reader's process that had too few descriptors to begin.
inline constexpr int kNoDescriptors = 97;

/// What the child is given: descriptors, and how much memory it may take beyond what it has.
struct ReaderLine {
  int socket = -1;      ///< requests come and replies go
  int lifeline = -1;    ///< the child ends when the other end closes
  int shared = -1;      ///< memory for values
  int parameters = -1;  ///< of a ReaderJob, as a file
  std::uint64_t memory = 0;
};

/// The job without its function, in a file in memory; below 0 where there is no memory.
int writeReaderParameters(const ReaderJob& job);

/// The life of a reader's process: makes what serves, gives all rights up, serves until the other
/// end closes. Call it right after a fork.
[[noreturn]] void serveAsReader(ReaderJob::Make make, const ReaderLine& line);

/// Serves a reader without confinement.
[[noreturn]] void serveUnconfined(const ReaderJob::Serve& serve, const ReaderLine& line);

}  // namespace volute::detail
