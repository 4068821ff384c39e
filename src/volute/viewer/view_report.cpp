// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/view_report.hpp"

#include <fmt/ranges.h>

#include <algorithm>

#include "volute/base/input_file.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/thread_priority.hpp"
#include "volute/base/version.hpp"
#include "volute/io/image_file.hpp"
#include "volute/report/page.hpp"
#include "volute/report/sha256.hpp"
#include "volute/viewer/viewer_view.hpp"

namespace volute {
namespace {

std::string valueOf(const Parameter& parameter) {
  const double first = parameter.value.empty() ? 0 : parameter.value.front();
  if (parameter.kind == Parameter::Kind::kFlag)
    return first != 0 ? "yes" : "no";
  const auto choice = static_cast<std::size_t>(std::max(first, 0.0));
  if (parameter.kind == Parameter::Kind::kChoice && choice < parameter.choices.size())
    return parameter.choices[choice];
  std::string text;
  for (const double value : parameter.value)
    text += (text.empty() ? "" : ", ") + plainNumber(value);
  return parameter.unit.empty() ? text : text + " " + parameter.unit;
}

std::string parameterTable(const std::vector<Parameter>& parameters) {
  std::vector<HtmlRow> rows;
  for (const Parameter& parameter : parameters) {
    rows.push_back({escapedHtml(parameter.group), escapedHtml(parameter.name),
                    escapedHtml(valueOf(parameter)), escapedHtml(parameter.path)});
  }
  return rows.empty() ? ""
                      : "<h2>Settings</h2>\n" +
                            htmlTable({"of", "name", "value", "place in the scene"}, rows);
}

}  // namespace

std::filesystem::path freeReportName(const std::filesystem::path& folder) {
  for (int i = 1;; ++i) {
    const auto path = folder / fmt::format("volute_{:04d}.html", i);
    if (!std::filesystem::exists(path))
      return path;
  }
}

ReportJob::~ReportJob() {
  stop();
  if (thread_.joinable())
    thread_.join();
}

void ReportJob::begin(DocumentInfo document, std::vector<std::filesystem::path> files) {
  if (ends_)
    return;
  document_ = std::move(document), files_ = std::move(files);
  thread_ = std::thread([this] {
    lowerThreadPriority();
    status_ = write();
    done_ = true;
  });
}

std::optional<double> ReportJob::secondsLeft() const {
  constexpr double kTells = 0.05;
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begun_;
  const double share = share_;
  return share < kTells ? std::nullopt : std::optional(spent.count() * (1 - share) / share);
}

Result<std::string> ReportJob::filesTable() {
  constexpr std::size_t kPart = 1 << 20;
  std::vector<InputFile> files;
  double all = 0, read = 0;
  for (const auto& path : files_) {
    if (!std::filesystem::is_regular_file(path))
      continue;
    VOLUTE_ASSIGN(auto file, InputFile::open(path));
    all += static_cast<double>(file.size());
    files.push_back(std::move(file));
  }
  std::vector<HtmlRow> rows;
  std::vector<std::byte> part;
  for (const InputFile& file : files) {
    Sha256 hash;
    for (std::uint64_t at = 0; at < file.size(); at += part.size()) {
      if (ends_)
        return fail(ErrorCode::kCancelled, "{}: stopped", order_.target.string());
      part.resize(std::min<std::uint64_t>(kPart, file.size() - at));
      VOLUTE_TRY(file.read(at, part));
      hash.add(part);
      read += static_cast<double>(part.size());
      share_ = read / all;
    }
    rows.push_back({escapedHtml(file.path().string()), fmt::format("{}", file.size()),
                    "<code>" + hash.finish() + "</code>"});
  }
  return rows.empty() ? "" : "<h2>Files</h2>\n" + htmlTable({"file", "bytes", "SHA-256"}, rows);
}

Status ReportJob::write() {
  VOLUTE_ASSIGN(const auto files, filesTable());
  auto picture = order_.target;
  picture.replace_extension(".picture.png");
  if (const Status drawn = writeImage(picture, order_.picture); !drawn) {
    Error why = drawn.error();  // nobody asked for that file
    if (const auto at = why.message.find(picture.string()); at != std::string::npos)
      why.message.replace(at, picture.string().size(), order_.target.string());
    return tl::unexpected<Error>(std::move(why));
  }
  const auto figure = htmlFigure(picture, document_.title);
  std::error_code none;
  std::filesystem::remove(picture, none);
  VOLUTE_TRY(figure);
  std::vector<HtmlRow> view;
  for (const auto& [name, value] : order_.view)
    view.push_back({escapedHtml(name), escapedHtml(value)});
  view.push_back({"program", fmt::format("Volute {}", VOLUTE_VERSION)});
  if (ends_)
    return fail(ErrorCode::kCancelled, "{}: stopped", order_.target.string());
  Json remarks = Json::array();
  for (const std::string& remark : document_.remarks) remarks.push_back(remark);
  if (const std::string maps = unsavedMaps(document_.canvases); !maps.empty())
    remarks.push_back(maps + ": the fog painted on it, which the picture shows, is in no file");
  if (document_.changed)
    remarks.push_back("the scene is shown with changes that are in no file");
  return writePage(order_.target, document_.title,
                   *figure + htmlWarnings(remarks) + "<h2>View</h2>\n" + htmlTable({}, view) +
                       parameterTable(document_.parameters) + files);
}

void ViewReport::begin(Image picture) {
  if (!document_.info() || job_)
    return;
  const auto point = [](const Vec3& v) {
    return fmt::format("{}, {}, {}", plainNumber(v.x()), plainNumber(v.y()), plainNumber(v.z()));
  };
  const StartView view = view_.camera().view();
  std::error_code gone;  // then writing says so
  ReportOrder order{freeReportName(std::filesystem::current_path(gone)), std::move(picture)};
  order.view = {{"time", plainNumber(playback_.timeline().snapshotTime()) + " s"},
                {"eye", point(view.eye)},
                {"target", point(view.target)},
                {"up", point(view.up)},
                view.ortho > 0 ? std::pair("ortho", plainNumber(view.ortho) + " m")
                               : std::pair("fov", fmt::format("{:.6g} degrees", view.fov)),
                {"exposure", fmt::format("{:.6g}", view_.display().exposure)},
                {"tone", view_.display().view ? view_.display().view->name()
                                              : std::string(nameOf(view_.display().tone))}};
  job_ = std::make_shared<ReportJob>(std::move(order));
  document_.loader().change("report",
                            [job = job_](Document& document, Progress&) -> Result<std::string> {
                              job->begin(document.info(), document.files());
                              return job->target().filename().string() + " is being written";
                            });
}

void ViewReport::stop() {
  if (job_)
    job_->stop();
  job_.reset();
}

void ViewReport::update() {
  if (!job_ || !job_->done())
    return;
  const Status& written = job_->status();
  document_.say(
      written ? job_->target().filename().string() + " is written" : viewerText(written.error()),
      !written);
  job_.reset();
}

}  // namespace volute
