// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

// The single definition of the version; CMake reads it from here. Before 1.0 a new minor version
// may change the API (docs/install.md). Files have their own version (docs/format.md).
#define VOLUTE_VERSION_MAJOR 0
#define VOLUTE_VERSION_MINOR 2
#define VOLUTE_VERSION_PATCH 0

#define VOLUTE_VERSION_TEXT_(major, minor, patch) #major "." #minor "." #patch
#define VOLUTE_VERSION_TEXT(major, minor, patch) VOLUTE_VERSION_TEXT_(major, minor, patch)
/// "0.2.0"
#define VOLUTE_VERSION \
  VOLUTE_VERSION_TEXT(VOLUTE_VERSION_MAJOR, VOLUTE_VERSION_MINOR, VOLUTE_VERSION_PATCH)
