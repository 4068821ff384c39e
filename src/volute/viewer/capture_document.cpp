// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/capture_document.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "volute/capture/geometry_check.hpp"
#include "volute/capture/open_capture.hpp"
#include "volute/viewer/view_lines.hpp"

namespace volute {
namespace {

constexpr double kScreenShare = 0.12;  ///< of the distance from the cameras to the volume
constexpr std::size_t kMaxRemarks = 4;
constexpr int kMaxPixels = 512;  ///< across a screen; larger pictures are thinned out

const Rgb kBoxColor(0.37, 0.79, 0.70), kCameraColor(0.99, 0.91, 0.15);

/// Every n-th pixel, RGB, nothing below 0.
std::shared_ptr<const Image> thinned(const Image& picture) {
  const int step = 1 + (std::max(picture.width, picture.height) - 1) / kMaxPixels;
  auto small = std::make_shared<Image>((picture.width + step - 1) / step,
                                       (picture.height + step - 1) / step);
  for (int y = 0; y < small->height; ++y) {
    for (int x = 0; x < small->width; ++x) {
      for (int c = 0; c < 3; ++c)
        small->at(x, y, c) =
            std::max(0.0F, picture.at(x * step, y * step, std::min(c, picture.channels - 1)));
    }
  }
  return small;
}

/// Where a camera's corner ray is at this depth; the lens is left out.
Vec3 cornerAt(const Camera& camera, double x, double y, double depth) {
  const Vec2& middle = camera.principalPoint();
  return camera.eye() +
         depth * (camera.forward() + (x - middle.x()) * camera.pixelWidth() * camera.right() +
                  (y - middle.y()) * camera.pixelSize() * camera.down());
}

}  // namespace

Result<std::unique_ptr<Document>> CaptureDocument::open(const std::string& path,
                                                        std::uint64_t maxMemory,
                                                        Progress& progress) {
  std::unique_ptr<CaptureDocument> document(new CaptureDocument(path));
  CaptureOptions options;
  options.maxMemory = maxMemory;
  VOLUTE_ASSIGN(document->capture_, openCapture(path, options));
  document->remarkOnFaults(maxMemory);
  const Capture& capture = document->capture_;
  VOLUTE_ASSIGN(auto images, CaptureImages::open(capture, maxMemory, progress));
  document->images_ = std::make_unique<CaptureImages>(std::move(images));
  Box3& bounds = document->bounds_;
  const Box3& volume = capture.volume.bounds;
  double distance = 0;
  for (const CaptureCamera& camera : capture.cameras) {
    bounds.extend(camera.camera.eye());
    distance += (camera.camera.eye() - volume.centre()).norm() /
                static_cast<double>(capture.cameras.size());
  }
  bounds.extend(volume);
  document->screen_ = kScreenShare * std::max(distance, 1e-3);
  return std::unique_ptr<Document>(std::move(document));
}

/// What reconstruct refuses, for here one sees why.
void CaptureDocument::remarkOnFaults(std::uint64_t maxMemory) {
  for (const Remark& remark : capture_.remarks) remarks_.push_back(remark.sentence);
  for (const GeometryFault& fault : checkGeometry(capture_)) remarks_.push_back(fault.message);
  const auto there = checkPicturesThere(capture_, false, maxMemory);
  if (!there)
    remarks_.push_back(there.error().message);
  else
    remarks_.insert(remarks_.end(), there->begin(), there->end());
}

DocumentInfo CaptureDocument::info() const {
  const std::string name = std::filesystem::path(path_).filename().string();
  return {.title = fmt::format("{}: {}{} cameras, {} frame{}", name,
                               capture_.kind == "capture.json" ? "" : capture_.kind + ", ",
                               capture_.cameras.size(), capture_.frames.size(),
                               capture_.frames.size() == 1 ? "" : "s"),
          .bounds = bounds_,
          .times = times(),
          .remarks = remarks_,
          .stations = stations()};
}

std::vector<double> CaptureDocument::times() const {
  std::vector<double> times;
  for (const int frame : capture_.frames)
    times.push_back((frame - capture_.firstFrame) / capture_.framesPerSecond);
  if (times.empty())
    times = {0.0};
  return times;
}

std::vector<std::filesystem::path> CaptureDocument::files() const {
  return {capture_.file.empty() ? std::filesystem::path(path_) : capture_.file};
}

std::vector<ViewStation> CaptureDocument::stations() const {
  std::vector<ViewStation> stations;
  for (const CaptureCamera& held : capture_.cameras) {
    const Camera& camera = held.camera;
    // The whole picture is seen, up to the tilt and to a principal point that is off the middle.
    const double half = 0.5 * camera.height() * camera.pixelSize();
    const double fov = 2 * std::atan(1.02 * half) * 180 / std::numbers::pi;
    const Vec3 centre = capture_.volume.bounds.centre();
    const double distance = std::max((centre - camera.eye()).dot(camera.forward()), 2 * screen_);
    stations.push_back(
        {held.name,
         {camera.eye(), camera.eye() + distance * camera.forward(), Vec3::UnitZ(), fov}});
  }
  return stations;
}

int CaptureDocument::frameAt(double time) const {
  const double frame = capture_.firstFrame + time * capture_.framesPerSecond + 1e-6;
  const auto after = std::ranges::upper_bound(capture_.frames, frame);
  return after == capture_.frames.begin() ? capture_.frames.front() : *(after - 1);
}

Result<GlQuad> CaptureDocument::screenOf(std::size_t camera, int frame) {
  VOLUTE_ASSIGN(const auto picture, images_->read(camera, frame));
  const Camera& from = capture_.cameras[camera].camera;
  const double w = from.width(), h = from.height();
  GlQuad quad;
  quad.corner = cornerAt(from, 0, 0, screen_);
  quad.right = cornerAt(from, w, 0, screen_) - quad.corner;
  quad.down = cornerAt(from, 0, h, screen_) - quad.corner;
  quad.picture = thinned(picture.radiance);
  quad.bothSides = true;
  return quad;
}

void CaptureDocument::addFrustum(const CaptureCamera& held, std::vector<ViewLine>& lines) const {
  const Camera& camera = held.camera;
  const double w = camera.width(), h = camera.height();
  const Vec3 corners[] = {cornerAt(camera, 0, 0, screen_), cornerAt(camera, w, 0, screen_),
                          cornerAt(camera, w, h, screen_), cornerAt(camera, 0, h, screen_)};
  for (int i = 0; i < 4; ++i) {
    lines.push_back({camera.eye(), corners[i], kCameraColor});
    lines.push_back({corners[i], corners[(i + 1) % 4], kCameraColor});
  }
}

Result<ViewScene> CaptureDocument::sceneAt(const SceneRequest& request, Progress& progress) {
  ViewScene scene;
  addBox(capture_.volume.bounds, kBoxColor, scene.lines);
  const int frame = frameAt(request.time);
  for (std::size_t c = 0; c < capture_.cameras.size(); ++c) {
    progress.report("reading pictures", static_cast<double>(c),
                    static_cast<double>(capture_.cameras.size()));
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped");
    addFrustum(capture_.cameras[c], scene.lines);
    auto screen = screenOf(c, frame);
    if (screen)
      scene.quads.push_back(std::move(*screen));
    else if (screen.error().code != ErrorCode::kNotFound)  // a camera may have missed a frame
      scene.remarks.push_back(screen.error().message);
  }
  if (scene.remarks.size() > kMaxRemarks) {
    const std::size_t more = scene.remarks.size() - kMaxRemarks;
    scene.remarks.resize(kMaxRemarks);
    scene.remarks.push_back(fmt::format("and {} more pictures cannot be read", more));
  }
  return scene;
}

}  // namespace volute
