// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/color_view.hpp"

#include <cstdlib>
#include <map>
#include <memory>
#include <mutex>
#include <string_view>

#include "volute/io/plugin.hpp"

namespace volute {

static constexpr std::string_view kConfigured = "ocio";

bool namesColorView(const std::string& name) {
  return name == "aces" || name == kConfigured || name.starts_with("ocio:");
}

Result<const ViewTransform*> openColorView(const std::string& name) {
  static std::mutex mutex;
  static std::map<std::string, std::unique_ptr<const ViewTransform>> opened;
  const char* configuration = std::getenv("OCIO");
  const std::scoped_lock lock(mutex);
  auto& view = opened[name + '\n' + (configuration ? configuration : "")];
  if (view)
    return view.get();
  VOLUTE_ASSIGN(const ViewPlugin* plugin, loadViewPlugin());
  VOLUTE_ASSIGN(view, name == "aces"
                          ? plugin->aces()
                          : plugin->configured(
                                name == kConfigured ? "" : name.substr(kConfigured.size() + 1)));
  return view.get();
}

}  // namespace volute
