// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/base/result.hpp"

// What a program writes that is one of several processes of a launcher: the first speaks for all.

namespace volute {

/// Standard output and standard error of all ranks but the first lead nowhere from here on. Needs
/// no team: it is the first thing that a program does.
void silenceOtherRanks();

/// Where ranks end with an error before they are a team, the launcher ends all as soon as one does:
/// others than the first wait for that a while.
void letFirstRankSpeak();

/// An error that all ranks have is said by the first, whose end ends the others; what is left to
/// say after that is about this machine, and said by its rank.
Error errorOfThisRank(Error error);

}  // namespace volute
