// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/open_document.hpp"

#include <fmt/ranges.h>

#include "volute/base/plain_number.hpp"
#include "volute/capture/open_capture.hpp"
#include "volute/viewer/capture_document.hpp"
#include "volute/viewer/file_dialog.hpp"
#include "volute/viewer/scene_document.hpp"

namespace volute {

namespace {

Result<std::unique_ptr<Document>> openCaptureAt(const std::string& path,
                                                const DocumentOptions& options,
                                                Progress& progress) {
  VOLUTE_ASSIGN(auto document, CaptureDocument::open(path, options.maxMemory, progress));
  const auto times = document->info().times;
  const std::size_t n = times.size();
  if (options.beginAt && path == options.file && n > 1 &&
      *options.beginAt > 2 * times[n - 1] - times[n - 2]) {
    return failFor("time", ErrorCode::kInvalidArgument,
                   "{} s is past the end: {} has {} frames from {} to {} s",
                   plainNumber(*options.beginAt), path, n, plainNumber(times.front()),
                   plainNumber(times.back()));
  }
  return document;
}

}  // namespace

OpenDocument documentOpener(DocumentOptions options) {
  return [options = std::move(options)](
             const std::string& path,
             Progress& progress) mutable -> Result<std::unique_ptr<Document>> {
    VOLUTE_ASSIGN(const bool capture, isCapture(path));
    auto document = capture ? openCaptureAt(path, options, progress)
                            : SceneDocument::open(path, options, progress);
    std::error_code unknown;
    if (!document && document.error().code == ErrorCode::kUnsupported && !isKnown(path) &&
        std::filesystem::is_regular_file(path, unknown)) {
      return fail(ErrorCode::kUnsupported,
                  "{}: files of this kind cannot be shown; expected {}, or a folder of numbered "
                  "frames",
                  path, fmt::join(knownExtensions(), ", "));
    }
    if (document && path == options.file)
      options.beginAt.reset();  // when it is read again, fewer frames may be left
    return document;
  };
}

}  // namespace volute
