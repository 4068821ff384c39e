// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

namespace volute {

/// From here on this thread, and those that it starts, compute when others do not want to: a
/// window's thread goes first where all cores are busy. Nothing happens where the system has no
/// priorities of threads.
void letOthersFirst();

}  // namespace volute
