// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/open_document.hpp"

#include "volute/io/json_file.hpp"
#include "volute/media/volume/volume_input.hpp"
#include "volute/viewer/capture_document.hpp"
#include "volute/viewer/scene_document.hpp"

namespace volute {
namespace {

/// Scenes say so; any other .json with cameras in it is a capture's.
bool isCaptureJson(const nlohmann::json& json) {
  if (!json.is_object() || json.value("format", nlohmann::json()) == "volute-scene-1")
    return false;
  return json.contains("cameras") || json.contains("frames") || json.contains("camera_matrix") ||
         json.value("format", nlohmann::json()) == "volute-capture-1";
}

bool isColmapFile(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  return name == "cameras.txt" || name == "cameras.bin" || name == "images.txt" ||
         name == "images.bin";
}

Result<bool> isCapture(const std::string& path) {
  const std::string extension = extensionOf(path);
  if (extension == ".yml" || extension == ".yaml" || isColmapFile(path))
    return true;
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    for (const auto& entry : std::filesystem::directory_iterator(path, ignored)) {
      if (isColmapFile(entry.path()))
        return true;
    }
    return false;
  }
  if (extension != ".json")
    return false;
  VOLUTE_ASSIGN(const auto json, readJson(path));
  return isCaptureJson(json);
}

}  // namespace

OpenDocument documentOpener(DocumentOptions options) {
  return [options = std::move(options)](const std::string& path,
                                        Progress& progress) -> Result<std::unique_ptr<Document>> {
    VOLUTE_ASSIGN(const bool capture, isCapture(path));
    return capture ? CaptureDocument::open(path, options.maxMemory, progress)
                   : SceneDocument::open(path, options, progress);
  };
}

}  // namespace volute
