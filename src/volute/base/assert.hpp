// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdio>
#include <cstdlib>

/// For errors of the programmer only; what a user or a file can get wrong is a Result.
/// On in the dev and sanitizer builds.
#ifdef VOLUTE_ASSERTS
#define VOLUTE_ASSERT(condition)                                                             \
  do {                                                                                       \
    if (!(condition)) {                                                                      \
      std::fprintf(stderr, "%s:%d: assertion failed: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                          \
    }                                                                                        \
  } while (false)
#else
#define VOLUTE_ASSERT(condition) ((void)0)
#endif
