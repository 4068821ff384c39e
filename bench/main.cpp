// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What `volute bench` runs; the command's options are declared in volute/cli/commands/bench.cpp.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/benchmark.hpp"
#include "volute/base/parallel.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/program.hpp"

namespace volute::bench {
namespace {

using cli::Arguments, cli::Context;

std::string listText() {
  std::string text;
  for (const Benchmark& benchmark : benchmarks()) {
    text += fmt::format("{:<12}  {}\n", benchmark.name, benchmark.description);
  }
  return text;
}

/// A line of the table; names longer than the column push the others aside.
std::string rowText(const BenchRow& row) {
  constexpr int kNameWidth = 76;
  std::string line =
      fmt::format("  {:<{}}  {:>12} {:<9}{:<8}  {}", row.name, kNameWidth,
                  std::isnan(row.value) ? std::string("-") : fmt::format("{:.5g}", row.value),
                  row.unit, row.ratio ? fmt::format("  {:.3g}x", *row.ratio) : "", row.note);
  line.erase(line.find_last_not_of(' ') + 1);
  return line + '\n';
}

nlohmann::ordered_json tableJson(const Benchmark& benchmark, const BenchRows& rows) {
  auto list = nlohmann::ordered_json::array();
  for (const BenchRow& row : rows.all()) {
    list.push_back({{"name", row.name}, {"value", jsonNumber(row.value)}, {"unit", row.unit}});
    list.back()["ratio"] = row.ratio ? jsonNumber(*row.ratio) : nlohmann::ordered_json();
    for (const auto& [key, value] : row.labels) list.back()["labels"][key] = value;
    if (!row.note.empty())
      list.back()["note"] = row.note;
  }
  return {
      {"name", benchmark.name}, {"description", benchmark.description}, {"rows", std::move(list)}};
}

Result<std::vector<const Benchmark*>> chosen(const std::vector<std::string>& names) {
  std::vector<const Benchmark*> list;
  for (const Benchmark& benchmark : benchmarks()) {
    if (names.empty())
      list.push_back(&benchmark);
  }
  for (const auto& name : names) {
    const auto found = std::ranges::find(benchmarks(), name, &Benchmark::name);
    if (found == benchmarks().end()) {
      std::vector<std::string_view> known;
      for (const Benchmark& benchmark : benchmarks()) known.push_back(benchmark.name);
      return fail(ErrorCode::kInvalidArgument, "there is no benchmark '{}'; expected one of {}",
                  name, fmt::join(known, ", "));
    }
    list.push_back(&*found);
  }
  return list;
}

/// An option that no chosen benchmark reads.
Status refuseIdle(const Arguments& arguments, const std::vector<const Benchmark*>& list) {
  struct Use {
    const char* option;
    std::vector<std::string_view> benchmarks;
  };

  const Use uses[] = {{"input", {"codec", "tomography", "smoke", "sparse", "gl"}},
                      {"truth", {"tomography"}},
                      {"field", {"tomography"}},
                      {"peers", {"codec"}},
                      {"whole-pictures", {"smoke"}},
                      {"only", {"light"}}};
  for (const auto& [option, names] : uses) {
    const bool used = std::ranges::any_of(list, [&](const Benchmark* benchmark) {
      return std::ranges::find(names, benchmark->name) != names.end();
    });
    if (arguments.given(option) && !used)
      return fail(ErrorCode::kInvalidArgument, "--{} has no effect: it is for {}", option,
                  fmt::join(names, ", "));
  }
  return {};
}

Status run(const Arguments& arguments, Context& context) {
  if (arguments.flag("list")) {
    context.print(listText());
    return {};
  }
  VOLUTE_ASSIGN(const auto list, chosen(arguments.positionals()));
  VOLUTE_TRY(refuseIdle(arguments, list));
  const BenchInput input{arguments.find<std::string>("input").value_or(""),
                         context.maxMemory,
                         arguments.find<std::string>("truth").value_or(""),
                         arguments.find<std::string>("field").value_or(""),
                         arguments.flag("quick"),
                         arguments.flag("whole-pictures"),
                         arguments.find<std::string>("peers").value_or(""),
                         arguments.find<std::string>("only").value_or("")};
  nlohmann::ordered_json json{{"threads", threadCount()},
                              {"benchmarks", nlohmann::ordered_json::array()}};
  for (const Benchmark* benchmark : list) {
    if (context.progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before {}", benchmark->name);
    if (!context.json)
      context.print(fmt::format("{}: {}\n", benchmark->name, benchmark->description));
    BenchRows rows([&](const BenchRow& row) {
      if (!context.json) {
        context.print(rowText(row));
        std::fflush(stdout);
      }
    });
    VOLUTE_TRY(benchmark->run(input, rows, context.progress));
    json["benchmarks"].push_back(tableJson(*benchmark, rows));
  }
  if (context.json)
    context.print(dumpJson(json));
  return {};
}

}  // namespace
}  // namespace volute::bench

int main(int argc, char** argv) {
  volute::cli::Command command = volute::cli::benchCommand();
  command.run = volute::bench::run;
  return volute::cli::runProgram(command, argc, argv);
}
