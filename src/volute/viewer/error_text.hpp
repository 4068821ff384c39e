// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/base/advice.hpp"

namespace volute {

/// A setting as the control of the viewer that changes it; empty: it has none.
inline std::string controlText(const std::string& setting, const std::string& value) {
  if (setting == "renderer")
    return value == "cpu" ? "\"renderer: CPU\"" : "\"renderer\"";
  return setting == "quantity" ? "\"field holds\"" : "";
}

inline std::string viewerText(const Error& error) {
  return fullText(error, controlText);
}

}  // namespace volute
