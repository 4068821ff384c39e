// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench render`: from the tree in memory to a picture of 512 x 512, frame after frame.
#include "volute/render/render.hpp"

#include <algorithm>
#include <cmath>

#include "bench/benchmark.hpp"
#include "bench/timing.hpp"
#include "volute/base/parallel.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/media/volume/volume_light.hpp"
#include "volute/tree4d/tree4d.hpp"

namespace volute::bench {
namespace {

constexpr int kPixels = 512;

struct Look {
  const char* name;
  double extinction;
  Basis basis;
};

Result<Image> picture(const Tree4d& tree, int frame, const Camera& camera, const Look& look,
                      Renderer renderer) {
  BrickSlice slice = tree.extractSlice(frame);
  slice.setBasis(look.basis);
  const std::vector<AnyMedium> media{AnyMedium(
      VoxelMedium(std::make_shared<const BrickSlice>(std::move(slice)), 1.0, look.extinction))};
  Progress quiet;
  return render(camera, media, {.renderer = renderer}, quiet);
}

/// The same in the light of a sun and a lamp, from its voxels to the picture.
Result<Image> litPicture(const Tree4d& tree, int frame, const Camera& camera, double extinction) {
  BrickSlice slice = tree.extractSlice(frame);
  slice.setBasis(Basis::kTrilinear);
  float* values = slice.brick(0);
  for (std::size_t i = 0; i < slice.values().size(); ++i)
    values[i] = std::max(0.0F, static_cast<float>(extinction) * values[i]);
  const Box3 box = slice.bounds();
  VolumeLighting lighting;
  lighting.albedo = Rgb::Constant(0.9);
  lighting.asymmetry = 0.3;
  Lamp sun, point;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = Vec3(0.6, 0.3, -0.8).normalized();
  point.position = box.min - 0.2 * box.size();
  point.intensity = Rgb::Constant(box.size().squaredNorm());
  lighting.lamps = {sun, point};
  const VolumeLight light(ShadedVoxels(std::make_shared<const BrickSlice>(std::move(slice))),
                          lighting);
  const std::vector<AnyMedium> media{AnyMedium(light.seenFrom({false, camera.eye()}))};
  Progress quiet;
  return render(camera, media, {}, quiet);
}

/// What light and a smoother basis cost.
void benchLooks(const std::string& name, const Tree4d& tree, const Camera& camera,
                double extinction, BenchRows& rows) {
  const Look plain{"absorbing, trilinear", extinction, Basis::kTrilinear};
  const Look cubic{"absorbing, cubic", extinction, Basis::kCubic};
  const int frame = tree.info().frames / 2;
  const auto secondsFor = [](auto&& draw) { return medianSeconds([&] { (void)draw(); }, 1.0); };
  const double base =
      secondsFor([&] { return picture(tree, frame, camera, plain, Renderer::kCpu); });
  const double smooth =
      secondsFor([&] { return picture(tree, frame, camera, cubic, Renderer::kCpu); });
  const double lit = secondsFor([&] { return litPicture(tree, frame, camera, extinction); });
  rows.add({fmt::format("{}: absorbing, cubic, cpu", name), 1 / smooth, "frames/s", base / smooth});
  rows.add(
      {fmt::format("{}: lit by a sun and a lamp, cpu", name), 1 / lit, "frames/s", base / lit});
}

Status benchOne(const std::string& name, const Sequence& sequence, Progress& progress,
                BenchRows& rows) {
  SequenceSource source(sequence);
  VOLUTE_ASSIGN(const Tree4d tree, Tree4d::build(source, {.relativeRms = 3e-3}, progress));
  const VolumeInfo& info = tree.info();
  const Camera camera = Camera::framing(info.bounds, kPixels, kPixels);
  const double extinction = 4 / info.bounds.size().maxCoeff();
  for (const Look& look :
       {Look{"emission, box", 0, Basis::kBox}, Look{"emission, trilinear", 0, Basis::kTrilinear},
        Look{"absorbing, box", extinction, Basis::kBox},
        Look{"absorbing, trilinear", extinction, Basis::kTrilinear}}) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped in {}", name);
    const int middle = info.frames / 2;
    VOLUTE_ASSIGN(const Image expected, picture(tree, middle, camera, look, Renderer::kReference));
    VOLUTE_ASSIGN(const Image image, picture(tree, middle, camera, look, Renderer::kCpu));
    float brightest = 0, difference = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      brightest = std::max(brightest, expected.pixels[i]);
      difference = std::max(difference, std::fabs(image.pixels[i] - expected.pixels[i]));
    }
    const double reference = medianSeconds(
        [&] { (void)picture(tree, middle, camera, look, Renderer::kReference); }, 0.0);
    int frame = 0;
    const double fast = medianSeconds(
        [&] { (void)picture(tree, frame++ % info.frames, camera, look, Renderer::kCpu); }, 1.0);
    rows.add({fmt::format("{}: {}, reference", name, look.name), 1 / reference, "frames/s", 1.0});
    rows.add({fmt::format("{}: {}, cpu", name, look.name), 1 / fast, "frames/s", reference / fast});
    rows.add({fmt::format("{}: {}, |cpu - reference| / maximum", name, look.name),
              brightest > 0 ? difference / brightest : 0.0, "", std::nullopt});
  }
  if (info.channels == 1)
    benchLooks(name, tree, camera, extinction, rows);
  return {};
}

}  // namespace

Status benchRender(const BenchInput& input, BenchRows& rows, Progress& progress) {
  VOLUTE_ASSIGN(const auto sequences, benchSequences(input, progress));
  for (const auto& [name, sequence] : sequences)
    VOLUTE_TRY(benchOne(name, sequence, progress, rows));
  return {};
}

}  // namespace volute::bench
