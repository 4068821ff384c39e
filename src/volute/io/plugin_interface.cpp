// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/plugin_interface.hpp"

/// Of each plug-in that reads or writes files: of which build it is.
extern "C" const char* volutePluginInterface() {
  return volute::kPluginInterface;
}
