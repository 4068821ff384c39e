// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "volute/base/input_file.hpp"
#include "volute/base/printable.hpp"

// What VTK says when it cannot read; for the files of the VTK plug-in alone.

namespace volute {

/// One line of what a damaged file may have put into a message.
inline std::string oneLine(std::string text) {
  constexpr std::size_t kMax = 400;
  if (text.size() > kMax)
    text = text.substr(0, kMax) + " ...";
  std::ranges::replace_if(text, [](unsigned char c) { return c < ' ' || c == 0x7F; }, ' ');
  return printable(text);
}

/// Where VTK reports that it could not read: not by return values. Lives in the child process
/// alone.
class ErrorWindow final : public vtkOutputWindow {
 public:
  static ErrorWindow* New();

  vtkTypeMacro(ErrorWindow, vtkOutputWindow)

      void DisplayText(const char*) override {}

  void DisplayErrorText(const char* text) override { note(text); }

  void DisplayWarningText(const char* text) override { note(text); }

  void DisplayGenericWarningText(const char* text) override { note(text); }

  std::string first;

 private:
  /// The last line of VTK's report; the others say where in VTK's sources.
  void note(const char* text) {
    if (!first.empty())
      return;
    std::string all(text);
    all.erase(all.find_last_not_of(" \n") + 1);
    const auto colon = all.rfind("): ");
    first = colon == std::string::npos ? all : all.substr(colon + 3);
    if (first.starts_with("Generic Warning: In ") && first.find('\n') != std::string::npos)
      first.erase(0, first.find('\n') + 1);
    first = oneLine(first);
    if (all.find("returned failure for request") != std::string::npos)
      first = "its numbers do not fit together";
    else if (first.ends_with("may be too short."))
      first += " Or it has what is no finite number.";
  }
};

inline vtkStandardNewMacro(ErrorWindow)

    /// Catches VTK's errors while it lives.
    class ErrorWatch {
 public:
  ErrorWatch() : before_(vtkOutputWindow::GetInstance()) {
    vtkOutputWindow::SetInstance(window_);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);  // some errors are printed past it
  }

  ~ErrorWatch() { vtkOutputWindow::SetInstance(before_); }

  ErrorWatch(const ErrorWatch&) = delete;
  ErrorWatch& operator=(const ErrorWatch&) = delete;

  Status status(const std::string& file) const {
    if (window_->first.empty())
      return {};
    return fail(ErrorCode::kInvalidData,
                "{}: cannot be read: {} (VTK); it is damaged, or has what is not read here", file,
                window_->first);
  }

 private:
  vtkSmartPointer<vtkOutputWindow> before_;  // another watch's, where one reader asks another
  vtkNew<ErrorWindow> window_;
};

/// VTK reads up to the last value and never sees that the end is missing.
inline Status checkEnd(const std::filesystem::path& path) {
  constexpr std::string_view kEnd = "</VTKFile>";
  VOLUTE_ASSIGN(const auto file, InputFile::open(path));
  std::string tail(std::min<std::uint64_t>(file.size(), 64), ' ');
  VOLUTE_TRY(file.read(file.size() - tail.size(), std::as_writable_bytes(std::span(tail))));
  tail.erase(tail.find_last_not_of(" \r\n\t") + 1);
  if (tail.ends_with(kEnd))
    return {};
  return fail(ErrorCode::kTruncated, "{}: does not end in {}; the file is truncated", path.string(),
              kEnd);
}

}  // namespace volute
