// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/grid_choice.hpp"

#include <algorithm>

#include "volute/base/suggest.hpp"

namespace volute {
namespace {

/// After a list that was cut.
constexpr std::string_view kMore = " ...";

std::string listed(std::span<const GridEntry> entries) {
  constexpr std::size_t kMax = 32;
  std::string text;
  for (std::size_t i = 0; i < std::min(entries.size(), kMax); ++i) {
    text += fmt::format("{}{} ({})", i == 0 ? "" : ", ", entries[i].name, entries[i].type);
  }
  if (entries.size() > kMax)
    text += fmt::format(" and {} more", entries.size() - kMax);
  return text;
}

std::string nearestHint(std::span<const GridEntry> entries, const std::string& wanted) {
  const auto distance = [&](const GridEntry& entry) { return editDistance(entry.name, wanted); };
  const auto nearest = std::ranges::min_element(entries, {}, distance);
  const bool close = distance(*nearest) <= std::max<std::size_t>(2, wanted.size() / 2) ||
                     nearest->name.find(wanted) != std::string::npos;
  return close ? fmt::format("; did you mean '{}'?", nearest->name) : std::string(";");
}

}  // namespace

Result<std::size_t> chooseGrid(std::span<const GridEntry> entries, const std::string& wanted,
                               const std::string& file, const GridWords& words) {
  const char* const noun = words.noun;
  if (entries.empty())
    return fail(ErrorCode::kNotFound, "{}: holds no {}s", file, noun);
  const std::string choice = wanted.empty() ? words.usual : wanted;
  const auto named = std::ranges::find(entries, choice, &GridEntry::name);
  if (wanted.empty()) {
    const auto usable = std::ranges::count_if(entries, &GridEntry::usable);
    if (usable == 1)
      return std::ranges::find(entries, true, &GridEntry::usable) - entries.begin();
    if (usable == 0) {
      return fail(ErrorCode::kUnsupported, "{}: no {} is {}; it has {}", file, noun, words.expected,
                  listed(entries));
    }
    if (named == entries.end() || !named->usable) {
      return fail(ErrorCode::kInvalidArgument, Hint::choose("field"), "{}: which {}? It has {}",
                  file, noun, listed(entries));
    }
  }
  if (named == entries.end()) {
    return fail(ErrorCode::kNotFound, "{}: no {} named '{}'{} it has {}", file, noun, wanted,
                nearestHint(entries, wanted), listed(entries));
  }
  if (!named->usable) {
    return fail(ErrorCode::kUnsupported, "{}: {} '{}' is of type {}; expected {}; it has {}", file,
                noun, named->name, named->type, words.expected, listed(entries));
  }
  return named - entries.begin();
}

void tellApart(std::span<GridEntry> entries, const std::function<bool(std::size_t)>& ofCells) {
  std::vector<std::string> names;
  for (const GridEntry& entry : entries) names.push_back(entry.name);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    for (std::size_t k = 0; k < entries.size(); ++k) {
      if (names[k] != names[i] || ofCells(k) == ofCells(i))
        continue;
      entries[i].name += ofCells(i) ? " (cells)" : " (points)";
      break;
    }
  }
}

std::string otherGrids(std::span<const GridEntry> entries, std::size_t chosen, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (i == chosen || !entries[i].usable)
      continue;
    const std::string name = (text.empty() ? "" : ", ") + entries[i].name;
    if (text.size() + name.size() + kMore.size() > most)
      return text + std::string(kMore);
    text += name;
  }
  return text;
}

std::vector<std::string> namesOfGrids(std::string_view others) {
  if (others.ends_with(kMore))
    others.remove_suffix(kMore.size());
  std::vector<std::string> names;
  while (!others.empty()) {
    const std::size_t end = std::min(others.find(", "), others.size());
    names.emplace_back(others.substr(0, end));
    others.remove_prefix(std::min(end + 2, others.size()));
  }
  return names;
}

}  // namespace volute
