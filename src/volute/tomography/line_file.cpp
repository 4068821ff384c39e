// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/line_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "volute/base/read_text.hpp"
#include "volute/io/table_row.hpp"

namespace volute {
namespace {

constexpr std::array<std::string_view, 6> kEnds{"x0", "y0", "z0", "x1", "y1", "z1"};
constexpr std::array<std::string_view, 6> kRay{"x", "y", "z", "dx", "dy", "dz"};
constexpr std::array<std::string_view, 3> kValues{"optical_depth", "transmittance", "value"};

/// Reads the rows of one file.
class LineReader {
 public:
  explicit LineReader(std::string file) : file_(std::move(file)) {}

  Result<LineFile> read(std::string_view text);

 private:
  Status readNames(std::string_view row);
  Status readRow(std::string_view row);
  Result<double> number(std::string_view name) const;
  Result<Segment> line() const;
  Status readValue(LineMeasurement& one) const;
  Result<LineFrame*> frame();

  bool has(std::string_view name) const { return columns_.contains(std::string(name)); }

  std::string where() const { return fmt::format("{}: row {}", file_, row_); }

  std::string file_;
  int row_ = 0;
  std::map<std::string, std::size_t> columns_;
  std::vector<std::string_view> cells_;  // of the row
  bool ends_ = false;
  std::string_view quantity_;
  LineFile lines_;
  std::map<double, LineFrame> frames_;
};

Status LineReader::readNames(std::string_view row) {
  std::vector<std::string> names;
  for (const std::string_view cell : fieldsOf(row)) {
    std::string name = lowerCase(cell);
    if (!columns_.emplace(name, columns_.size()).second)
      return fail(ErrorCode::kInvalidData, "{}: two columns are called '{}'", where(), name);
    names.push_back(name);
  }
  const auto all = [&](const auto& wanted) {
    return std::ranges::all_of(wanted, [&](std::string_view name) { return has(name); });
  };
  ends_ = all(kEnds);
  if (!ends_ && !all(kRay)) {
    return fail(
        ErrorCode::kInvalidData,
        "{}: columns {}; expected the ends of lines, {}, or a point and a direction, {}, in "
        "the first row",
        where(), fmt::join(names, ", "), fmt::join(kEnds, ", "), fmt::join(kRay, ", "));
  }
  const auto values = std::ranges::count_if(kValues, [&](auto name) { return has(name); });
  if (values != 1) {
    return fail(ErrorCode::kInvalidData,
                "{}: columns {}; expected one of optical_depth, transmittance and value, and there "
                "are {}",
                where(), fmt::join(names, ", "), values);
  }
  if (has("frame") && has("time"))
    return fail(ErrorCode::kInvalidData, "{}: both frame and time; expected one of them", where());
  quantity_ = *std::ranges::find_if(kValues, [&](auto name) { return has(name); });
  lines_.opticalDepths = quantity_ != "value";
  lines_.hasSigma = has("sigma");
  lines_.hasTimes = has("time");
  return {};
}

Result<double> LineReader::number(std::string_view name) const {
  const std::string_view cell = cells_[columns_.at(std::string(name))];
  const auto value = finiteNumber(cell);
  if (!value)
    return fail(ErrorCode::kInvalidData, "{}, {}: '{}' is not a finite number", where(), name,
                cell);
  return *value;
}

Result<Segment> LineReader::line() const {
  std::array<double, 6> place{};
  const auto& names = ends_ ? kEnds : kRay;
  for (std::size_t i = 0; i < 6; ++i) {
    VOLUTE_ASSIGN(place[i], number(names[i]));
  }
  const Vec3 from(place[0], place[1], place[2]), last(place[3], place[4], place[5]);
  const Vec3 way = ends_ ? Vec3(last - from) : last;
  if (!(way.norm() > 0)) {
    return fail(ErrorCode::kInvalidData, "{}: {}", where(),
                ends_ ? "both ends are the same point" : "the direction is 0, 0, 0");
  }
  return Segment{from, way.normalized(), 0,
                 ends_ ? way.norm() : std::numeric_limits<double>::infinity()};
}

Status LineReader::readValue(LineMeasurement& one) const {
  VOLUTE_ASSIGN(one.value, number(quantity_));
  if (lines_.hasSigma) {
    VOLUTE_ASSIGN(one.sigma, number("sigma"));
    if (!(one.sigma > 0))
      return fail(ErrorCode::kInvalidData, "{}, sigma: {}; expected more than 0", where(),
                  one.sigma);
  }
  if (quantity_ != "transmittance")
    return {};
  if (!(one.value > 0)) {
    return fail(ErrorCode::kInvalidData,
                "{}, transmittance: {} lets no depth be told; expected more than 0 (about 1 where "
                "there is no smoke)",
                where(), one.value);
  }
  if (lines_.hasSigma)
    one.sigma /= one.value;
  one.value = -std::log(one.value);
  return {};
}

/// The one that the row belongs to.
Result<LineFrame*> LineReader::frame() {
  double key = 0;
  if (has("frame")) {
    VOLUTE_ASSIGN(key, number("frame"));
    constexpr double kMax = 1e9;
    if (key < 0 || key > kMax || key != std::floor(key))
      return fail(ErrorCode::kInvalidData, "{}, frame: {}; expected a whole number from 0 on",
                  where(), key);
  } else if (has("time")) {
    VOLUTE_ASSIGN(key, number("time"));
  }
  LineFrame& frame = frames_[key];
  frame.number = static_cast<int>(has("frame") ? key : 0);
  frame.time = has("time") ? key : 0;
  return &frame;
}

Status LineReader::readRow(std::string_view row) {
  cells_ = fieldsOf(row);
  if (cells_.size() != columns_.size()) {
    return fail(ErrorCode::kInvalidData, "{}: {} values; the first row names {} columns", where(),
                cells_.size(), columns_.size());
  }
  LineMeasurement one;
  one.row = row_;
  VOLUTE_ASSIGN(one.line, line());
  VOLUTE_TRY(readValue(one));
  VOLUTE_ASSIGN(LineFrame* const own, frame());
  own->lines.push_back(one);
  return {};
}

Result<LineFile> LineReader::read(std::string_view text) {
  VOLUTE_TRY(forEachRow(text, [&](std::string_view row, int number) -> Status {
    row_ = number;
    if (row.empty() || row.front() == '#')
      return {};
    return columns_.empty() ? readNames(row) : readRow(row);
  }));
  if (frames_.empty())
    return fail(ErrorCode::kInvalidData, "{}: no line; expected a row of names and one a line",
                file_);
  for (auto& [key, frame] : frames_) {
    if (lines_.hasTimes)
      frame.number = static_cast<int>(lines_.frames.size());
    lines_.frames.push_back(std::move(frame));
  }
  return std::move(lines_);
}

}  // namespace

Result<LineFile> readLines(const std::filesystem::path& file) {
  constexpr std::uint64_t kMax = std::uint64_t{1} << 30;
  VOLUTE_ASSIGN(const auto text, readText(file, kMax));
  return LineReader(file.string()).read(text);
}

}  // namespace volute
