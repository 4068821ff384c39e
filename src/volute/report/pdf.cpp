// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/pdf.hpp"

#include <unistd.h>

#include <string>
#include <vector>

#include "volute/base/program.hpp"

namespace volute {

Status printPdf(const std::filesystem::path& html, const std::filesystem::path& pdf) {
  const std::string browser = findProgram({"chromium", "chromium-browser", "google-chrome"});
  if (browser.empty()) {
    return fail(
        ErrorCode::kUnsupported,
        "no PDF without chromium, chromium-browser or google-chrome in the PATH; report.html "
        "can be printed from any browser");
  }
  std::error_code error;
  const ScratchFolder folder;
  if (folder.path().empty())
    return fail(ErrorCode::kIo, "no folder for temporary files: the browser needs one");
  std::vector<std::string> words{browser,
                                 "--headless",
                                 "--disable-gpu",
                                 "--disable-quic",
                                 "--disable-sync",
                                 "--disable-extensions",
                                 "--disable-background-networking",
                                 "--disable-component-update",
                                 "--no-first-run",
                                 "--host-resolver-rules=MAP * ~NOTFOUND",
                                 "--user-data-dir=" + folder.path().string(),
                                 "--no-pdf-header-footer",
                                 "--print-to-pdf=" + std::filesystem::absolute(pdf, error).string(),
                                 "file://" + std::filesystem::absolute(html, error).string()};
  if (::geteuid() == 0)
    words.insert(words.begin() + 1, "--no-sandbox");  // which root cannot have
  constexpr double kLongest = 120;                    // [s]
  const bool ended = runProgram(words, {.seconds = kLongest});
  if (!std::filesystem::exists(pdf, error)) {
    return fail(ErrorCode::kIo, "{}: {} made no PDF of report.html{}", pdf.filename().string(),
                browser, ended ? "" : " within two minutes");
  }
  return {};
}

}  // namespace volute
