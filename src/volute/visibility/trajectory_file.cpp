// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>

#include "volute/base/plain_number.hpp"
#include "volute/io/sqlite_file.hpp"
#include "volute/io/table.hpp"
#include "volute/visibility/eyes.hpp"

// Files of people who walk, as evacuation programs write them.

namespace volute {
namespace {

constexpr double kLargestPlace = 1e7;  // [m]
constexpr double kLargestId = 2e9;
constexpr double kSamePlace = 1e-6;   // [m]
constexpr double kLongestWalk = 1e9;  // [s]

/// What a file says z is.
enum class HeightOf { kEyes, kFloor, kNothing };

/// A person's place at a time, as the file has it.
struct Row {
  int id = 0;
  double time = 0;  ///< [s], or a frame
  Vec3 place = Vec3::Zero();
  std::optional<double> eyes;  ///< [m] above the floor
};

/// Places of people by time, in any order.
class Walks {
 public:
  Walks(std::string_view file, std::optional<double> height, double aboveFloor)
      : file_(file), height_(height), aboveFloor_(aboveFloor) {}

  HeightOf zIs = HeightOf::kEyes;
  std::string_view column = "z";  ///< that it stands in
  bool ownHeights = false;        ///< everybody's eyes are as far above the floor as a column says
  bool guessed = false;  ///< zIs by who writes such files: z near 0 is the floor nevertheless

  Status add(const Row& row, std::string_view where) {
    if (!(row.place.cwiseAbs().maxCoeff() <= kLargestPlace) ||
        !(std::abs(row.time) <= kLongestWalk)) {
      return fail(ErrorCode::kInvalidData,
                  "{}: person {} is at {}, {}, {} m at {} s; expected metres and seconds", where,
                  row.id, plainNumber(row.place[0]), plainNumber(row.place[1]),
                  plainNumber(row.place[2]), plainNumber(row.time));
    }
    Vec3 eye = row.place;
    if (height_)
      eye[2] = *height_;
    else if (zIs != HeightOf::kEyes)
      eye[2] += row.eyes.value_or(aboveFloor_);
    aboveFloors_ = aboveFloors_ || (!height_ && zIs != HeightOf::kEyes && !row.eyes);
    if (std::isfinite(row.place[2]))
      highest_ = std::max(highest_, row.place[2]);
    const auto [last, first] = last_.emplace(row.id, row.time);
    if (!first && row.time < last->second && back_++ == 0)
      backAt_ = where;
    last->second = row.time;
    const auto [found, isNew] = people_[row.id].emplace(row.time, eye);
    const Vec3 apart = found->second - eye;  // z may be unknown
    if (isNew || (apart.head<2>().norm() < kSamePlace && !(std::abs(apart[2]) >= kSamePlace)))
      return {};
    return fail(ErrorCode::kInvalidData,
                "{}: person {} is at two places at once: {}, {} and {}, {} m; expected one "
                "line for each person and time",
                where, row.id, plainNumber(found->second[0]), plainNumber(found->second[1]),
                plainNumber(eye[0]), plainNumber(eye[1]));
  }

  bool empty() const { return people_.empty(); }

  /// Whether anybody's eyes are as high above the floor as everybody's.
  bool areAboveFloors() const { return aboveFloors_ || isFloor(); }

  /// Nobody runs so fast: lengths or times are in another unit.
  Status checkSpeeds(double rate) {
    constexpr double kFastest = 20, kSlowest = 0.01;  // [m/s]
    std::size_t moves = 0, tooFast = 0;
    double length = 0, duration = 0;  // of moves
    for (const auto& [id, steps] : people_) {
      for (auto to = steps.begin(), from = to++; to != steps.end(); from = to++) {
        const double way = (to->second - from->second).head<2>().norm();
        const double time = (to->first - from->first) / rate;
        if (!(way > kSamePlace))
          continue;
        ++moves, length += way, duration += time;
        tooFast += way > kFastest * time ? 1 : 0;
      }
    }
    if (2 * tooFast > moves) {
      return fail(ErrorCode::kInvalidData,
                  "{}: people move at {:.3g} m/s in the mean, most of the time faster than {:g}; "
                  "expected places in metres and times in seconds: are they in mm, or is the frame "
                  "rate another?",
                  file_, length / duration, kFastest);
    }
    if (moves > 0 && length < kSlowest * duration)
      slow_ = length / duration;
    return {};
  }

  /// Of each person, ascending by id; times are divided by `rate`.
  template <class Take>
  void give(double rate, Take&& take) const {
    for (const auto& [id, steps] : people_) {
      std::vector<std::pair<double, Vec3>> list;
      for (const auto& [time, eye] : steps)
        list.emplace_back(time / rate, eye + Vec3(0, 0, isFloor() ? aboveFloor_ : 0));
      take(id, list);
    }
  }

  std::vector<Remark> remarks() const {
    std::vector<Remark> remarks;
    if (back_ > 0) {
      remarks.emplace_back(
          RemarkCode::kDoubtful,
          fmt::format("{}: time goes back there{}: places are sorted by time, so that "
                      "two walks of one person become one",
                      backAt_, back_ > 1 ? fmt::format(", and at {} lines more", back_ - 1) : ""));
    }
    if (slow_) {
      remarks.emplace_back(
          RemarkCode::kDoubtful,
          fmt::format(
              "{}: people move at {:.2g} m/s in the mean, where they move: are places in km?",
              file_, *slow_));
    }
    if (height_ && !std::isnan(*height_) && (zIs != HeightOf::kNothing || ownHeights)) {
      remarks.emplace_back(
          RemarkCode::kLeftOut,
          fmt::format("{}: its {} is not used: all eyes are at z = {} m", file_,
                      zIs == HeightOf::kNothing ? "eye_height" : column, plainNumber(*height_)));
    }
    if (height_ || (zIs == HeightOf::kEyes && !isFloor()))
      return remarks;
    remarks.push_back(
        fmt::format("{}: {}: eyes are {} above it", file_,
                    zIs != HeightOf::kNothing ? fmt::format("{} is the floor there", column)
                                              : "has no z: the floor is taken at z = 0",
                    ownHeights ? "as far as eye_height says" : fmt::format("{:g} m", aboveFloor_)));
    return remarks;
  }

 private:
  /// Whether z was taken as that of heads, and nobody has one there.
  bool isFloor() const {
    constexpr double kLowestHead = 0.5;  // [m]
    return guessed && zIs == HeightOf::kEyes && !height_ && highest_ < kLowestHead;
  }

  std::string file_;
  std::optional<double> height_;
  double aboveFloor_;
  bool aboveFloors_ = false;                                   // it counts for somebody
  double highest_ = -std::numeric_limits<double>::infinity();  // z [m]
  std::map<int, std::map<double, Vec3>> people_;
  std::map<int, double> last_;  // the time of each person's last line
  std::size_t back_ = 0;        // lines with an earlier one
  std::string backAt_;          // the first of them
  std::optional<double> slow_;  // their speed [m/s], if it is nobody's
};

tl::unexpected<Error> nobody(std::string_view file, std::string_view expected) {
  return fail(ErrorCode::kInvalidData, "{}: nobody walks here; expected {}", file, expected);
}

tl::unexpected<Error> secondRate(std::string_view where, double rate, double earlier) {
  return fail(ErrorCode::kInvalidData, "{}: a second frame rate, {:g} after {:g}: which?", where,
              rate, earlier);
}

enum PersonColumn : std::size_t {
  kId,
  kTime,
  kPx,
  kPy,
  kPz,
  kFloorZ,
  kActive,
  kLocation,
  kOwnHeight,
  kPersonName
};

constexpr const char* kTableNames = "a line of names with id, time, x, y and z";

/// Whether somebody is there: "1", "0", "true" ...
Result<bool> isPresent(const TableReader& table) {
  const std::string word = lowerCase(table.text(kActive));
  const auto number = finiteNumber(word);
  if (number == 1 || word == "true" || word == "yes")
    return true;
  if (number == 0 || word == "false" || word == "no")
    return false;
  return fail(ErrorCode::kInvalidData,
              "{}: active is '{}'; expected 1 or 0, true or false, yes or no", table.where(), word);
}

/// What a table of people has and is not used.
void tellUnused(const TableReader& table, std::string_view file, const Walks& walks,
                std::optional<double> height, std::vector<Remark>& remarks) {
  remarks.insert(remarks.end(), table.remarks().begin(), table.remarks().end());
  const auto tell = [&](std::string_view column, std::string_view why) {
    remarks.emplace_back(RemarkCode::kLeftOut,
                         fmt::format("{}: its {} is not used: {}", file, column, why));
  };
  if (!height && table.has(kFloorZ) && table.has(kPz))
    tell("z", "floor says where people stand; leave floor out if z is that of the eyes");
  if (!height && table.has(kOwnHeight) && walks.zIs == HeightOf::kEyes)
    tell("eye_height", "z is that of the eyes");
}

/// A table with names: our own id,time,x,y,z, or what Pathfinder writes about its occupants.
Status readPeopleTable(std::string_view text, std::string_view file, std::optional<double> height,
                       Walks& walks, std::vector<Remark>& remarks) {
  TableReader table(
      file,
      {{"id", "", {"agent", "person", "occupant", "occupant id", "agent id", "person id"}},
       {"time", "s", {"t"}},
       {"x", "m"},
       {"y", "m"},
       {"z", "m"},
       {"floor", "m"},
       {"active", "", {}, true},
       {"location", "", {}, true},
       {"eye_height", "m"},
       {"name", "", {}, true}},
      {.own = false, .spare = {"v", "speed", "distance"}});
  bool checked = false;
  std::map<std::string, int, std::less<>> numbers;  // of names, where there are no ids
  std::map<int, std::string> names;                 // of ids
  VOLUTE_TRY(readTable(table, text, [&]() -> Status {
    if (!checked) {
      checked = true;
      for (const std::size_t column : {kId, kTime, kPx, kPy}) {
        if (!table.has(column) && !(column == kId && table.has(kPersonName)))
          return fail(ErrorCode::kInvalidData, "{}: expected {}", table.where(), kTableNames);
      }
      const bool ofPathfinder = table.has(kActive) || table.has(kLocation);
      walks.zIs = table.has(kFloorZ) || (table.has(kPz) && ofPathfinder) ? HeightOf::kFloor
                  : table.has(kPz)                                       ? HeightOf::kEyes
                                                                         : HeightOf::kNothing;
      walks.column = table.has(kFloorZ) ? "floor" : "z";
      walks.ownHeights = table.has(kOwnHeight);
      if (walks.zIs == HeightOf::kNothing && !height) {
        return fail(ErrorCode::kInvalidData,
                    "{}: expected {} (of the eyes), floor, or the height of the eyes stated",
                    table.where(), kTableNames);
      }
    }
    if (table.has(kActive)) {
      VOLUTE_ASSIGN(const bool present, isPresent(table));
      if (!present)
        return {};  // not yet there, or gone
    }
    Row row;
    if (table.has(kId)) {
      VOLUTE_ASSIGN(const double id, table.whole(kId, -kLargestId, kLargestId));
      row.id = static_cast<int>(id);
      if (table.has(kPersonName)) {
        const auto known = names.emplace(row.id, table.text(kPersonName)).first;
        if (known->second != table.text(kPersonName)) {
          return fail(
              ErrorCode::kInvalidData,
              "{}: person {} is called '{}', and '{}' before; expected one name for each id",
              table.where(), row.id, table.text(kPersonName), known->second);
        }
      }
    } else {
      const int next = static_cast<int>(numbers.size()) + 1;
      row.id = numbers.emplace(table.text(kPersonName), next).first->second;
    }
    VOLUTE_ASSIGN(row.time, table.number(kTime));
    VOLUTE_ASSIGN(row.place[0], table.number(kPx));
    VOLUTE_ASSIGN(row.place[1], table.number(kPy));
    const std::size_t z = table.has(kFloorZ) ? kFloorZ : kPz;
    if (table.has(z)) {
      VOLUTE_ASSIGN(row.place[2], table.number(z));
    }
    if (table.has(kOwnHeight)) {
      VOLUTE_ASSIGN(row.eyes, table.number(kOwnHeight));
    }
    return walks.add(row, table.where());
  }));
  tellUnused(table, file, walks, height, remarks);
  if (!numbers.empty()) {
    remarks.push_back(
        fmt::format("{}: has no ids: people are numbered from 1 in the order in which "
                    "their names come",
                    file));
  }
  return walks.empty() ? nobody(file, "lines id,time,x,y") : Status{};
}

/// The frames a second that "# framerate: 8.00 fps" says.
std::optional<double> rateIn(std::string_view line) {
  constexpr std::string_view kRate = "framerate:";
  const std::string remark = lowerCase(line);
  const std::size_t at = remark.find(kRate);
  if (at == remark.npos)
    return std::nullopt;
  const auto words = fieldsOf(std::string_view(remark).substr(at + kRate.size()), '\0');
  const auto value = words.empty() ? std::nullopt : finiteNumber(words[0]);
  constexpr std::string_view kUnits[] = {"fps", "hz", "1/s", "s-1", "s^-1", "frames"};
  const bool known = words.size() < 2 || std::ranges::find(kUnits, words[1]) != std::end(kUnits);
  return known ? value.value_or(0) : 0;
}

enum FrameColumn : std::size_t { kFrameId, kFrame, kFx, kFy, kFz };

/// "id frame x y z ..." after remarks with the frame rate, as JuPedSim and PeTrack write them; the
/// rate is left in `rate`.
Status readFrames(std::string_view text, std::string_view file, std::optional<double> height,
                  Walks& walks, double& rate) {
  const bool commas = [&] {
    std::size_t at = 0;
    while (at < text.size() && text[at] == '#')
      at = std::min(text.find('\n', at), text.size() - 1) + 1;
    return text.substr(at, text.find('\n', at) - at).find_first_of(",;") != text.npos;
  }();
  TableReader table(
      file,
      {{"id", "", {"persid", "personid", "agentid"}},
       {"frame", "", {"fr"}},
       {"x", "m"},
       {"y", "m"},
       {"z", "m"}},
      {.own = false, .unnamed = {height ? 4U : 5U, 5U}, .blanks = !commas, .longer = true});
  bool measured = false;  // heads of people in front of a camera
  const auto isHead = [](std::string_view names) {
    const std::string lower = lowerCase(trimmedField(names));
    const auto fields = fieldsOf(lower, lower.find(',') == lower.npos ? '\0' : ',');
    constexpr std::string_view kIds[] = {"id", "persid", "personid", "agentid"};
    const auto isId = [&](std::string_view field) {
      return std::ranges::find(kIds, field) != std::end(kIds);
    };
    return fields.size() >= 4 && std::ranges::any_of(fields, isId) &&
           std::ranges::any_of(fields, [](std::string_view one) { return one.starts_with("fr"); });
  };
  VOLUTE_TRY(forEachRow(text, [&](std::string_view line, int) -> Status {
    if (line.starts_with('#')) {
      table.skip();
      if (const auto said = rateIn(line)) {
        if (rate > 0 && *said != rate) {
          return secondRate(table.where(), *said, rate);
        }
        rate = *said;
      }
      std::string names(line.substr(
          line.find_first_not_of('#') == line.npos ? line.size() : line.find_first_not_of('#')));
      for (std::size_t at = names.find("[in "); at != names.npos; at = names.find("[in "))
        names.replace(at, 4, "[");
      measured = measured || lowerCase(line).find("petrack") != std::string::npos ||
                 lowerCase(line).find("z/cm") != std::string::npos ||
                 lowerCase(names).find("z[cm]") != std::string::npos;
      return isHead(names) && !table.named() ? table.takeNames(trimmedField(names)) : Status{};
    }
    VOLUTE_ASSIGN(const bool values, table.take(line));
    if (!values)
      return {};
    for (const std::size_t column : {kFrameId, kFrame, kFx, kFy}) {
      if (!table.has(column))
        return fail(ErrorCode::kInvalidData, "{}: expected 'id frame x y z'", table.where());
    }
    walks.zIs = !table.has(kFz) ? HeightOf::kNothing
                : measured      ? HeightOf::kEyes
                                : HeightOf::kFloor;
    walks.guessed = measured;
    Row row;
    VOLUTE_ASSIGN(const double id, table.whole(kFrameId, 0, kLargestId));
    row.id = static_cast<int>(id);
    VOLUTE_ASSIGN(row.time, table.whole(kFrame, 0, kLargestId));
    VOLUTE_ASSIGN(row.place[0], table.number(kFx));
    VOLUTE_ASSIGN(row.place[1], table.number(kFy));
    if (table.has(kFz) && !height) {
      VOLUTE_ASSIGN(row.place[2], table.number(kFz));
    }
    return walks.add(row, table.where());
  }));
  if (walks.empty())
    return nobody(file, "lines 'id frame x y z'");
  if (!(rate > 0)) {
    return fail(ErrorCode::kInvalidData,
                "{}: no frame rate; expected a line '# framerate: 8.00 fps' with frames a second",
                file);
  }
  return {};
}

/// JuPedSim's SQLite database: positions by frame, and the frame rate among its metadata.
Status readDatabase(std::string_view bytes, std::string_view file, Walks& walks, double& rate) {
  for (const char* end : {"-wal", "-journal"}) {
    std::error_code code;
    const auto size = std::filesystem::file_size(std::string(file) + end, code);
    if (!code && size > 0) {
      return fail(ErrorCode::kInvalidData,
                  "{}: {}{} has changes that are not in it yet: end the program that writes it",
                  file, std::filesystem::path(file).filename().string(), end);
    }
  }
  VOLUTE_ASSIGN(const auto database, SqliteFile::open(bytes, file));
  constexpr std::string_view kMetadata[] = {"key", "value"};
  VOLUTE_TRY(database.forEachRow("metadata", kMetadata, [&](auto row) -> Status {
    const auto* key = std::get_if<std::string>(&row[0]);
    if (key == nullptr || *key != "fps")
      return {};
    const double earlier = rate;
    if (const auto* text = std::get_if<std::string>(&row[1]))
      rate = finiteNumber(*text).value_or(0);
    else if (const auto* number = std::get_if<double>(&row[1]))
      rate = *number;
    else if (const auto* whole = std::get_if<std::int64_t>(&row[1]))
      rate = static_cast<double>(*whole);
    return earlier == 0 || earlier == rate ? Status() : secondRate(file, rate, earlier);
  }));
  if (!(rate > 0) || !std::isfinite(rate)) {
    return fail(ErrorCode::kInvalidData,
                "{}: its table 'metadata' has no frame rate; expected the key 'fps'", file);
  }
  walks.zIs = HeightOf::kNothing;
  constexpr std::string_view kColumns[] = {"id", "frame", "pos_x", "pos_y"};
  VOLUTE_TRY(database.forEachRow("trajectory_data", kColumns, [&](auto row) -> Status {
    std::array<double, 4> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (const auto* number = std::get_if<double>(&row[i]))
        values[i] = *number;
      else if (const auto* whole = std::get_if<std::int64_t>(&row[i]))
        values[i] = static_cast<double>(*whole);
      else
        return fail(ErrorCode::kInvalidData, "{}: trajectory_data: {} is no number", file,
                    kColumns[i]);
    }
    if (!(std::abs(values[0]) <= kLargestId) || values[0] != std::floor(values[0]))
      return fail(ErrorCode::kInvalidData, "{}: trajectory_data: id {}; expected a whole number",
                  file, values[0]);
    return walks.add({static_cast<int>(values[0]), values[1], {values[2], values[3], 0}, {}}, file);
  }));
  return walks.empty() ? nobody(file, "rows in its table 'trajectory_data'") : Status{};
}

/// Whether the first line that is no remark names columns.
bool hasNames(std::string_view text) {
  bool named = false;
  (void)forEachRow(text, [&](std::string_view line, int) -> Status {
    if (line.empty() || line.starts_with('#'))
      return {};
    const char c = line.front() == '"' && line.size() > 1 ? line[1] : line.front();
    named = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    return fail(ErrorCode::kCancelled, "enough");  // the other lines do not matter
  });
  return named;
}

}  // namespace

Result<Trajectories> Trajectories::parse(std::string_view text, std::string_view file,
                                         std::optional<double> height, double eyeHeight) {
  Walks walks(file, height, eyeHeight);
  Trajectories result;
  double rate = 0;
  if (SqliteFile::isOne(text)) {
    VOLUTE_TRY(readDatabase(text, file, walks, rate));
  } else if (hasNames(text)) {
    VOLUTE_TRY(readPeopleTable(text, file, height, walks, result.remarks_));
    rate = 1;
  } else {
    VOLUTE_TRY(readFrames(text, file, height, walks, rate));
  }
  VOLUTE_TRY(walks.checkSpeeds(rate));
  result.aboveFloors_ = walks.areAboveFloors();
  for (Remark& remark : walks.remarks()) result.remarks_.push_back(std::move(remark));
  walks.give(rate, [&](int id, const std::vector<std::pair<double, Vec3>>& list) {
    std::vector<Step> steps;
    for (const auto& [time, eye] : list) steps.push_back({time, eye});
    result.add(id, std::move(steps));
  });
  return result;
}

}  // namespace volute
