// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/page.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "volute/base/write_file.hpp"
#include "volute/report/line_plot.hpp"

namespace volute {
namespace {

TEST(Page, ShowsWhatAReportHolds) {
  EXPECT_EQ(htmlOf(0.123456), "0.1235");
  EXPECT_EQ(htmlOf(2, "{:.1f}"), "2.0");
  EXPECT_EQ(htmlOf(jsonNumber(std::numeric_limits<double>::infinity())), "\u2013");
  EXPECT_EQ(htmlOf("a<b & 'c'"), "a&lt;b &amp; &#39;c&#39;");
  EXPECT_EQ(htmlOf(Json{1, 2}), "[1,2]");
  EXPECT_EQ(htmlTable({}, {{"a", "b"}}), "<table><tr><td>a</td><td>b</td></tr>\n</table>\n");
  EXPECT_EQ(htmlTable({"x"}, {{"1"}}, HtmlAlign::kNumbers),
            "<table class='numbers'><tr><th>x</th></tr>\n<tr><td>1</td></tr>\n</table>\n");
  EXPECT_EQ(htmlWarnings(Json::array({"<b>"})), "<div class='warning'>&lt;b&gt;</div>\n");
  EXPECT_EQ(htmlAdvice(Json()), "");
}

TEST(Page, TextHasNoControlCharacters) {
  EXPECT_EQ(escapedHtml("a\x1b[2J<b>\x01"), "a\\u001b[2J&lt;b&gt;\\u0001");
}

TEST(Page, NeedsNoOtherFiles) {
  const auto folder = std::filesystem::path(::testing::TempDir());
  ASSERT_TRUE(writeFile(folder / "dot.png", "abcd"));
  const auto figure = htmlFigure(folder / "dot.png", "a & b");
  ASSERT_TRUE(figure) << figure.error().message;
  EXPECT_NE(figure->find("src='data:image/png;base64,YWJjZA=='"), figure->npos);
  EXPECT_NE(figure->find("<figcaption>a &amp; b<"), figure->npos);
  EXPECT_FALSE(htmlFigure(folder / "missing.png", ""));
  ASSERT_TRUE(writePage(folder / "page.html", "A < B", htmlPictureRow({*figure, "<p>{}</p>"})));
  std::ifstream in(folder / "page.html");
  std::stringstream text;
  text << in.rdbuf();
  EXPECT_NE(text.str().find("<title>A &lt; B</title>"), std::string::npos);
  EXPECT_NE(text.str().find("<p>{}</p></div>\n</body></html>\n"), std::string::npos);
  EXPECT_NE(text.str().find("body { font"), std::string::npos);
}

TEST(LinePlot, LeavesAGapWhereThereIsNoNumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string svg = linePlot("t & u", "x", "y", {0, 1, 2, 3}, {{"<one>", {1, nan, 2, 4}}});
  EXPECT_NE(svg.find("t &amp; u"), svg.npos);
  EXPECT_NE(svg.find("&lt;one&gt;"), svg.npos);
  const auto begin = svg.find("<path d='");
  const auto path = svg.substr(begin, svg.find("' fill='none'") - begin);
  EXPECT_EQ(std::ranges::count(path, 'M'), 2);  // begins anew after the gap
  EXPECT_EQ(std::ranges::count(path, 'L'), 1);
}

}  // namespace
}  // namespace volute
