// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/context.hpp"

#include <cstdio>

#include "volute/base/interrupt.hpp"
#include "volute/base/printable.hpp"
#include "volute/cli/console.hpp"

namespace volute::cli {

void Context::print(const Report& report) const {
  print(json ? dumpJson(report.json()) : report.text());
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
