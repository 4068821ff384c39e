// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/clipboard.hpp"

#include <algorithm>

#include "volute/viewer/imgui_spellings.hpp"

namespace volute {

const char* Clipboard::get(Clipboard& own) {
  if (own.get_)
    own.text_ = own.get_();
  if (imgui::editsNumber(*ImGui::GetCurrentContext()))
    std::ranges::replace(own.text_, ',', '.');
  return own.text_.c_str();
}

void Clipboard::set(Clipboard& own, const char* text) {
  own.text_ = text;
  if (own.set_)
    own.set_(own.text_);
}

void Clipboard::serve() {
  imgui::useClipboard<Clipboard, &Clipboard::get, &Clipboard::set>(*this);
}

}  // namespace volute
