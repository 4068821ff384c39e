// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/context.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <span>

#include "volute/base/interrupt.hpp"
#include "volute/base/printable.hpp"
#include "volute/cli/console.hpp"

namespace volute::cli {

namespace {

Json remarkJson(const Remark& remark) {
  return {{"code", remarkName(remark.code)},
          {"sentence", remark.sentence},
          {"file", remark.file},
          {"place", remark.place}};
}

}  // namespace

void Context::print(const Report& report) const {
  json ? printJson(report.json()) : print(report.text());
}

void Context::printJson(Json results) const {
  Json remarks = Json::array();
  for (const Remark& remark : console ? console->remarks() : std::span<const Remark>())
    remarks.push_back(remarkJson(remark));
  // A report of a file has sentences of its own about it.
  for (const Json& own : results.value("remarks", Json::array())) {
    const bool there =
        std::ranges::any_of(remarks, [&](const Json& one) { return one["sentence"] == own; });
    if (!there)
      remarks.push_back(own.is_string() ? remarkJson(Remark(own.get<std::string>())) : own);
  }
  results["remarks"] = std::move(remarks);
  print(dumpJson(results));
}

// fwrite, not fmt: a failure is kept by the stream and reported once, at the end.
void Context::print(std::string_view unclean) const {
  if (silent)
    return;
  if (console)
    console->clear();
  const std::string text = printable(unclean);
  std::fwrite(text.data(), 1, text.size(), resultsToStderr ? stderr : stdout);
}

void Context::watch(const std::filesystem::path& target) {
  Interrupt::watch(target);
}

}  // namespace volute::cli
