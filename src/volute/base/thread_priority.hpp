// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

namespace volute {

/// From here on this thread, and those that it starts, compute when others do not want to: a
/// window's thread goes first where all cores are busy. Nothing happens where the system has no
/// priorities of threads.
void lowerThreadPriority();

/// The same for the workers of all parallel loops (base/parallel.hpp), whoever begins these: a
/// worker that a window's thread has started would have its priority. For the whole program, and
/// not to be taken back.
void lowerWorkerPriority();

namespace detail {
/// For a worker that begins a part of a parallel loop.
void beginAsWorker();
}  // namespace detail

}  // namespace volute
