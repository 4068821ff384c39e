// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <imgui.h>
#include <imgui_internal.h>
#if VOLUTE_HAS_FREETYPE
#include <imgui_freetype.h>
#endif

#include <cstdint>
#include <type_traits>

#include "volute/viewer/viewer_input.hpp"

// What Dear ImGui 1.86, Debian 12's, and later versions spell differently.
namespace volute::imgui {

// Keys.
#if IMGUI_VERSION_NUM >= 18900
using KeyName = ImGuiKey;

inline void setKey(ImGuiIO& io, Key, KeyName name, bool down) {
  io.AddKeyEvent(name, down);
}

inline void setModifiers(ImGuiIO& io, bool shift, bool control) {
  io.AddKeyEvent(ImGuiMod_Shift, shift);
  io.AddKeyEvent(ImGuiMod_Ctrl, control);
}

/// All that was fed is of this frame.
inline void feedAtOnce(ImGuiIO& io) {
  io.ConfigInputTrickleEventQueue = false;
}

inline bool isPressed(KeyName name, bool again = true) {
  return ImGui::IsKeyPressed(name, again);
}
#else
using KeyName = ImGuiKey_;

inline void setKey(ImGuiIO& io, Key key, KeyName name, bool down) {
  io.KeyMap[name] = static_cast<int>(key);
  io.KeysDown[static_cast<int>(key)] = down;
}

inline void setModifiers(ImGuiIO& io, bool shift, bool control) {
  io.KeyShift = shift, io.KeyCtrl = control;
}

inline void feedAtOnce(ImGuiIO&) {}

/// @param again  a key that is held counts again and again
inline bool isPressed(KeyName name, bool again = true) {
  return ImGui::IsKeyPressed(ImGui::GetKeyIndex(name), again);
}
#endif

#if IMGUI_VERSION_NUM >= 19100
constexpr auto kKeepsPopup = ImGuiSelectableFlags_NoAutoClosePopups;
#else
constexpr auto kKeepsPopup = ImGuiSelectableFlags_DontClosePopups;
#endif

/// Whether the keyboard's focus is drawn.
inline bool showsFocus(const ImGuiContext& context) {
#if IMGUI_VERSION_NUM >= 19140
  return context.NavCursorVisible;
#else
  return !context.NavDisableHighlight;
#endif
}

/// Draws the keyboard's focus, and nothing of the mouse until it moves.
inline void showFocus(ImGuiContext& context) {
#if IMGUI_VERSION_NUM >= 19140
  context.NavCursorVisible = context.NavHighlightItemUnderNav = true;
#else
  context.NavDisableHighlight = false, context.NavDisableMouseHover = true;
#endif
}

inline bool lastItemIsDisabled(const ImGuiContext& context) {
#if IMGUI_VERSION_NUM >= 19140
  return (context.LastItemData.ItemFlags & ImGuiItemFlags_Disabled) != 0;
#else
  return (context.LastItemData.InFlags & ImGuiItemFlags_Disabled) != 0;
#endif
}

/// Whether the number of a slider, or of one that is dragged, is being typed.
inline bool editsNumber(const ImGuiContext& context) {
  return context.ActiveId != 0 && context.ActiveId == context.TempInputId;
}

#if VOLUTE_HAS_FREETYPE
/// Letters stand on whole pixels.
inline void useFreeType(ImFontAtlas& fonts) {
#if IMGUI_VERSION_NUM >= 19200
  fonts.SetFontLoader(ImGuiFreeType::GetFontLoader());
  fonts.FontLoaderFlags = ImGuiFreeTypeLoaderFlags_LightHinting;
#else
  fonts.FontBuilderIO = ImGuiFreeType::GetBuilderForFreeType();
  fonts.FontBuilderFlags = ImGuiFreeTypeBuilderFlags_LightHinting;
#endif
}
#endif

/// Of all letters.
inline void setFontScale(float scale) {
#if IMGUI_VERSION_NUM >= 19200
  ImGui::GetStyle().FontScaleMain = scale;
#else
  ImGui::GetIO().FontGlobalScale = scale;
#endif
}

inline ImDrawCallback resetRenderState() {
#if IMGUI_VERSION_NUM >= 19280
  return ImGui::GetPlatformIO().DrawCallback_ResetRenderState;
#else
  return ImDrawCallback_ResetRenderState;
#endif
}

/// By its name in OpenGL.
template <class Id = ImTextureID>
Id textureOf(unsigned name) {
  if constexpr (std::is_pointer_v<Id>)
    return reinterpret_cast<Id>(static_cast<std::uintptr_t>(name));
  else
    return static_cast<Id>(name);
}

/// Text boxes copy to `owner` and paste from it.
/// @param get, set  called with `owner`
template <class Owner, const char* (*get)(Owner&), void (*set)(Owner&, const char*)>
void useClipboard(Owner& owner) {
#if IMGUI_VERSION_NUM >= 19110
  ImGuiPlatformIO& io = ImGui::GetPlatformIO();
  io.Platform_ClipboardUserData = &owner;
  io.Platform_GetClipboardTextFn = [](ImGuiContext*) {
    return get(*static_cast<Owner*>(ImGui::GetPlatformIO().Platform_ClipboardUserData));
  };
  io.Platform_SetClipboardTextFn = [](ImGuiContext*, const char* text) {
    set(*static_cast<Owner*>(ImGui::GetPlatformIO().Platform_ClipboardUserData), text);
  };
#else
  ImGuiIO& io = ImGui::GetIO();
  io.ClipboardUserData = &owner;
  io.GetClipboardTextFn = [](void* data) { return get(*static_cast<Owner*>(data)); };
  io.SetClipboardTextFn = [](void* data, const char* text) {
    set(*static_cast<Owner*>(data), text);
  };
#endif
}

}  // namespace volute::imgui
