// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>

#include "volute/base/input_file.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/printable.hpp"
#include "volute/base/write_file.hpp"

namespace volute {
namespace {

constexpr const char* kPage = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{0}</title>
<style>
body {{ font: 15px/1.5 sans-serif; max-width: 64em; margin: 2em auto; padding: 0 1em;
  color: #222; }}
table {{ border-collapse: collapse; margin: 1em 0; }}
td, th {{ padding: .2em .8em; text-align: left; vertical-align: top; }}
th {{ border-bottom: 1px solid #888; }}
.numbers td:not(:first-child), .numbers th:not(:first-child) {{ text-align: right; }}
figure {{ margin: 1em 0; }} img {{ max-width: 100%; }}
figcaption {{ font-size: 13px; color: #555; }}
.row {{ display: flex; gap: .5em; margin-bottom: .8em; }}
.row figure {{ margin: 0; flex: 1; }}
.row img {{ width: 100%; image-rendering: pixelated; background: #000; }}
.warning, .advice, .verdict {{ background: #fff3d0; padding: .4em .8em; margin: .3em 0; }}
.verdict {{ background: #eef2ee; border-left: 4px solid #456; font-size: 16px; }}
.advice {{ background: #e3eef9; }}
svg {{ display: block; }}
@page {{ size: A4; margin: 14mm 12mm; }}
@media print {{
  body {{ margin: 0; max-width: none; font-size: 10.5pt; }} .verdict {{ font-size: 11pt; }}
  .part {{ break-before: page; }}
  figure, table, tr, svg, .verdict {{ break-inside: avoid; }}
  h2, h3, figcaption, tr:first-child {{ break-after: avoid; }}
  figure {{ display: inline-block; vertical-align: top; margin: 1mm; }}
  figure img {{ max-height: 108mm; }}
}}
</style></head><body>
<h1>{0}</h1>
{1}</body></html>
)";

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view kLetters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group =
          group << 8 | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? kLetters[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string tableRow(const HtmlRow& cells, const char* tag) {
  std::string html = "<tr>";
  for (const std::string& cell : cells) html += fmt::format("<{0}>{1}</{0}>", tag, cell);
  return html + "</tr>\n";
}

std::string box(const char* kind, const Json& text) {
  return fmt::format("<div class='{}'>{}</div>\n", kind, htmlOf(text));
}

}  // namespace

std::string escapedHtml(const std::string& text) {
  std::string out;
  for (const char c : printable(text)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string textOf(const Json& json, const char* format) {
  if (json.is_number()) {
    const auto value = json.get<double>();  // not 1.234e+04 s
    return std::string_view(format) == "{:.4g}" ? plainNumber(value, 4)
                                                : fmt::format(fmt::runtime(format), value);
  }
  if (json.is_null())
    return "\u2013";
  return json.is_string() ? json.get<std::string>() : json.dump();
}

std::string htmlOf(const Json& json, const char* format) {
  return escapedHtml(textOf(json, format));
}

std::string htmlTable(const HtmlRow& head, const std::vector<HtmlRow>& rows, HtmlAlign align) {
  std::string html = align == HtmlAlign::kNumbers ? "<table class='numbers'>" : "<table>";
  if (!head.empty())
    html += tableRow(head, "th");
  for (const HtmlRow& row : rows) html += tableRow(row, "td");
  return html + "</table>\n";
}

std::string htmlWarnings(const Json& texts) {
  std::string html;
  for (const Json& text : texts) html += box("warning", text);
  return html;
}

std::string htmlAdvice(const Json& text) {
  return text.is_null() ? "" : box("advice", text);
}

Result<std::string> htmlFigure(const std::filesystem::path& png, const std::string& caption) {
  VOLUTE_ASSIGN(const auto file, InputFile::open(png));
  std::vector<std::byte> bytes(file.size());
  VOLUTE_TRY(file.read(0, bytes));
  return fmt::format(
      "<figure><img src='data:image/png;base64,{}' alt='{}'><figcaption>{}</figcaption></figure>\n",
      base64(bytes), escapedHtml(caption), escapedHtml(caption));
}

std::string htmlPictureRow(const std::vector<std::string>& figures) {
  return fmt::format("<div class='row'>{}</div>\n", fmt::join(figures, ""));
}

Status writePage(const std::filesystem::path& file, const std::string& title,
                 const std::string& body) {
  return writeFile(file, fmt::format(kPage, escapedHtml(title), body));
}

}  // namespace volute
