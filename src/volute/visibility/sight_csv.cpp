// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/sight_csv.hpp"

#include <charconv>
#include <string>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr std::string_view kHead =
    "time,eye_x,eye_y,eye_z,sign,distance,angle,blocked,optical_depth,optical_depth_low,"
    "optical_depth_high,mean_extinction,visibility,visible\n";

/// The shortest text that reads as the same number; inf and nan by these names.
template <class T>
void append(std::string& out, T value) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, value);
  out.append(text, end);
}

/// Nine digits are enough for what is computed here, and leave 0.3 as 0.3.
void appendField(std::string& out, double value) {
  out += ',';
  append(out, static_cast<float>(value));
}

void appendFlag(std::string& out, bool flag) {
  out += flag ? ",1" : ",0";
}

/// A cell. Programs for tables compute what begins like a formula: it gets an apostrophe in front.
std::string quoted(const std::string& text) {
  const bool formula = !text.empty() && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos;
  const std::string name = (formula ? "'" : "") + text;
  if (name.find_first_of(",\"\r\n") == std::string::npos)
    return name;
  std::string out = "\"";
  for (const char c : name) {
    if (c == '"')
      out += '"';
    out += c;
  }
  return out + "\"";
}

void appendRow(std::string& out, const std::string& head, const std::string& sign,
               const Sighting& sighting) {
  out += head;
  out += sign;
  appendField(out, sighting.distance);
  appendField(out, sighting.angle);
  appendFlag(out, sighting.blocked);
  appendField(out, sighting.depth);
  appendField(out, sighting.low);
  appendField(out, sighting.high);
  appendField(out, sighting.meanExtinction);
  appendField(out, sighting.visibility);
  appendFlag(out, sighting.visible);
  out += '\n';
}

}  // namespace

Result<SightCsv> SightCsv::create(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(auto file, OutputFile::create(path));
  VOLUTE_TRY(file.write(std::as_bytes(std::span(kHead))));
  return SightCsv(std::move(file));
}

std::string SightCsv::rowsOf(double time, std::span<const Vec3> eyes,
                             std::span<const SightTarget> signs,
                             std::span<const Sighting> sightings) {
  constexpr std::size_t kEyes = 512;
  std::vector<std::string> names;
  for (const SightTarget& sign : signs) names.push_back(quoted(sign.sign.name));
  std::string when;
  append(when, time);
  std::vector<std::string> parts((eyes.size() + kEyes - 1) / kEyes);
  parallelFor(parts.size(), [&](std::size_t p) {
    for (std::size_t i = p * kEyes; i < std::min(eyes.size(), (p + 1) * kEyes); ++i) {
      std::string head = when;
      for (int axis = 0; axis < 3; ++axis) appendField(head, eyes[i][axis]);
      head += ',';
      for (std::size_t s = 0; s < signs.size(); ++s)
        appendRow(parts[p], head, names[s], sightings[s * eyes.size() + i]);
    }
  });
  std::string rows;
  for (const std::string& part : parts) rows += part;
  return rows;
}

Status SightCsv::write(std::string_view rows, std::uint64_t count) {
  rows_ += count;
  return file_.write(std::as_bytes(std::span(rows)));
}

}  // namespace volute
