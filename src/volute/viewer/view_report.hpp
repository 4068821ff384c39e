// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "volute/image/image.hpp"
#include "volute/viewer/document.hpp"

namespace volute {

class Playback;
class ViewerDocument;
class ViewerView;

/// A page about what the window shows.
struct ReportOrder {
  std::filesystem::path target;                             ///< .html
  Image picture;                                            ///< as it was shown
  std::vector<std::pair<std::string, std::string>> view{};  ///< name and value
};

/// The first volute_0001.html ... of a folder that is free.
std::filesystem::path freeReportName(const std::filesystem::path& folder);

/// Writes the page while the window goes on: files are read whole for their SHA-256. What it says
/// is of the time when it was asked for.
class ReportJob {
 public:
  explicit ReportJob(ReportOrder order) : order_(std::move(order)) {}

  /// Stops it: no page appears unless done() said so.
  ~ReportJob();
  ReportJob(const ReportJob&) = delete;
  ReportJob& operator=(const ReportJob&) = delete;

  void stop() { ends_ = true; }

  /// Once, and of no effect after stop(). Any thread.
  void begin(DocumentInfo document, std::vector<std::filesystem::path> files);

  const std::filesystem::path& target() const { return order_.target; }

  bool done() const { return done_; }

  /// After done().
  const Status& status() const { return status_; }

  /// Share of the files' bytes that was copied, 0..1.
  double share() const { return share_; }

  /// By what it took so far [s]; nothing where that says little yet.
  std::optional<double> secondsLeft() const;

 private:
  [[nodiscard]] Status write();
  [[nodiscard]] Result<std::string> filesTable();

  ReportOrder order_;
  DocumentInfo document_;
  std::vector<std::filesystem::path> files_;
  std::atomic<bool> ends_ = false, done_ = false;
  std::atomic<double> share_ = 0;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  Status status_;
  std::thread thread_;  // last: it uses the others
};

/// The report that a person asked for, about what is open as it is now; one at a time.
class ViewReport {
 public:
  ViewReport(ViewerDocument& document, const ViewerView& view, Playback& playback)
      : document_(document), view_(view), playback_(playback) {}

  /// Into the current folder. @param picture  of what is shown
  void begin(Image picture);

  void stop();

  /// Null: none is being written.
  const ReportJob* job() const { return job_.get(); }

  /// To be called in every frame: says that one is written.
  void update();

 private:
  ViewerDocument& document_;
  const ViewerView& view_;
  Playback& playback_;
  std::shared_ptr<ReportJob> job_;
};

}  // namespace volute
