// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/printable.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <iterator>

namespace volute {
namespace {

/// The character at the beginning of a text, and its bytes; 0 bytes where they are no UTF-8.
struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 0;
};

Character firstOf(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text[0]);
  if (lead < 0x80)
    return {lead, 1};
  const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes)
    return {};
  std::uint32_t code = lead & (0x7FU >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    const auto next = static_cast<unsigned char>(text[i]);
    if ((next & 0xC0U) != 0x80)
      return {};
    code = code << 6 | (next & 0x3FU);
  }
  constexpr std::uint32_t kMin[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code < 0xE000;
  if (code < kMin[bytes] || code > 0x10FFFF || surrogate)
    return {};
  return {code, bytes};
}

/// Controls of terminals (ESC, CSI, DEL ..), and of the direction of writing.
bool steers(std::uint32_t code) {
  return code < 0x20 || (code >= 0x7F && code < 0xA0) || (code >= 0x200E && code <= 0x200F) ||
         (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
}

std::string cleaned(std::string_view text, std::string_view lineEnd) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const Character first = firstOf(text);
    if (first.bytes == 0) {
      fmt::format_to(std::back_inserter(out), "\\x{:02x}", static_cast<unsigned char>(text[0]));
    } else if (first.code == '\n') {
      out += text.size() > 1 ? lineEnd : "\n";
    } else if (first.code == '\t' || !steers(first.code)) {
      out += text.substr(0, first.bytes);
    } else {
      fmt::format_to(std::back_inserter(out), "\\u{:04x}", first.code);
    }
    text.remove_prefix(first.bytes == 0 ? 1 : first.bytes);
  }
  return out;
}

}  // namespace

void appendUtf8(std::string& text, std::uint32_t code) {
  const auto add = [&](std::uint32_t byte) { text += static_cast<char>(byte); };
  if (code < 0x80) {
    add(code);
  } else if (code < 0x800) {
    add(0xC0 | code >> 6), add(0x80 | (code & 0x3F));
  } else if (code < 0x10000) {
    add(0xE0 | code >> 12), add(0x80 | (code >> 6 & 0x3F)), add(0x80 | (code & 0x3F));
  } else {
    add(0xF0 | code >> 18), add(0x80 | (code >> 12 & 0x3F)), add(0x80 | (code >> 6 & 0x3F));
    add(0x80 | (code & 0x3F));
  }
}

std::string printable(std::string_view text) {
  return cleaned(text, "\n");
}

std::string printableMessage(std::string_view text) {
  return cleaned(text, "\n    ");
}

std::string asUtf8(std::string_view text) {
  std::string_view rest = text;
  while (!rest.empty()) {
    const Character first = firstOf(rest);
    if (first.bytes == 0)
      break;
    rest.remove_prefix(first.bytes);
  }
  if (rest.empty())
    return std::string(text);
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      out += c;
    } else {
      out += static_cast<char>(0xC0U | (byte >> 6U));
      out += static_cast<char>(0x80U | (byte & 0x3FU));
    }
  }
  return out;
}

}  // namespace volute
