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
