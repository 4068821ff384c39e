// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <sys/types.h>

#include "volute/io/reader_process.hpp"

namespace volute {

namespace detail {
struct ReaderLine;

bool hasReaderHelper();

/// Whether those who wait for a reader's process shall give up.
bool readingIsCancelled();

/// Forks a child that serves; below 0 without a helper.
pid_t startFromHelper(ReaderJob::Make make, const ReaderLine& line);
}  // namespace detail

/// While it lives, processes that read files of strangers are forked from a small process that was
/// made with it: they see nothing of this one's memory, find no lock that another thread held, and
/// start as fast however large this one has grown. Make it at the beginning of a program, before
/// threads; without one, readers are forked from this process. `cancelled` is asked a few times a
/// second while one reads, from any thread: whether to give up.
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
