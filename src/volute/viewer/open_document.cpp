// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/open_document.hpp"

#include "volute/capture/open_capture.hpp"
#include "volute/viewer/capture_document.hpp"
#include "volute/viewer/scene_document.hpp"

namespace volute {

OpenDocument documentOpener(DocumentOptions options) {
  return [options = std::move(options)](const std::string& path,
                                        Progress& progress) -> Result<std::unique_ptr<Document>> {
    VOLUTE_ASSIGN(const bool capture, isCapture(path));
    return capture ? CaptureDocument::open(path, options.maxMemory, progress)
                   : SceneDocument::open(path, options, progress);
  };
}

}  // namespace volute
