// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/thread_priority.hpp"

#ifdef __linux__
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#endif

namespace volute {

void letOthersFirst() {
#ifdef __linux__
  constexpr int kNice =
      5;  // a third of what a busy thread beside it gets; each thread's own on Linux
  const auto thread = static_cast<id_t>(::gettid());
  ::setpriority(PRIO_PROCESS, thread, std::max(kNice, ::getpriority(PRIO_PROCESS, thread)));
#endif
}

}  // namespace volute
