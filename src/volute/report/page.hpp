// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/report/json.hpp"

// Pages of results: HTML that needs no other files, made from the structures that are written as
// JSON. All pages have one template and one style sheet.

namespace volute {

/// Text as HTML shows it.
std::string escapedHtml(const std::string& text);

/// A number, a word or a list of a report; a dash for null.
std::string textOf(const Json& json, const char* format = "{:.4g}");
std::string htmlOf(const Json& json, const char* format = "{:.4g}");

/// The cells of a row are HTML.
using HtmlRow = std::vector<std::string>;

enum class HtmlAlign { kText, kNumbers };  ///< numbers: all columns but the first to the right

/// A table with a head, or without where `head` is empty.
std::string htmlTable(const HtmlRow& head, const std::vector<HtmlRow>& rows,
                      HtmlAlign align = HtmlAlign::kText);

/// A box for each of the texts.
std::string htmlWarnings(const Json& texts);
std::string htmlAdvice(const Json& text);

/// A .png file within the page, with a caption.
[[nodiscard]] Result<std::string> htmlFigure(const std::filesystem::path& png,
                                             const std::string& caption);

/// Figures beside each other, of few pixels each, which are shown as such.
std::string htmlPictureRow(const std::vector<std::string>& figures);

/// The file of a page whose title is its first heading, too.
[[nodiscard]] Status writePage(const std::filesystem::path& file, const std::string& title,
                               const std::string& body);

}  // namespace volute
