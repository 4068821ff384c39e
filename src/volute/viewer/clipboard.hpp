// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <string>
#include <utility>

namespace volute {

/// Text between the viewer and other programs; without a window it stays in the viewer. It must not
/// move once it serves.
class Clipboard {
 public:
  /// The window's: both are called in its thread.
  void use(std::function<std::string()> get, std::function<void(const std::string&)> set) {
    get_ = std::move(get);
    set_ = std::move(set);
  }

  /// Dear ImGui's text boxes copy to it and paste from it.
  void serve();

 private:
  static const char* get(Clipboard& own);
  static void set(Clipboard& own, const char* text);

  std::function<std::string()> get_;
  std::function<void(const std::string&)> set_;
  std::string text_;
};

}  // namespace volute
