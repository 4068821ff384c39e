// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "volute/capture/importers.hpp"

namespace volute {
namespace {

/// Lens, pose and size: entries of one camera repeat them to the last digit.
using PoseKey = std::array<double, 32>;

PoseKey keyOf(const CameraDraft& draft) {
  const Calibration& camera = draft.calibration;
  PoseKey key{};
  auto next = key.begin();
  for (const Mat3* matrix : {&camera.K, &camera.R})
    next = std::copy_n(matrix->data(), matrix->size(), next);
  next = std::copy_n(camera.t.data(), 3, next);
  const Distortion& lens = camera.distortion;
  for (const double value : {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3}) *next++ = value;
  *next++ = camera.width;
  *next++ = camera.height;
  for (std::size_t side = 0; side < 2; ++side) {
    *next++ = draft.angles[side];
    *next++ = draft.centred[side] ? 1 : 0;
  }
  for (double& value : key) value += 0.0;  // -0 is 0
  return key;
}

/// A name of a picture around one of the numbers in it.
struct NumberedName {
  std::string before, digits, after;

  int number() const {
    int value = -1;
    std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return value;
  }
};

/// The name around each number in the file's name, from the last on: folders hold no numbers.
std::vector<NumberedName> numbersIn(const std::string& path) {
  constexpr std::size_t kMax = 9;  // digits
  const auto isDigit = [&](std::size_t i) {
    return std::isdigit(static_cast<unsigned char>(path[i])) != 0;
  };
  const std::size_t slash = path.rfind('/');
  const std::size_t begin = slash == std::string::npos ? 0 : slash + 1;
  const std::size_t dot = path.rfind('.');
  std::vector<NumberedName> names;
  for (std::size_t end = dot == std::string::npos || dot < begin ? path.size() : dot;
       end > begin;) {
    if (!isDigit(end - 1)) {
      --end;
      continue;
    }
    std::size_t first = end;
    while (first > begin && isDigit(first - 1)) --first;
    if (end - first <= kMax)
      names.push_back({path.substr(0, first), path.substr(first, end - first), path.substr(end)});
    end = first;
  }
  return names;
}

/// The entries of one camera.
struct Group {
  std::vector<const CameraDraft*> entries;
  std::vector<NumberedName> names;  // one an entry
};

/// By which of the numbers, counted from the last, the names of the entries differ.
std::optional<std::size_t> numberThatDiffers(const std::vector<const CameraDraft*>& entries) {
  const auto first = numbersIn(entries[0]->pictures.image);
  for (std::size_t k = 0; k < first.size(); ++k) {
    const bool all = std::ranges::all_of(entries, [&](const CameraDraft* entry) {
      const auto names = numbersIn(entry->pictures.image);
      return names.size() > k && names[k].before == first[k].before &&
             names[k].after == first[k].after;
    });
    if (all)
      return k;
  }
  return std::nullopt;
}

/// The series of files, with the frame's number open; nothing where leading zeros come and go.
std::optional<std::string> patternOf(const std::vector<NumberedName>& names) {
  const auto escaped = [](std::string text) {
    for (auto at = text.find('%'); at != std::string::npos; at = text.find('%', at + 2))
      text.insert(at, 1, '%');
    return text;
  };
  const std::size_t width = names[0].digits.size();
  const bool same = std::ranges::all_of(
      names, [&](const NumberedName& name) { return name.digits.size() == width; });
  const bool padded = std::ranges::any_of(names, [](const NumberedName& name) {
    return name.digits.size() > 1 && name.digits[0] == '0';
  });
  if (padded && !same)
    return std::nullopt;
  return escaped(names[0].before) + (same ? fmt::format("%0{}d", width) : std::string("%d")) +
         escaped(names[0].after);
}

tl::unexpected<Error> withoutNumbers(const CameraDraft& entry) {
  return fail(ErrorCode::kInvalidData,
              "{}: entries with its pose are pictures of one camera at several times, but their "
              "names do not differ by one number in the file's name ({}); rename them, or state a "
              "pattern of the images' names with the camera and the frame",
              entry.where, entry.pictureName);
}

/// A camera's pictures by frame: number = step * frame + first.
struct NumberLine {
  int step = 1, first = 0;
  bool operator==(const NumberLine&) const = default;
};

std::optional<NumberLine> lineThrough(const std::vector<std::pair<int, int>>& points) {
  NumberLine line{1, points[0].second - points[0].first};
  if (points.size() > 1) {
    const int frames = points[1].first - points[0].first;
    const int numbers = points[1].second - points[0].second;
    if (frames <= 0 || numbers <= 0 || numbers % frames != 0)
      return std::nullopt;
    line.step = numbers / frames;
    line.first = points[0].second - line.step * points[0].first;
  }
  const bool all = std::ranges::all_of(points, [&](const std::pair<int, int>& point) {
    return point.second == line.step * point.first + line.first;
  });
  return all ? std::optional(line) : std::nullopt;
}

/// Frames are the places of times among all of them; numbers, where each camera counts alike.
Status placeByTime(std::vector<Group>& groups, const std::set<double>& times,
                   std::vector<CameraDraft>& cameras, std::set<int>& frames) {
  std::vector<NumberLine> lines;
  for (const Group& group : groups) {
    std::vector<std::pair<int, int>> points;
    for (std::size_t i = 0; i < group.entries.size(); ++i) {
      // NOLINTNEXTLINE(bugprone-unchecked-optional-access): all have one
      const auto rank = std::distance(times.begin(), times.find(*group.entries[i]->time));
      points.emplace_back(static_cast<int>(rank), group.names[i].number());
    }
    std::ranges::sort(points);
    const auto line = lineThrough(points);
    if (!line) {
      return fail(
          ErrorCode::kInvalidData,
          "{}: the numbers of its pictures and its entries' times do not rise together, one "
          "picture for each time; rename them in the order of time, or state a pattern of "
          "the images' names",
          group.entries[0]->where);
    }
    lines.push_back(*line);
  }
  const bool alike =
      std::ranges::all_of(lines, [&](const NumberLine& line) { return line == lines[0]; });
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (const CameraDraft* entry : groups[g].entries) {
      // NOLINTNEXTLINE(bugprone-unchecked-optional-access): all of a group have one
      const auto rank = static_cast<int>(std::distance(times.begin(), times.find(*entry->time)));
      frames.insert(alike ? lines[g].step * rank + lines[g].first : rank);
    }
    if (alike)
      continue;
    cameras[g].pictures.rate = lines[g].step;
    cameras[g].pictures.videoStart = -static_cast<double>(lines[g].first) / lines[g].step;
  }
  return {};
}

/// Without times numbers are frames, which all cameras must then share.
Status placeByNumber(const std::vector<Group>& groups, std::set<int>& frames) {
  std::vector<std::set<int>> numbers(groups.size());
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (const NumberedName& name : groups[g].names) numbers[g].insert(name.number());
    if (numbers[g].size() < groups[g].names.size()) {
      return fail(ErrorCode::kInvalidData, "{}: two pictures of one pose have the same number",
                  groups[g].entries[0]->where);
    }
    frames.insert(numbers[g].begin(), numbers[g].end());
  }
  for (std::size_t g = 1; g < groups.size(); ++g) {
    const bool shares =
        std::ranges::any_of(numbers[g], [&](int number) { return numbers[0].contains(number); });
    if (!shares) {
      return fail(
          ErrorCode::kInvalidData,
          "{}: its pose has the pictures {} to {} and that of {} has {} to {}, and no entry "
          "has a \"time\" that tells which were taken together; expected times, or names "
          "with the frame's number",
          groups[g].entries[0]->where, *numbers[g].begin(), *numbers[g].rbegin(),
          groups[0].entries[0]->where, *numbers[0].begin(), *numbers[0].rbegin());
    }
  }
  return {};
}

/// Where some entries have times, numbers must not run against them.
Status checkTimes(const std::vector<Group>& groups) {
  std::map<int, double> timeOf;
  for (const Group& group : groups) {
    for (std::size_t i = 0; i < group.entries.size(); ++i) {
      if (group.entries[i]->time)
        // NOLINTNEXTLINE(bugprone-unchecked-optional-access): asked for above
        timeOf.emplace(group.names[i].number(), *group.entries[i]->time);
    }
  }
  for (const Group& group : groups) {
    for (std::size_t i = 0; i < group.entries.size(); ++i) {
      const CameraDraft& entry = *group.entries[i];
      if (!entry.time)
        continue;
      const auto at = timeOf.find(group.names[i].number());
      const bool later = at == timeOf.begin() || std::prev(at)->second < *entry.time;
      if (at->second == *entry.time && later)
        continue;
      return fail(
          ErrorCode::kInvalidData,
          "{}: its \"time\" {:g} does not rise with the number {} of its picture, and other "
          "entries have no time; expected a time in each entry, or names in the order of "
          "time",
          entry.where, *entry.time, group.names[i].number());
    }
  }
  return {};
}

/// Cameras whose files are called alike: "cam0/frame_%04d.png" is camera cam0; of one series for
/// all they are counted.
void nameByFolder(std::vector<CameraDraft>& cameras) {
  std::set<std::string> files, folders;
  const auto folderOf = [](const CameraDraft& camera) {
    return std::filesystem::path(camera.pictures.image).parent_path().filename().string();
  };
  for (const CameraDraft& camera : cameras) {
    files.insert(std::filesystem::path(camera.pictures.image).filename().string());
    folders.insert(folderOf(camera));
  }
  if (files.size() == cameras.size())
    return;
  const bool byFolder = folders.size() == cameras.size();
  for (std::size_t i = 0; i < cameras.size(); ++i)
    cameras[i].name = byFolder ? folderOf(cameras[i]) : fmt::format("camera{}", i);
}

}  // namespace

Status groupEntries(CaptureDraft& draft) {
  const bool entries = std::ranges::all_of(draft.cameras, [](const CameraDraft& camera) {
    return camera.name.empty() && !camera.pictures.image.empty();
  });
  if (!entries)
    return {};
  std::map<PoseKey, std::size_t> places;
  std::vector<Group> groups;
  std::set<double> times;
  std::size_t timed = 0;
  for (const CameraDraft& entry : draft.cameras) {
    const auto [place, isNew] = places.emplace(keyOf(entry), groups.size());
    if (isNew)
      groups.emplace_back();
    groups[place->second].entries.push_back(&entry);
    if (entry.time) {
      times.insert(*entry.time);
      ++timed;
    }
  }
  const bool byTime = timed == draft.cameras.size() && times.size() > 1;
  if (groups.size() == draft.cameras.size()) {
    if (times.size() < 2)
      return {};
    return fail(
        ErrorCode::kInvalidData,
        "{}: entries are of {} times (\"time\"), and each has a pose of its own: the camera "
        "moves; expected cameras that stand still, several at each time",
        draft.cameras.front().where, times.size());
  }
  if (byTime && draft.cameras.size() < 2 * times.size()) {
    return fail(
        ErrorCode::kInvalidData,
        "{}: {} entries are of {} times (\"time\"), fewer than two cameras at each; expected "
        "cameras that stand still, several at each time",
        draft.cameras.front().where, draft.cameras.size(), times.size());
  }
  std::optional<std::size_t> usual;  // which number tells, for a camera with one picture
  for (Group& group : groups) {
    if (group.entries.size() < 2)
      continue;
    const auto which = numberThatDiffers(group.entries);
    if (!which)
      return withoutNumbers(*group.entries[0]);
    if (!usual)
      usual = which;
    for (const CameraDraft* entry : group.entries)
      group.names.push_back(numbersIn(entry->pictures.image)[*which]);
  }
  std::vector<CameraDraft> cameras;
  for (Group& group : groups) {
    if (group.names.empty()) {
      const auto names = numbersIn(group.entries[0]->pictures.image);
      if (names.size() <= *usual)
        return withoutNumbers(*group.entries[0]);
      group.names.push_back(names[*usual]);
    }
    const auto pattern = patternOf(group.names);
    if (!pattern)
      return withoutNumbers(*group.entries[0]);
    CameraDraft& camera = cameras.emplace_back(*group.entries[0]);
    camera.pictures.image = *pattern;
    camera.pictureName = *pattern;
  }
  nameByFolder(cameras);
  std::set<int> frames;
  if (byTime)
    VOLUTE_TRY(placeByTime(groups, times, cameras, frames));
  else
    VOLUTE_TRY(placeByNumber(groups, frames));
  if (!byTime && times.size() > 1)
    VOLUTE_TRY(checkTimes(groups));
  draft.remarks.emplace_back(
      byTime ? RemarkCode::kAssumed : RemarkCode::kNote,
      fmt::format("{} entries are {} cameras that stand still, with {} frames{}",
                  draft.cameras.size(), cameras.size(), frames.size(),
                  byTime ? "; \"time\" tells their order alone, for it has no unit" : ""));
  if (!byTime && times.size() > 1)
    draft.remarks.emplace_back(
        RemarkCode::kLeftOut,
        fmt::format("{} of {} entries have no \"time\": frames go by the numbers of the pictures, "
                    "whose order is that of the times that are there",
                    draft.cameras.size() - timed, draft.cameras.size()));
  draft.cameras = std::move(cameras);
  draft.frames = std::vector<int>(frames.begin(), frames.end());
  return {};
}

}  // namespace volute
