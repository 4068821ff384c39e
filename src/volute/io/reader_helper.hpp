// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <sys/types.h>

#include "volute/io/reader_process.hpp"

namespace volute {

namespace detail {
struct ReaderLine;

bool hasReaderHelper();

/// Whether callers that wait for a reader process should give up.
bool readingIsCancelled();

/// Forks a serving child; negative without a helper.
pid_t startFromHelper(const ReaderJob& job, const ReaderLine& line);
}  // namespace detail

/// While it exists, processes that read untrusted files are forked from a small process created
/// with it: they do not share this process's memory, inherit no locks of other threads, and start
/// equally fast however large this process has grown. Create it at the start of a program, before
/// threads; without one, readers are forked from this process. `cancelled` is polled a few times
/// per second during reading, from any thread, and tells whether to give up.
class ReaderHelper {
 public:
  explicit ReaderHelper(bool (*cancelled)() = nullptr);
  ~ReaderHelper();
  ReaderHelper(const ReaderHelper&) = delete;
  ReaderHelper& operator=(const ReaderHelper&) = delete;

 private:
  pid_t process_ = -1;
};

}  // namespace volute
