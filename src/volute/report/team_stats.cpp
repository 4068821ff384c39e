// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/team_stats.hpp"

#include <nlohmann/json.hpp>

#include "volute/base/process_usage.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson statsOf(const Team& team) {
  OrderedJson units = OrderedJson::object();
  OrderedJson stages = OrderedJson::object();
  for (const UnitRecord& record : team.units()) {
    units[record.stage] = record.units;
    stages[record.stage] = {{"seconds", record.seconds}, {"cpu_seconds", record.cpuSeconds}};
  }
  return {{"rank", team.rank()},
          {"host", team.host()},
          {"units", std::move(units)},
          {"stages", std::move(stages)},
          {"waited_seconds", team.waited()},
          {"cpu_seconds", cpuSeconds()},
          {"peak_memory_bytes", peakMemoryBytes()}};
}

}  // namespace

Result<OrderedJson> teamStats(Team& team) {
  VOLUTE_ASSIGN(const auto all, team.gatherTexts(statsOf(team).dump()));
  OrderedJson ranks = OrderedJson::array();
  for (const std::string& text : all) ranks.push_back(OrderedJson::parse(text));
  return ranks;
}

}  // namespace volute
