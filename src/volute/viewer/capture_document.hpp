// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>

#include "volute/capture/capture_images.hpp"
#include "volute/viewer/document.hpp"

namespace volute {

/// A capture: the volume's box and its cameras where they stand, each with what it saw at the time
/// on a screen before it, at the distance where the screen just covers its view. Who looks from a
/// camera sees its picture.
class CaptureDocument final : public Document {
 public:
  /// @param maxMemory  [bytes] for one picture
  [[nodiscard]] static Result<std::unique_ptr<Document>> open(const std::string& path,
                                                              std::uint64_t maxMemory,
                                                              Progress& progress);

  DocumentInfo info() const override;
  std::vector<std::filesystem::path> files() const override;
  Result<ViewScene> sceneAt(const SceneRequest& request, Progress& progress) override;

 private:
  explicit CaptureDocument(std::string path) : path_(std::move(path)) {}

  void remarkOnFaults(std::uint64_t maxMemory);
  std::vector<double> times() const;
  std::vector<ViewStation> stations() const;
  int frameAt(double time) const;
  Result<GlQuad> screenOf(std::size_t camera, int frame);
  void addFrustum(const CaptureCamera& camera, std::vector<ViewLine>& lines) const;

  std::string path_;
  Capture capture_;
  std::vector<std::string> remarks_;  ///< on the capture, and why it would be refused
  std::unique_ptr<CaptureImages> images_;
  Box3 bounds_;
  double screen_ = 1;  ///< [m], how far a screen is from its camera
};

}  // namespace volute
