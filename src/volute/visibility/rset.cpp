// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/rset.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "volute/base/parallel.hpp"
#include "volute/base/read_text.hpp"
#include "volute/io/number_word.hpp"

namespace volute {
namespace {

/// The text with the name of its third column changed to z; empty when there is none.
std::string withTimeAsZ(std::string_view text) {
  std::string out(text);
  std::string lower(text.substr(0, 4096));
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  std::size_t begin = 0;
  while (begin < lower.size() && lower[begin] == '#')
    begin = std::min(lower.find('\n', begin), lower.size() - 1) + 1;
  const std::size_t end = std::min(lower.find('\n', begin), lower.size());
  for (const std::string_view name : {"rset", "time"}) {
    const std::size_t found = lower.find(name, begin);
    if (found < end)
      return out.replace(found, name.size(), "z");
  }
  return "";
}

}  // namespace

Result<Rset> Rset::parse(std::string_view text, std::string_view file) {
  // With their heights, else on every storey.
  auto people = Trajectories::parse(text, file, std::nullopt);
  if (!people)
    people = Trajectories::parse(text, file, std::numeric_limits<double>::quiet_NaN());
  if (people)
    return Rset(std::move(*people));
  const std::string named = withTimeAsZ(text);
  const auto points =
      parsePoints(named.empty() ? text : std::string_view(named), file, std::nullopt);
  if (!points) {
    return fail(ErrorCode::kInvalidData,
                "{}: expected lines x,y,rset in metres and seconds, or people who walk (JuPedSim's "
                "text format, or a table id,time,x,y): {}",
                file, points.error().message);
  }
  std::vector<Vec3> map;
  std::map<std::pair<double, double>, double> timeAt;
  for (const NamedPoint& point : *points) {
    const Vec3& p = point.position;
    const auto [before, isNew] = timeAt.emplace(std::pair(p[0], p[1]), p[2]);
    if (!isNew && before->second != p[2]) {
      return fail(ErrorCode::kInvalidData,
                  "{}: two times at the place {}, {}: {} s and {} s; expected one for each place",
                  file, p[0], p[1], before->second, p[2]);
    }
    map.push_back(p);
  }
  return Rset(std::move(map));
}

Result<Rset> Rset::read(const std::string& secondsOrFile, std::uint64_t most) {
  double seconds = 0;
  if (readNumber(secondsOrFile, seconds)) {
    if (seconds >= 0)
      return Rset(seconds);
    return fail(ErrorCode::kInvalidArgument, "rset: {}: expected seconds >= 0, or a file",
                secondsOrFile);
  }
  VOLUTE_ASSIGN(const auto text, readText(secondsOrFile, most));
  return parse(text, secondsOrFile);
}

std::vector<double> Rset::at(std::span<const Vec3> points, double radius) const {
  if (const double* seconds = std::get_if<double>(&what_))
    return std::vector<double>(points.size(), *seconds);
  if (const auto* people = std::get_if<Trajectories>(&what_))
    return people->lastTimes(points, radius);
  const auto& map = std::get<std::vector<Vec3>>(what_);
  std::vector<double> out(points.size());
  parallelRanges(points.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto nearest = std::ranges::min_element(
          map, {}, [&](const Vec3& place) { return (place - points[i]).head<2>().squaredNorm(); });
      out[i] = (*nearest)[2];
    }
  });
  return out;
}

std::string Rset::description() const {
  if (const double* seconds = std::get_if<double>(&what_))
    return fmt::format("{:g} s everywhere", *seconds);
  if (const auto* people = std::get_if<Trajectories>(&what_))
    return fmt::format("until the last of {} people has passed", people->people());
  return fmt::format("a map of {} points", std::get<std::vector<Vec3>>(what_).size());
}

}  // namespace volute
