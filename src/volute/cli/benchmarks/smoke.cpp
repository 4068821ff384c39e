// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench smoke`: smoke on tetrahedra, frame after frame.
#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>

#include "volute/cli/bench_timing.hpp"
#include "volute/cli/benchmarks/benchmarks.hpp"
#include "volute/io/mesh_source.hpp"
#include "volute/tetmesh/face_splat.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/tet_marcher.hpp"

namespace volute::cli {
namespace {

/// Extinction of 1 g/m3 of the field [1/m].
constexpr float kPerGram = 0.15F;

/// Smoke at a few instants on one mesh.
struct Case {
  std::string name;
  std::shared_ptr<const TetMesh> mesh;
  std::vector<std::vector<float>> extinction;
};

Case madeCase() {
  Case made{"made hall", hallMesh(0.42, 1), {}};
  for (int i = 0; i < 4; ++i) made.extinction.push_back(plume(*made.mesh, i, 1));
  return made;
}

/// The last instants of a case that have the same mesh as the last; of a single one, shares of it.
Result<Case> caseOf(const BenchInput& input) {
  VOLUTE_ASSIGN(auto source, MeshSource::open(input.volume, {.negatives = Negatives::kClamp}));
  Case read{std::filesystem::path(input.volume).filename().string(), nullptr, {}};
  const std::size_t count = source.times().size();
  for (std::size_t i = count - std::min<std::size_t>(count, 4); i < count; ++i) {
    VOLUTE_ASSIGN(auto frame, source.read(i));
    if (frame.mesh != read.mesh)
      read.extinction.clear();
    read.mesh = frame.mesh;
    read.extinction.push_back(std::move(frame.values));
  }
  for (const float share : {0.97F, 0.94F, 0.91F}) {
    if (read.extinction.size() >= 4)
      break;
    auto& thinner = read.extinction.emplace_back(read.extinction.front());
    for (float& value : thinner) value *= share;
  }
  return read;
}

bool isMesh(const std::string& file) {
  return file.ends_with(".vtu") || file.ends_with(".pvd");
}

struct Eye {
  const char* name;
  Vec3 eye, target;
  double fov;
};

std::vector<Eye> eyesOf(const Box3& box) {
  const auto at = [&](double x, double y, double z) {
    return Vec3(box.min + box.size().cwiseProduct(Vec3(x, y, z)));
  };
  return {{"outside", at(-0.32, -1.2, 2.3), at(0.5, 0.5, 0.33), 36},
          {"inside", at(0.08, 0.57, 0.28), at(0.86, 0.5, 0.4), 60}};
}

/// The view at step i: turned a little, or moved a little around.
Camera cameraAt(const Eye& eye, int width, int height, int turn, int move) {
  const Vec3 across = (eye.target - eye.eye).cross(Vec3::UnitZ()).normalized();
  const double reach = (eye.target - eye.eye).norm();
  return Camera::pinhole({eye.eye + 0.005 * reach * move * across,
                          eye.target + 0.01 * reach * turn * across, Vec3::UnitZ()},
                         eye.fov, width, height);
}

/// Seconds of the reference for each pixel, and the largest errors of opacity, at some pixels.
struct Judgement {
  double secondsPerPixel = 0;
  std::vector<std::size_t> pixels;
  std::vector<double> alpha;

  Judgement(const TetMedium& medium, const Camera& camera) {
    constexpr std::size_t kPixels = 1500;
    const auto all = static_cast<std::size_t>(camera.width()) * camera.height();
    std::vector<Segment> rays;
    for (std::size_t i = 0; i < kPixels; ++i) {
      pixels.push_back(i * 2654435761u % all);
      rays.push_back(pixelRay(camera, static_cast<int>(pixels[i] % camera.width()),
                              static_cast<int>(pixels[i] / camera.width()), {}));
    }
    std::vector<double> depths(kPixels);
    const auto begin = std::chrono::steady_clock::now();
    medium.opticalDepth(rays, depths);
    secondsPerPixel =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() / kPixels;
    for (const double depth : depths) alpha.push_back(1 - std::exp(-depth));
  }

  double error(std::span<const float> depth) const {
    double worst = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i)
      worst = std::max(worst, std::abs(1 - std::exp(-double(depth[pixels[i]])) - alpha[i]));
    return worst;
  }
};

struct Mode {
  const char* name;
  bool newSmoke, moving;
};

constexpr Mode kModes[] = {{"steady smoke, fixed eye", false, false},
                           {"new smoke, fixed eye", true, false},
                           {"steady smoke, moving eye", false, true},
                           {"new smoke, moving eye", true, true}};

class View {
 public:
  View(const Case& smoke, const std::shared_ptr<const TetLocator>& locator, const Eye& eye,
       int width, int height)
      : smoke_(smoke),
        eye_(eye),
        width_(width),
        height_(height),
        judgement_(TetMedium(locator, smoke.extinction[0]), cameraAt(eye, width, height, 0, 0)) {}

  std::string name() const {
    return fmt::format("{}, {}, {}x{}", smoke_.name, eye_.name, width_, height_);
  }

  /// Times all modes of one path: draw(camera) after setSmoke(field).
  template <class SetSmoke, class Draw>
  void measure(const std::string& path, SetSmoke&& setSmoke, Draw&& draw,
               std::vector<BenchRow>& rows) const {
    const double reference = judgement_.secondsPerPixel * width_ * height_;
    for (const Mode& mode : kModes) {
      setSmoke(smoke_.extinction[0]);
      int frame = 0;
      const double seconds = medianSeconds(
          [&] {
            ++frame;
            if (mode.newSmoke)
              setSmoke(smoke_.extinction[frame % smoke_.extinction.size()]);
            draw(cameraAt(eye_, width_, height_, frame % 8, mode.moving ? frame % 8 : 0));
          },
          0.2);
      rows.push_back({fmt::format("{}: {}, {}", name(), path, mode.name), 1 / seconds, "frames/s",
                      reference / seconds});
    }
    setSmoke(smoke_.extinction[0]);
    draw(cameraAt(eye_, width_, height_, 0, 0));
  }

  const Judgement& judgement() const { return judgement_; }

 private:
  const Case& smoke_;
  const Eye& eye_;
  int width_, height_;
  Judgement judgement_;
};

void benchView(const Case& smoke, const std::shared_ptr<const TetLocator>& locator, const Eye& eye,
               int width, int height, std::vector<BenchRow>& rows) {
  const View view(smoke, locator, eye, width, height);
  std::vector<float> depth(static_cast<std::size_t>(width) * height);
  const auto errorRow = [&](const char* path) {
    rows.push_back({fmt::format("{}: {}, largest error of opacity", view.name(), path),
                    view.judgement().error(depth), "", std::nullopt});
  };
  FaceSplat splat(locator);
  view.measure(
      "face splat", [&](const auto& field) { splat.setExtinction(field); },
      [&](const Camera& camera) { splat.opticalDepth(camera, {}, depth); }, rows);
  errorRow("face splat");
  TetMarcher marcher(locator);
  marcher.setSource(std::vector<float>(3 * smoke.mesh->vertices().size(), 0.5F));
  view.measure(
      "marcher", [&](const auto& field) { marcher.setExtinction(field); },
      [&](const Camera& camera) { marcher.opticalDepth(camera, {}, depth); }, rows);
  errorRow("marcher");
  std::vector<float> color(4 * depth.size());
  view.measure(
      "marcher, lit colour", [&](const auto& field) { marcher.setExtinction(field); },
      [&](const Camera& camera) { marcher.litColor(camera, {}, color); }, rows);
}

}  // namespace

Result<std::vector<BenchRow>> benchSmoke(const BenchInput& input, Progress& progress) {
  Case smoke = madeCase();
  if (isMesh(input.volume)) {
    VOLUTE_ASSIGN(smoke, caseOf(input));
  }
  for (auto& field : smoke.extinction) {
    for (float& value : field) value *= kPerGram;
  }
  const auto locator = std::make_shared<const TetLocator>(smoke.mesh);
  std::vector<BenchRow> rows;
  rows.push_back({fmt::format("{}: tetrahedra", smoke.name),
                  static_cast<double>(smoke.mesh->tets().size()), "", std::nullopt});
  for (const Eye& eye : eyesOf(smoke.mesh->bounds())) {
    for (const auto& [width, height] : {std::pair(800, 600), {1920, 1080}}) {
      if (progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped in {}", smoke.name);
      benchView(smoke, locator, eye, width, height, rows);
    }
  }
  return rows;
}

}  // namespace volute::cli
