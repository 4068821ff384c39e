// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/line_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <string_view>

#include "volute/base/read_text.hpp"
#include "volute/io/table.hpp"

namespace volute {
namespace {

enum LineColumn : std::size_t {
  kX0,
  kY0,
  kZ0,
  kX1,
  kY1,
  kZ1,  // ends
  kX,
  kY,
  kZ,
  kDx,
  kDy,
  kDz,  // a point and a direction
  kDepth,
  kTransmittance,
  kDensity,
  kValue,
  kSigma,
  kFrame,
  kTime
};

std::vector<TableColumn> lineColumns() {
  std::vector<TableColumn> columns;
  for (const std::string_view name : {"x0", "y0", "z0", "x1", "y1", "z1", "x", "y", "z"})
    columns.push_back({name, "m"});
  for (const std::string_view name : {"dx", "dy", "dz"}) columns.push_back({name, "m"});
  columns.insert(columns.end(), {{"optical_depth"},
                                 {"transmittance", "1", {"transmission"}},
                                 {"optical_density", "", {"absorbance"}},
                                 {"value"},
                                 {"sigma"},
                                 {"frame"},
                                 {"time", "s", {"t"}}});
  return columns;
}

/// Reads the rows of one file.
class LineReader {
 public:
  explicit LineReader(const std::string& file) : file_(file), table_(file, lineColumns(), {}) {}

  Result<LineFile> read(std::string_view text);

 private:
  Status checkNames();
  Status checkSigns();
  void checkDark();
  void checkPercent();
  Status readRow();
  Result<Segment> line() const;
  Status readValue(LineMeasurement& one) const;
  Result<LineFrame*> frame();

  bool has(LineColumn first, LineColumn last) const {
    bool all = true;
    for (std::size_t i = first; i <= last; ++i) all = all && table_.has(i);
    return all;
  }

  std::string file_;
  TableReader table_;
  bool checked_ = false;
  LineColumn quantity_ = kValue;
  LineFile lines_;
  std::map<double, LineFrame> frames_;
};

Status LineReader::checkNames() {
  checked_ = true;
  if (has(kX0, kZ1) == has(kX, kDz)) {
    return fail(ErrorCode::kInvalidData,
                "{}: expected columns with the ends of lines, x0, y0, z0, x1, y1, z1, or with a "
                "point and a direction, x, y, z, dx, dy, dz",
                file_);
  }
  int quantities = 0;
  for (const LineColumn column : {kDepth, kTransmittance, kDensity, kValue}) {
    if (!table_.has(column))
      continue;
    quantity_ = column;
    ++quantities;
  }
  if (quantities != 1) {
    return fail(ErrorCode::kInvalidData,
                "{}: expected one column of optical_depth, transmittance, optical_density and "
                "value; there are {}",
                file_, quantities);
  }
  if (table_.has(kFrame) && table_.has(kTime))
    return fail(ErrorCode::kInvalidData, "{}: both frame and time; expected one of them", file_);
  lines_.opticalDepths = quantity_ != kValue;
  lines_.hasSigma = table_.has(kSigma);
  lines_.hasTimes = table_.has(kTime);
  return {};
}

Result<Segment> LineReader::line() const {
  const bool ends = table_.has(kX0);
  std::array<double, 6> place{};
  for (std::size_t i = 0; i < 6; ++i) {
    VOLUTE_ASSIGN(place[i], table_.number((ends ? kX0 : kX) + i));
  }
  const Vec3 from(place[0], place[1], place[2]), last(place[3], place[4], place[5]);
  const Vec3 way = ends ? Vec3(last - from) : last;
  if (!(way.norm() > 0)) {
    return fail(ErrorCode::kInvalidData, "{}: {}", table_.where(),
                ends ? "both ends are the same point" : "the direction is 0, 0, 0");
  }
  return Segment{from, way.normalized(), 0,
                 ends ? way.norm() : std::numeric_limits<double>::infinity()};
}

Status LineReader::readValue(LineMeasurement& one) const {
  VOLUTE_ASSIGN(one.value, table_.number(quantity_));
  if (lines_.hasSigma) {
    VOLUTE_ASSIGN(one.sigma, table_.number(kSigma));
    if (!(one.sigma > 0))
      return fail(ErrorCode::kInvalidData, "{}: sigma is {}; expected more than 0", table_.where(),
                  one.sigma);
  }
  if (quantity_ == kDensity)  // a logarithm to base 10
    one.value *= std::numbers::ln10, one.sigma *= std::numbers::ln10;
  if (quantity_ != kTransmittance)
    return {};
  if (lines_.hasSigma)
    one.sigma *= table_.change(kTransmittance).factor;  // in the same unit
  constexpr double kMaxTransmittance = 1.2;             // a lamp that drifts
  if (one.value > kMaxTransmittance) {
    return fail(
        ErrorCode::kInvalidData,
        "{}: transmittance is {:g}; expected 0 to 1, about 1 where there is no smoke: if it "
        "is in percent, name the column 'transmittance [%]'",
        table_.where(), one.value);
  }
  if (!(one.value > 0) && lines_.hasSigma && one.sigma < 1 && one.value >= -3 * one.sigma) {
    one.value = -std::log(one.sigma);  // no light that could be told from none
    one.sigma = 1;
    one.atLeast = true;
    return {};
  }
  if (!(one.value > 0)) {
    return fail(
        ErrorCode::kInvalidData,
        "{}: transmittance is {:g}, which lets no depth be told; expected more than 0 (about "
        "1 where there is no smoke): of a line that is too dark to measure, state the least "
        "that the instrument can tell from dark, as 0.001, or leave the line out; with a column "
        "sigma, 0 is taken as less than that",
        table_.where(), one.value);
  }
  if (lines_.hasSigma)
    one.sigma /= one.value;
  one.value = -std::log(one.value);
  return {};
}

/// The one that the row belongs to.
Result<LineFrame*> LineReader::frame() {
  double key = 0;
  if (table_.has(kFrame)) {
    VOLUTE_ASSIGN(key, table_.whole(kFrame, 0, 1e9));
  } else if (table_.has(kTime)) {
    VOLUTE_ASSIGN(key, table_.number(kTime));
  }
  LineFrame& frame = frames_[key];
  frame.number = static_cast<int>(table_.has(kFrame) ? key : 0);
  frame.time = table_.has(kTime) ? key : 0;
  return &frame;
}

Status LineReader::readRow() {
  if (!checked_)
    VOLUTE_TRY(checkNames());
  LineMeasurement one;
  one.row = table_.line();
  VOLUTE_ASSIGN(one.line, line());
  VOLUTE_TRY(readValue(one));
  VOLUTE_ASSIGN(LineFrame* const own, frame());
  own->lines.push_back(one);
  return {};
}

/// Lines that let no light through.
void LineReader::checkDark() {
  std::size_t dark = 0, all = 0;
  for (const auto& [key, frame] : frames_) {
    all += frame.lines.size();
    dark +=
        static_cast<std::size_t>(std::ranges::count(frame.lines, true, &LineMeasurement::atLeast));
  }
  if (dark > 0)
    lines_.remarks.push_back(
        fmt::format("{}: {} of {} lines let no light through: their depth is -ln(sigma) or more",
                    file_, dark, all));
}

/// A column in percent whose values are none.
void LineReader::checkPercent() {
  if (quantity_ != kTransmittance || table_.change(kTransmittance).factor == 1)
    return;
  constexpr double kMin = 0.012;
  const bool isDark = std::ranges::all_of(frames_, [&](const auto& one) {
    return std::ranges::all_of(one.second.lines, [&](const LineMeasurement& line) {
      return line.value > -std::log(kMin);
    });
  });
  if (isDark)
    lines_.remarks.push_back(
        fmt::format("{}: all transmittances are at most 1.2 percent: are they fractions?", file_));
}

/// Smoke takes light, so that depths below 0 are noise, or of another sign.
Status LineReader::checkSigns() {
  if (!lines_.opticalDepths)
    return {};
  double sum = 0;
  std::size_t rows = 0, negative = 0, below = 0;
  for (const auto& [key, frame] : frames_) {
    for (const LineMeasurement& one : frame.lines) {
      constexpr double kNoise = 0.05;  // of what says no sigma
      sum += one.value;
      ++rows;
      below += one.value < 0 ? 1 : 0;
      negative += one.value < -(lines_.hasSigma ? 3 * one.sigma : kNoise) ? 1 : 0;
    }
  }
  if (negative > 0 && !(sum > 0)) {
    return fail(ErrorCode::kInvalidData,
                "{}: {} of {} optical depths are negative, and so is their mean; expected "
                "-ln(transmittance), which is 0 without smoke and grows with it",
                file_, negative, rows);
  }
  if (negative > 0) {
    lines_.remarks.push_back(
        fmt::format("{}: {} of {} optical depths are negative beyond noise: more light with smoke "
                    "than without; "
                    "extinction is 0 at least, so that they stay unexplained",
                    file_, negative, rows));
  }
  constexpr double kNearlyAll = 0.75;  // noise alone makes half of them negative
  if (negative == 0 && static_cast<double>(below) > kNearlyAll * static_cast<double>(rows)) {
    lines_.remarks.push_back(
        fmt::format("{}: {} of {} optical depths are negative: more light with smoke than without "
                    "(a transmittance above 1); check the light that they are relative to",
                    file_, below, rows));
  }
  return {};
}

Result<LineFile> LineReader::read(std::string_view text) {
  VOLUTE_TRY(readTable(table_, text, [&] { return readRow(); }));
  if (!checked_)
    VOLUTE_TRY(checkNames());
  if (frames_.empty())
    return fail(ErrorCode::kInvalidData, "{}: no line; expected a row of names and one a line",
                file_);
  VOLUTE_TRY(checkSigns());
  checkPercent();
  checkDark();
  for (auto& [key, frame] : frames_) {
    if (lines_.hasTimes)
      frame.number = static_cast<int>(lines_.frames.size());
    lines_.frames.push_back(std::move(frame));
  }
  return std::move(lines_);
}

}  // namespace

Result<LineFile> readLines(const std::filesystem::path& file, std::uint64_t maxMemory) {
  constexpr std::uint64_t kMax = std::uint64_t{1} << 30;
  const auto check = [&](std::uint64_t need) -> Status {
    if (need <= maxMemory)
      return {};
    return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                "{}: its lines need {} MiB, more than the {} MiB allowed", file.string(),
                (need >> 20) + 1, maxMemory >> 20);
  };
  std::error_code unknown;
  if (const auto size = std::filesystem::file_size(file, unknown); !unknown)
    VOLUTE_TRY(check(size));
  VOLUTE_ASSIGN(const auto text, readText(file, kMax));
  // A list that grows takes half as much again while it is moved.
  const auto rows = static_cast<std::uint64_t>(std::ranges::count(text, '\n')) + 1;
  VOLUTE_TRY(check(text.size() + 3 * rows * sizeof(LineMeasurement)));
  return LineReader(file.string()).read(text);
}

}  // namespace volute
