// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/base/plain_number.hpp"

namespace volute {

Report& Report::add(std::string_view key, nlohmann::ordered_json value, std::string text) {
  json_[std::string(key)] = std::move(value);
  if (text.empty())
    return *this;
  std::string label(key);
  std::ranges::replace(label, '_', ' ');
  lines_.push_back({std::move(label), std::move(text)});
  return *this;
}

Report& Report::add(std::string_view key, double value) {
  return add(key, jsonNumber(value), fmt::format("{:.6g}", value));
}

Report& Report::add(std::string_view key, std::string_view value) {
  return add(key, std::string(value), std::string(value));
}

std::string Report::text() const {
  std::size_t width = 0;
  for (const Line& line : lines_) width = std::max(width, line.label.size());
  std::string text;
  // No name with a line's end in it can begin what looks like an entry of its own.
  for (const Line& line : lines_) {
    text += fmt::format("{:<{}}  ", line.label, width);
    for (std::size_t i = 0; i < line.text.size(); ++i) {
      text += line.text[i];
      if (line.text[i] == '\n' && i + 1 < line.text.size() && line.text[i + 1] != ' ' &&
          line.text[i + 1] != '\n')
        text.append(width + 2, ' ');
    }
    text += '\n';
  }
  return text;
}

std::string bytesText(std::uint64_t bytes) {
  if (bytes < 10000)
    return fmt::format("{} bytes", bytes);
  constexpr const char* kUnits[] = {"kB", "MB", "GB", "TB", "PB", "EB"};
  double value = static_cast<double>(bytes) / 1000;
  int unit = 0;
  for (; value >= 999.5 && unit < 5; ++unit) value /= 1000;
  return fmt::format("{:.3g} {}", value, kUnits[unit]);
}

std::string vectorText(const Vec3& v) {
  return fmt::format("{}, {}, {}", plainNumber(v.x()), plainNumber(v.y()), plainNumber(v.z()));
}

nlohmann::ordered_json vectorJson(const Vec3& v) {
  return {jsonNumber(v.x()), jsonNumber(v.y()), jsonNumber(v.z())};
}

nlohmann::ordered_json boxJson(const Box3& box) {
  return {vectorJson(box.min), vectorJson(box.max)};
}

std::string boxText(const Box3& box) {
  return fmt::format("{}  to  {} m", vectorText(box.min), vectorText(box.max));
}

void ValueRange::add(std::span<const float> values) {
  count += values.size();
  for (const float value : values) {
    if (!std::isfinite(value)) {
      ++notFinite;
      continue;
    }
    zeros += value == 0;
    minimum = std::min<double>(minimum, value);
    maximum = std::max<double>(maximum, value);
  }
}

void ValueRange::addTo(Report& report) const {
  const double share = static_cast<double>(zeros) / static_cast<double>(count);
  report.add("minimum", minimum)
      .add("maximum", maximum)
      .add("zero_share", jsonNumber(share), fmt::format("{:.1f} %", 100 * share))
      .add("not_finite", notFinite, notFinite ? fmt::format("{} values", notFinite) : "");
}

}  // namespace volute
