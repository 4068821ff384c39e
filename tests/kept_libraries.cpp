// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

/// Part of what uses OpenGL, under AddressSanitizer: libraries stay once they are there. Mesa's
/// drivers keep memory in variables of theirs, and where nobody sees these any more it counts as
/// leaked.
extern "C" int dlclose(void*) {
  return 0;
}
