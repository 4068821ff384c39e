// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/sensitivity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/base/plain_number.hpp"
#include "volute/base/write_file.hpp"
#include "volute/io/image_file.hpp"
#include "volute/report/canvas.hpp"
#include "volute/report/page.hpp"

namespace volute {
namespace {

Json endJson(const std::string& name, const FirstLoss& loss) {
  return {{"is", name},
          {"time", loss.any && loss.certain() ? jsonNumber(loss.none) : Json()},
          {"known", knownJson(loss.known)},
          {"share", loss.share}};
}

std::string cellOf(const Json& end) {
  const std::string time = end["time"].is_number() ? htmlOf(end["time"]) + " s"
                           : end["known"] == true  ? "not reached"
                                                   : "<b>not known</b>";
  return time + " (" + htmlOf(end["is"]) + ")";
}

/// Where an end is drawn; nothing where it is not known.
std::optional<double> placeOf(const Json& end, double last) {
  if (end["time"].is_number())
    return end["time"].get<double>();
  return end["known"] == true ? std::optional(last) : std::nullopt;
}

/// One bar an uncertainty, the widest at the top, around the line of the verdict.
class Tornado {
 public:
  Tornado(const Json& sensitivity, double begin, double end) : all_(sensitivity), last_(end) {
    double low = end, high = begin;  // what bars reach
    const auto reach = [&](const Json& one, double unknown) {
      const double place = placeOf(one, end).value_or(unknown);
      low = std::min(low, place);
      high = std::max(high, place);
    };
    for (const Json& row : all_["rows"]) {
      left_ = std::max(left_, 24 + canvasTextWidth(row["name"].get<std::string>()));
      reach(row["first"], begin);
      reach(row["second"], end);
    }
    const double margin = std::max(0.1 * (high - low), 0.01 * (end - begin));
    begin_ = std::max(begin, low - margin);
    end_ = std::min(end, high + margin);
  }

  double width() const { return std::ceil(left_ + kWide + 60); }

  double height() const { return kTop + kRow * static_cast<double>(all_["rows"].size()) + 56; }

  void draw(Canvas& canvas) const {
    const Rgb ink = Rgb::Constant(0.01F), bar(0.05F, 0.22F, 0.6F), pale = Rgb::Constant(0.8F);
    canvas.rect(0, 0, width(), height(), Rgb::Ones());
    canvas.text("ASET of all criteria, by what is uncertain", left_, 12, ink);
    const double bottom = height() - 52;
    for (int i = 0; i <= 5; ++i) {
      const double time = begin_ + (end_ - begin_) * i / 5;
      canvas.rect(x(time), kTop - 4, x(time) + 1, bottom + 5, pale);
      canvas.text(plainNumber(time, 3), x(time), bottom + 9, ink, Canvas::Anchor::kMiddle);
    }
    canvas.text("time [s], interpolated", left_ + kWide / 2, bottom + 30, ink,
                Canvas::Anchor::kMiddle);
    double y = kTop;
    for (const Json& row : all_["rows"]) {
      canvas.text(row["name"].get<std::string>(), left_ - 12, y + 4, ink, Canvas::Anchor::kEnd);
      const auto first = placeOf(row["first"], last_), second = placeOf(row["second"], last_);
      const double from = x(std::min(first.value_or(begin_), second.value_or(end_)));
      const double to = x(std::max(first.value_or(begin_), second.value_or(end_)));
      canvas.rect(from, y, std::max(to, from + 2), y + kRow - 8, bar);
      if (!first || !second)
        canvas.text("not known", left_ + 4, y + 4, ink);
      y += kRow;
    }
    if (const auto base = placeOf(all_["base"], last_))
      canvas.rect(x(*base) - 1, kTop - 6, x(*base) + 1, bottom, Rgb(0.72F, 0.03F, 0.03F));
  }

 private:
  static constexpr double kWide = 560, kTop = 48, kRow = 32;

  double x(double time) const {
    return left_ + kWide * (time - begin_) / std::max(1e-9, end_ - begin_);
  }

  const Json& all_;
  double last_;  // time that is looked at
  double begin_ = 0, end_ = 0, left_ = 0;
};

}  // namespace

std::span<const Variation> variations() {
  static const std::array<Variation, 7> all{
      {{"a depth within 2 % of its limit counts as lost (brief losses between stored times)",
        1 / 0.98, 1},
       {"C 33 % lower", 1, 0.67},
       {"C 33 % higher", 1, 1.33},
       {"mass extinction 9800 of 8700 m2/kg", 9800.0 / 8700, 1},
       {"mass extinction 7600 of 8700 m2/kg", 7600.0 / 8700, 1},
       {"soot yield 25 % larger", 1.25, 1},
       {"soot yield 25 % smaller", 0.75, 1}}};
  return all;
}

Json sensitivityJson(const FirstLoss& base, std::span<const Uncertainty> all) {
  std::vector<Json> rows;
  for (const Uncertainty& one : all) {
    Json row = {{"name", one.name},
                {"first", endJson(one.first, one.atFirst)},
                {"second", endJson(one.second, one.atSecond)},
                {"span", nullptr}};
    if (row["first"]["time"].is_number() && row["second"]["time"].is_number())
      row["span"] =
          std::abs(row["second"]["time"].get<double>() - row["first"]["time"].get<double>());
    rows.push_back(std::move(row));
  }
  // One end that is not reached, or not known, is the widest of all.
  const auto span = [](const Json& row) {
    if (row["span"].is_number())
      return row["span"].get<double>();
    return row["first"]["time"] == row["second"]["time"] ? -1.0 : 1e300;
  };
  std::ranges::stable_sort(rows, std::greater(), span);
  return {{"base", endJson("as in the verdict", base)}, {"rows", Json(std::move(rows))}};
}

Result<std::string> sensitivityPart(const Json& sensitivity, double begin, double end,
                                    const std::filesystem::path& file) {
  const Tornado tornado(sensitivity, begin, end);
  Image image(static_cast<int>(tornado.width()), static_cast<int>(tornado.height()), 3);
  tornado.draw(*imageCanvas(image));
  VOLUTE_TRY(writeImage(file, image));
  SvgCanvas canvas(tornado.width(), tornado.height());
  tornado.draw(canvas);
  std::filesystem::path vector = file;
  VOLUTE_TRY(writeFile(vector.replace_extension(".svg"), canvas.finish()));
  std::vector<HtmlRow> rows;
  for (const Json& row : sensitivity["rows"]) {
    rows.push_back({htmlOf(row["name"]), cellOf(row["first"]), cellOf(row["second"]),
                    row["span"].is_number() ? htmlOf(row["span"]) + " s" : "\u2013"});
  }
  VOLUTE_ASSIGN(const auto figure,
                htmlFigure(file,
                           "The red line is the verdict. Each bar is one uncertainty alone; "
                           "the others are as in the verdict."));
  return "<h2>Sensitivity of the ASET</h2>\n<p>In the verdict, interpolated: " +
         cellOf(sensitivity["base"]) +
         ". The height of the eyes is not varied here: a report of several heights compares "
         "them.</p>\n" +
         htmlTable({"uncertain", "ASET at one end", "at the other", "between them"}, rows) + figure;
}

}  // namespace volute
