// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/visibility/plan_areas.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>

#include "volute/base/plain_number.hpp"
#include "volute/base/write_file.hpp"
#include "volute/report/csv_cell.hpp"
#include "volute/report/page.hpp"
#include "volute/visibility/rooms.hpp"

namespace volute {
namespace {

std::string_view nameOf(NamedArea::Kind kind) {
  return kind == NamedArea::Kind::kArea    ? "area"
         : kind == NamedArea::Kind::kRoute ? "route"
                                           : "exit";
}

double polygonSize(std::span<const Vec2> polygon) {
  double sum = 0;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++)
    sum += polygon[j].x() * polygon[i].y() - polygon[i].x() * polygon[j].y();
  return 0.5 * std::abs(sum);
}

/// The eyes in what somebody names.
Status addNamed(const Survey& survey, std::span<const Vec3> eyes, Progress& progress,
                PlanAreas& areas) {
  const double height = survey.height, square = survey.step * survey.step;
  for (const NamedArea& named : survey.areas) {
    if (!named.isAt(height))
      continue;
    PlanAreas::Area area{named.name,  std::string(nameOf(named.kind)), named.storey, 0, named.rset,
                         named.people};
    std::vector<bool> in(eyes.size());
    for (const std::string& member : named.members) {
      for (const PlanAreas::Area& other : areas.areas) {
        if (other.name != member)
          continue;
        for (const std::size_t eye : other.eyes) in[eye] = true;
      }
    }
    for (std::size_t i = 0; i < eyes.size(); ++i) {
      if (!named.outline.empty() && named.contains(eyes[i].head<2>()))
        in[i] = true;
      if (in[i])
        area.eyes.push_back(i);
    }
    area.size = static_cast<double>(area.eyes.size()) * square;
    if (named.kind == NamedArea::Kind::kArea)
      area.size = polygonSize(named.outline);
    if (area.eyes.empty()) {
      return fail(ErrorCode::kInvalidArgument,
                  "areas: {} '{}' holds no point of the plan at z = {} m, whose points are {:g} m "
                  "apart; the case is from x, y = {}, {} to {}, {} m: expected an {} within "
                  "it, and larger than the points' distance",
                  area.kind, area.name, plainNumber(height), survey.step,
                  plainNumber(survey.bounds.min.x()), plainNumber(survey.bounds.min.y()),
                  plainNumber(survey.bounds.max.x()), plainNumber(survey.bounds.max.y()),
                  area.kind);
    }
    Vec2 low = named.outline.empty() ? eyes.front().head<2>() : named.outline.front(), high = low;
    for (const Vec2& point : named.outline) {
      low = low.cwiseMin(point);
      high = high.cwiseMax(point);
    }
    constexpr double kBeyond = 0.5;  // [m], as thick as a wall
    const double beyond = std::max((survey.bounds.min.head<2>() - low).maxCoeff(),
                                   (high - survey.bounds.max.head<2>()).maxCoeff());
    if (beyond > kBeyond)
      progress.remark(
          {RemarkCode::kDoubtful,
           fmt::format("{} '{}' reaches {:.3g} m beyond the case", area.kind, area.name, beyond)});
    if (named.kind == NamedArea::Kind::kArea) {
      for (const std::size_t eye : area.eyes) areas.of[eye] = static_cast<int>(areas.areas.size());
    }
    areas.areas.push_back(std::move(area));
  }
  return {};
}

/// The eyes in rooms, as far as no named area has them.
void addRooms(const Survey& survey, const Rooms& rooms, std::span<const Vec3> eyes,
              PlanAreas& areas) {
  constexpr double kSliver = 0.25;  // of a room: what is left of it when areas were drawn over it
  std::vector<std::vector<std::size_t>> own(rooms.rooms.size());
  std::vector<std::vector<std::size_t>> all(rooms.rooms.size());
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const int room = rooms.at(eyes[i].head<2>(), survey.step);
    if (room < 0)
      continue;
    all[static_cast<std::size_t>(room)].push_back(i);
    if (areas.of[i] < 0)
      own[static_cast<std::size_t>(room)].push_back(i);
  }
  std::vector<int> place(rooms.rooms.size(), -1);  // of what has most of a room
  for (std::size_t r = 0; r < rooms.rooms.size(); ++r) {
    const auto share = static_cast<double>(own[r].size()) / static_cast<double>(all[r].size());
    if (all[r].empty())
      continue;
    if (share < kSliver) {
      std::vector<std::size_t> counts(areas.areas.size());
      for (const std::size_t eye : all[r]) {
        if (areas.of[eye] >= 0)
          ++counts[static_cast<std::size_t>(areas.of[eye])];
      }
      place[r] = static_cast<int>(std::ranges::max_element(counts) - counts.begin());
      continue;
    }
    place[r] = static_cast<int>(areas.areas.size());
    for (const std::size_t eye : own[r]) areas.of[eye] = place[r];
    areas.areas.push_back({fmt::format("room {}", r + 1), "room", "", share * rooms.rooms[r].area,
                           std::nullopt, true, rooms.rooms[r].outside, std::move(own[r])});
  }
  for (const Rooms::Door& door : rooms.doors) {
    const int first = place[static_cast<std::size_t>(door.first)];
    const int second = place[static_cast<std::size_t>(door.second)];
    if (first >= 0 && second >= 0 && first != second)
      areas.doors.push_back({static_cast<std::size_t>(first), static_cast<std::size_t>(second),
                             door.place, door.width, door.shut});
  }
}

/// Light enough for names on them.
Rgb areaColor(std::size_t area) {
  static const std::array<Rgb, 7> colors{
      Rgb(0.34, 0.71, 0.91), Rgb(0.90, 0.62, 0.0), Rgb(0.0, 0.62, 0.45), Rgb(0.94, 0.89, 0.26),
      Rgb(0.0, 0.45, 0.70),  Rgb(0.84, 0.37, 0.0), Rgb(0.80, 0.47, 0.65)};
  return 0.5 * colors[area % colors.size()] + Rgb::Constant(0.5);
}

/// One part and what is told of it.
class AreaReport {
 public:
  AreaReport(const Survey& survey, const PlanAreas& areas, const AreaFindings& found)
      : survey_(survey), areas_(areas), found_(found) {}

  Json json(std::size_t a) const {
    const PlanAreas::Area& area = areas_.areas[a];
    const auto people = peopleIn(area);
    Json json = {{"name", area.name},
                 {"kind", area.kind},
                 {"storey", area.storey.empty() ? Json() : Json(area.storey)},
                 {"floor_area", area.size},
                 {"points", area.eyes.size()},
                 {"people", people.size()},
                 {"counted", area.people}};
    if (area.kind == "room")
      json["opens_outside"] = area.outside;
    const FirstLoss first = firstLoss(*found_.all, survey_.round, people);
    const FirstLoss late = firstLoss(*found_.latest, survey_.round, people);
    json["aset"] = verdictJson(area.kind + " " + area.name, sentence(area, first, late, people),
                               first, survey_.round, found_.eyes);
    json["aset"]["time_latest"] = latestJson(late, survey_.round);
    json["aset"]["by"] = first.any && !found_.by.empty() ? Json(found_.by[first.place]) : Json();
    if (people.empty())
      json["aset"]["known"] = nullptr;  // there is nobody to ask for
    json["criteria"] = Json::array();
    for (const auto& [name, times, holds, latest] : found_.single) {
      std::vector<std::size_t> places;
      std::ranges::copy_if(people, std::back_inserter(places), [&, &holds = holds](std::size_t i) {
        return holds.empty() || holds[i];
      });
      const FirstLoss one = firstLoss(*times, survey_.round, places);
      Json of = verdictJson(name, "", one, survey_.round, found_.eyes);
      of.erase("sentence");
      of["applies"] = !places.empty();
      of["time_latest"] = latestJson(
          latest == nullptr ? one : firstLoss(*latest, survey_.round, places), survey_.round);
      json["criteria"].push_back(std::move(of));
    }
    if (found_.margins == nullptr)
      return json;
    const auto worst = found_.margins->worst(people);
    json["margin"] = {{"points_needed", worst.needed},
                      {"points_too_late", worst.tooLate},
                      {"points_not_known", worst.unknown},
                      {"known", worst.unknown == 0},
                      {"value", nullptr},
                      {"rset", nullptr}};
    if (worst.unknown == 0 && worst.place) {
      json["margin"]["value"] = jsonNumber(found_.margins->margin[*worst.place]);
      json["margin"]["rset"] = jsonNumber(found_.margins->rset[*worst.place]);
    } else if (worst.needed > 0) {
      json["margin"]["rset"] = jsonNumber(found_.margins->longest(people));
    }
    if (worst.unknown > 0 && worst.place && std::isfinite(found_.margins->margin[*worst.place]))
      json["margin"]["at_most"] = found_.margins->margin[*worst.place];
    return json;
  }

 private:
  std::vector<std::size_t> peopleIn(const PlanAreas::Area& area) const {
    std::vector<std::size_t> people;
    for (const std::size_t eye : area.eyes) {
      if (found_.people[eye] || !area.people)
        people.push_back(eye);
    }
    return people;
  }

  std::string sentence(const PlanAreas::Area& area, const FirstLoss& first, const FirstLoss& late,
                       std::span<const std::size_t> people) const {
    std::string text = fmt::format("{}{} '{}'", static_cast<char>(std::toupper(area.kind[0])),
                                   area.kind.substr(1), area.name);
    if (people.empty())
      return text + ": no place of it is one where people are.";
    const std::string by =
        first.any && !found_.by.empty() ? ", by " + found_.by[first.place] : std::string();
    if (!first.certain()) {
      text += fmt::format(
          ": ASET {}{}", unknownWords(first, "reached", "its floor"),
          first.any ? fmt::format("; it is at the latest {} s{}", plainNumber(first.up, 4), by)
                    : "");
    } else if (first.any) {
      text += fmt::format(": ASET {}{}, at {}", timeWords(first, survey_.round), by,
                          placeWords(found_.eyes[first.place]));
    } else {
      text += fmt::format(": no criterion is reached until {} s", plainNumber(survey_.end));
    }
    return text + marginWords(people) + "." + latestWords(first, late, "reached");
  }

  std::string marginWords(std::span<const std::size_t> people) const {
    if (found_.margins == nullptr)
      return "";
    const PlanMargins& margins = *found_.margins;
    const auto worst = margins.worst(people);
    if (worst.needed == 0)
      return "; nobody needs it";
    if (worst.unknown > 0)
      return fmt::format(
          "; its margin is not known at {} of the points in use{}",
          percentWords(static_cast<double>(worst.unknown) / static_cast<double>(worst.needed)),
          worst.tooLate == 0 ? ""
                             : fmt::format(", and {} s at others: too late",
                                           plainNumber(margins.margin[*worst.place], 4)));
    const double least = margins.margin[*worst.place];
    if (std::isinf(least))
      return "; nobody is there afterwards";
    return fmt::format("; ASET - RSET is {} s ({} s needed){}", plainNumber(least, 4),
                       plainNumber(margins.rset[*worst.place], 4), least < 0 ? ": too late" : "");
  }

  const Survey& survey_;
  const PlanAreas& areas_;
  const AreaFindings& found_;
};

std::string timeCell(const Json& verdict) {
  if (verdict.value("applies", true) == false)
    return "\u2013";
  if (verdict["time"].is_number())
    return htmlOf(verdict["time"]);
  const Json& known = verdict["known"];
  if (known == true)
    return "not reached";
  const std::string latest = verdict.contains("at_the_latest")
                                 ? ", at the latest " + htmlOf(verdict["at_the_latest"])
                                 : "";
  return (known == false ? "<b>not known</b>" : "<b>not known</b> after " + htmlOf(known)) + latest;
}

std::string unknownMargin(const Json& margin) {
  return "<b>not known</b>" +
         (margin.contains("at_most") ? ", at most " + htmlOf(margin["at_most"]) : std::string());
}

std::string areaTable(const Json& areas, bool margins) {
  HtmlRow head{"room or area", "floor [m2]", "ASET [s]", "by"};
  if (margins)
    head.insert(head.end(), {"RSET [s]", "margin [s]"});
  if (!areas.empty()) {
    for (const Json& one : areas[0]["criteria"]) head.push_back(htmlOf(one["criterion"]) + " [s]");
  }
  std::vector<HtmlRow> rows;
  for (const Json& area : areas) {
    HtmlRow row{
        htmlOf(area["name"]) +
            (area["kind"] == "room" || area["kind"] == "area" ? ""
                                                              : " (" + htmlOf(area["kind"]) + ")") +
            (area["counted"] == true ? "" : " (not counted)"),
        htmlOf(area["floor_area"], "{:.1f}")};
    if (area["people"] == 0 && area["counted"] == true) {
      row.emplace_back("nobody is there");
      row.resize(head.size());
      rows.push_back(std::move(row));
      continue;
    }
    row.push_back(timeCell(area["aset"]));
    row.push_back(htmlOf(area["aset"]["by"]));
    if (margins) {
      const Json& margin = area["margin"];
      row.push_back(htmlOf(margin["rset"]));
      row.push_back(margin["known"] == false       ? unknownMargin(margin)
                    : margin["points_needed"] == 0 ? "\u2013"
                    : margin["value"].is_null()    ? "not reached"
                                                   : htmlOf(margin["value"]));
    }
    for (const Json& one : area["criteria"]) row.push_back(timeCell(one));
    rows.push_back(std::move(row));
  }
  return htmlTable(head, rows, HtmlAlign::kNumbers);
}

std::string knownCell(const Json& known) {
  if (known.is_null())
    return "nobody is there";
  return known == true ? "yes" : (known == false ? "no" : "until " + known.dump());
}

/// Empty: not known, or not reached; a column says which.
std::string csvOf(const Json& areas) {
  const auto number = [](const Json& json) { return json.is_number() ? json.dump() : ""; };
  std::string text =
      "name,kind,storey,floor_area,points,people,aset,aset_known,aset_at_the_latest,aset_latest,by,"
      "x,y,z,rset,margin,margin_known,margin_at_most";
  if (!areas.empty()) {
    for (const Json& one : areas[0]["criteria"]) {
      const std::string name = one["criterion"].get<std::string>();
      text += "," + csvCell("aset_" + name) + "," + csvCell("aset_" + name + "_known") + "," +
              csvCell("aset_" + name + "_latest");
    }
  }
  text += "\n";
  for (const Json& area : areas) {
    const Json& aset = area["aset"];
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{}",
                        csvCell(area["name"].get<std::string>()), area["kind"].get<std::string>(),
                        area["storey"].is_null() ? "" : csvCell(area["storey"].get<std::string>()),
                        area["floor_area"].dump(), area["points"].dump(), area["people"].dump(),
                        number(aset["time"]), knownCell(aset["known"]),
                        number(aset.value("at_the_latest", Json())), number(aset["time_latest"]),
                        aset["by"].is_null() ? "" : csvCell(aset["by"].get<std::string>()));
    for (std::size_t axis = 0; axis < 3; ++axis)
      text += "," + (aset.contains("position") ? aset["position"][axis].dump() : "");
    if (area.contains("margin")) {
      const Json& margin = area["margin"];
      text += fmt::format(",{},{},{},{}", number(margin["rset"]), number(margin["value"]),
                          knownCell(margin["known"]), number(margin.value("at_most", Json())));
    } else {
      text += ",,,,";
    }
    for (const Json& one : area["criteria"])
      text += "," + number(one["time"]) + "," + knownCell(one["known"]) + "," +
              number(one["time_latest"]);
    text += "\n";
  }
  return text;
}

/// When something may be reached in an area, for order.
double reachedFrom(const Json& aset) {
  if (aset["known"].is_number())
    return aset["known"].get<double>();
  if (aset["known"] == false)
    return -std::numeric_limits<double>::infinity();
  return aset["time"].is_number() ? aset["time"].get<double>()
                                  : std::numeric_limits<double>::infinity();
}

/// The first of the rooms; where there are several.
void addFirstRoom(const Json& areas, Json& verdict) {
  const Json* first = nullptr;
  std::size_t rooms = 0, kept = 0;
  for (const Json& area : areas) {
    if (area["kind"] != "room" || area["people"] == 0)
      continue;
    ++rooms;
    kept += std::isinf(reachedFrom(area["aset"])) && reachedFrom(area["aset"]) > 0;
    if (first == nullptr || reachedFrom(area["aset"]) < reachedFrom((*first)["aset"]))
      first = &area;
  }
  if (rooms < 2 || kept == rooms)
    return;
  Json one = (*first)["aset"];
  one["criterion"] = "rooms";
  one["sentence"] =
      fmt::format("Of {} rooms the first is {}{}", rooms,
                  one["sentence"].get<std::string>().substr(std::string_view("Room ").size()),
                  kept > 0 ? fmt::format(" In {} of them no criterion is reached.", kept) : "");
  verdict.push_back(std::move(one));
}

Json doorsJson(const PlanAreas& areas) {
  Json doors = Json::array();
  for (const PlanAreas::Door& door : areas.doors) {
    doors.push_back({{"between", {areas.areas[door.first].name, areas.areas[door.second].name}},
                     {"position", {door.place.x(), door.place.y()}},
                     {"width", door.width},
                     {"shut_at_times", door.shut}});
  }
  return doors;
}

/// Required times of rooms and areas by their names.
Status addRequired(const Survey& survey, double height, Progress& progress, PlanAreas& areas) {
  if (!survey.rset || survey.rset->areas().empty())
    return {};
  std::string missing, names;
  std::size_t found = 0;
  for (const auto& [name, seconds] : survey.rset->areas()) {
    const auto area = std::ranges::find(areas.areas, name, &PlanAreas::Area::name);
    if (area != areas.areas.end()) {
      if (area->rset && *area->rset != seconds) {
        return failFor("rset", ErrorCode::kInvalidArgument,
                       "'{}' has {} s in the table and {} s of its own; expected one time for "
                       "each area",
                       name, plainNumber(seconds), plainNumber(*area->rset));
      }
      area->rset = seconds;
      ++found;
    } else if (std::ranges::none_of(survey.areas, [&, &name = name](const NamedArea& one) {
                 return one.name == name && !one.isAt(height);
               })) {
      missing += (missing.empty() ? "'" : ", '") + name + "'";
    }
  }
  if (missing.empty())
    return {};
  for (const PlanAreas::Area& area : areas.areas) names += (names.empty() ? "" : ", ") + area.name;
  if (found > 0) {
    progress.remark(
        {RemarkCode::kDoubtful,
         fmt::format("rset: no room or area of the plan at z = {} m is named {}; it has {}",
                     plainNumber(height), missing, names)});
    return {};
  }
  return failFor("rset", ErrorCode::kInvalidArgument,
                 "no room or area of the plan at z = {} m is named {}; expected some of {}",
                 plainNumber(height), missing, names);
}

}  // namespace

std::vector<double> PlanAreas::sizes() const {
  std::vector<double> sizes(of.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < of.size(); ++i) {
    if (of[i] >= 0)
      sizes[i] = areas[static_cast<std::size_t>(of[i])].size;
  }
  return sizes;
}

Result<PlanAreas> planAreas(const Survey& survey, const SightSnapshot& first,
                            std::span<const Vec3> eyes, Progress& progress) {
  PlanAreas areas;
  areas.of.assign(eyes.size(), -1);
  VOLUTE_TRY(addNamed(survey, eyes, progress, areas));
  addRooms(survey, findRooms(first, survey.bounds, survey.height), eyes, areas);
  VOLUTE_TRY(addRequired(survey, survey.height, progress, areas));
  return areas;
}

PlanMargins::Worst PlanMargins::worst(std::span<const std::size_t> places) const {
  Worst worst;
  for (const std::size_t i : places) {
    if (std::isnan(rset[i]))
      continue;
    ++worst.needed;
    worst.tooLate += margin[i] < 0;
    if (std::isnan(margin[i])) {
      if (least[i] >= 0)
        continue;  // people have left while the air is known
      ++worst.unknown;
      if (!worst.open || least[i] < least[*worst.open])
        worst.open = i;
    } else if (!worst.place || margin[i] < margin[*worst.place]) {
      worst.place = i;
    }
  }
  return worst;
}

double PlanMargins::longest(std::span<const std::size_t> places) const {
  double longest = std::numeric_limits<double>::quiet_NaN();
  for (const std::size_t i : places) longest = std::fmax(longest, rset[i]);
  return longest;
}

PlanMargins planMargins(std::vector<double> rset, const LossTimes& aset, RoundTime round,
                        double end) {
  PlanMargins margins{std::move(rset), {}, {}};
  margins.margin.assign(margins.rset.size(), std::numeric_limits<double>::quiet_NaN());
  margins.least = margins.margin;
  const std::vector<double>& by = aset.by(round);
  for (std::size_t i = 0; i < margins.rset.size(); ++i) {
    if (std::isnan(margins.rset[i]))
      continue;
    const bool reached = aset.complete(i) && !std::isinf(by[i]);
    margins.least[i] = (reached ? by[i] : std::min(aset.known[i], end)) - margins.rset[i];
    if (aset.complete(i) && (reached || margins.least[i] >= 0))
      margins.margin[i] = by[i] - margins.rset[i];
  }
  return margins;
}

Result<std::string> reportAreas(const Survey& survey, const PlanAreas& areas,
                                const AreaFindings& found, PlanPicture picture,
                                const PlanValues& values, Json& report, Json& verdict) {
  const AreaReport one(survey, areas, found);
  Json list = Json::array();
  for (std::size_t a = 0; a < areas.areas.size(); ++a) list.push_back(one.json(a));
  report["doors"] = doorsJson(areas);
  std::vector<Json> of;
  for (const int area : areas.of)
    of.push_back(area < 0 ? Json() : Json(areas.areas[static_cast<std::size_t>(area)].name));
  report["area_rows"] = values.rowsOfJson(of);
  for (const Json& area : list) {
    if (area["kind"] != "room")
      verdict.push_back(area["aset"]);
  }
  addFirstRoom(list, verdict);
  VOLUTE_TRY(writeFile(survey.folder / "areas.csv", csvOf(list)));
  picture.title = fmt::format("Rooms and areas at z = {} m", plainNumber(values.plan->origin[2]));
  for (std::size_t a = 0; a < areas.areas.size(); ++a) {
    picture.kinds.emplace_back(areaColor(a), "");
    Vec2 middle = Vec2::Zero();
    for (const std::size_t eye : areas.areas[a].eyes) middle += found.eyes[eye].head<2>();
    middle /= static_cast<double>(std::max<std::size_t>(1, areas.areas[a].eyes.size()));
    // A ring's middle is in another room: its own point that is nearest.
    const auto nearest = std::ranges::min_element(areas.areas[a].eyes, {}, [&](std::size_t eye) {
      return (found.eyes[eye].head<2>() - middle).squaredNorm();
    });
    if (nearest != areas.areas[a].eyes.end())
      middle = found.eyes[*nearest].head<2>();
    if (areas.areas[a].kind == "room" || areas.areas[a].kind == "area")
      picture.labels.emplace_back(middle, areas.areas[a].name);
  }
  for (std::size_t i = 0; i < values.places.size(); ++i) {
    picture.values[values.places[i]] = std::max(areas.of[i], 0);
    picture.marks[values.places[i]] = areas.of[i] < 0 ? PlanMark::kFloor : PlanMark::kValue;
  }
  picture.words = {{PlanMark::kFloor, "in no room or area"}, {PlanMark::kSolid, kSolidWords}};
  VOLUTE_TRY(writePlan(survey.folder / "areas.png", *values.plan, picture, {}));
  VOLUTE_ASSIGN(const auto figure,
                htmlFigure(survey.folder / "areas.png",
                           "Rooms as the plan's narrow passages divide it, and named areas."));
  const std::string page =
      "<h2>Rooms and areas</h2>\n" + areaTable(list, found.margins != nullptr) + figure;
  report["areas"] = std::move(list);
  return page;
}

}  // namespace volute
