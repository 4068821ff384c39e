// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/clipboard.hpp"

#include <imgui.h>

namespace volute {

void Clipboard::serve(ImGuiIO& io) {
  io.ClipboardUserData = this;
  io.GetClipboardTextFn = [](void* data) {
    auto& own = *static_cast<Clipboard*>(data);
    if (own.get_)
      own.text_ = own.get_();
    return own.text_.c_str();
  };
  io.SetClipboardTextFn = [](void* data, const char* text) {
    auto& own = *static_cast<Clipboard*>(data);
    own.text_ = text;
    if (own.set_)
      own.set_(own.text_);
  };
}

}  // namespace volute
