// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Ahrenberg et al. 2005, Figures 7, 8 and 9 again, with a volume of one's own:
//
//   volute-paper-figures fire.npy --rates 0.066,0.051,0.019 --strip FOLDER/fire > fire.json
//
// Figure 7: relative RMS over bit rate (bytes of the tree in memory / raw float32), for the paper's
// node layout and the compact one. Figure 8: pictures a second over bit rate, for the paper's walk
// and for slices, each with and without bounding boxes. Figure 9: the pictures at given rates. And
// what zlib gains on the paper's array.
#include <fmt/format.h>
#include <zlib.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/baselines/paper_tree.hpp"
#include "volute/base/parallel.hpp"
#include "volute/camera/camera.hpp"
#include "volute/grid/sequence.hpp"
#include "volute/grid/voxel_medium.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/volume_source.hpp"
#include "volute/render/render.hpp"
#include "volute/tree4d/tree4d.hpp"

namespace {

using namespace volute;  // NOLINT(google-build-using-namespace)
using Json = nlohmann::ordered_json;

constexpr int kViewSide = 64;      // voxels of the view volume, and pixels of a timed picture
constexpr int kStripPixels = 384;  // of a picture in the strip

template <class Work>
double perSecond(Work&& work) {
  using Clock = std::chrono::steady_clock;
  constexpr double kMinSeconds = 0.4;
  const auto begin = Clock::now();
  double seconds = 0;
  int runs = 0;
  for (; runs < 3 || seconds < kMinSeconds; ++runs) {
    work(runs);
    seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  }
  return runs / seconds;
}

std::size_t zlibBytes(std::span<const std::byte> bytes) {
  uLongf size = compressBound(bytes.size());
  std::vector<Bytef> out(size);
  compress2(out.data(), &size, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(),
            Z_DEFAULT_COMPRESSION);
  return size;
}

Camera frontView(const VolumeInfo& info, int side) {
  const Vec3 centre = info.bounds.centre();
  const double extent = info.bounds.size().maxCoeff();
  return Camera::orthographic({centre - Vec3(0, 2 * extent, 0), centre, Vec3::UnitZ()}, extent,
                              side, side);
}

Image picture(const BrickSlice& slice, const Camera& camera, double extinction) {
  const std::vector<AnyMedium> media{
      AnyMedium(VoxelMedium(std::make_shared<const BrickSlice>(slice), 1.0, extinction))};
  Progress quiet;
  return *render(camera, media, {}, quiet);
}

/// All bricks stored, empty or not: what marching costs without any box.
BrickSlice withoutBoxes(const VolumeInfo& info, std::span<const float> values) {
  const BrickSlice slice = BrickSlice::fromDense(info, values);
  std::vector<BrickPlace> places;
  for (int z = 0; z < slice.bricksZ(); ++z)
    for (int y = 0; y < slice.bricksY(); ++y)
      for (int x = 0; x < slice.bricksX(); ++x) places.push_back({x, y, z});
  BrickSlice all(info, places);
  for (const BrickSlice::Entry& entry : slice.entries()) {
    std::copy_n(slice.brick(entry.stored), BrickSlice::kVoxels * slice.channels(),
                all.brick(all.table().at(entry.place)));
  }
  return all;
}

std::vector<float> denseFrame(const PaperTree& tree, int t) {
  const VolumeInfo& info = tree.info();
  std::vector<float> frame(info.frameValues());
  parallelFor(info.z, [&](std::size_t z) {
    for (int y = 0; y < info.y; ++y)
      for (int x = 0; x < info.x; ++x) {
        const std::size_t at = ((z * info.y + y) * info.x + x) * info.channels;
        tree.values(t, static_cast<int>(z), y, x, std::span(frame).subspan(at, info.channels));
      }
  });
  return frame;
}

double measuredRms(const Tree4d& tree, const Sequence& sequence) {
  const auto [low, high] = std::ranges::minmax(sequence.values);
  std::vector<float> frame(sequence.info.frameValues());
  double sum = 0;
  for (int t = 0; t < sequence.info.frames; ++t) {
    tree.extractFrame(t, frame);
    for (std::size_t i = 0; i < frame.size(); ++i) {
      const double e = static_cast<double>(frame[i]) - sequence.frame(t)[i];
      sum += e * e;
    }
  }
  return std::sqrt(sum / static_cast<double>(sequence.values.size())) /
         (static_cast<double>(high) - low);
}

struct Figures {
  const Sequence& sequence;
  double extinction;
  PaperTransform transform{sequence};
  double raw = static_cast<double>(sequence.info.rawBytes());

  /// Bit rates below that of all coefficients together; where one asks for more, nearly all of
  /// them.
  std::vector<double> reachable(std::span<const double> rates) const {
    constexpr double kNearlyAll = 0.9;
    const double all = kNearlyAll * static_cast<double>(transform.bytesAt(0)) / raw;
    std::vector<double> list;
    for (double rate : rates) {
      if (rate < all || list.empty())
        list.push_back(std::min(rate, all));
    }
    return list;
  }

  Result<Tree4d> compactAt(double rms) const {
    SequenceSource source(sequence);
    Progress quiet;
    constexpr double kFinest = 1e-5;  // below it float32 noise is all that is left
    return Tree4d::build(source, {.relativeRms = std::max(rms, kFinest)}, quiet);
  }

  /// Figure 7 and the gain of zlib.
  Result<Json> rateDistortion() const {
    Json rows = Json::array();
    for (double rms : {1e-2, 5e-3, 3e-3, 2e-3, 1e-3, 5e-4, 3e-4}) {
      const double threshold = transform.thresholdForRms(rms);
      const PaperTree paper = transform.build(threshold);
      VOLUTE_ASSIGN(const Tree4d tree, compactAt(rms));
      const auto paperBytes = static_cast<double>(paper.bytes().size());
      rows.push_back({{"paper",
                       {{"rate", paperBytes / raw},
                        {"rms", transform.relativeRmsAt(threshold)},
                        {"bytes", paper.bytes().size()},
                        {"zlib_bytes", zlibBytes(paper.bytes())}}},
                      {"compact",
                       {{"rate", static_cast<double>(tree.memoryBytes()) / raw},
                        {"rms", measuredRms(tree, sequence)},
                        {"bytes", tree.memoryBytes()}}}});
    }
    return rows;
  }

  /// Figure 8. Slices come from the compact tree with the same error as the paper's tree.
  Result<Json> frameRates(std::span<const double> rates) const {
    const VolumeInfo& info = sequence.info;
    const auto view = [](int t) { return paperViewMatrix(Eigen::Matrix3d::Identity(), t); };
    const Camera camera = frontView(info, kViewSide);
    const auto frameOf = [&](int run) { return run * 7 % info.frames; };
    Json rows = Json::array();
    for (double rate : reachable(rates)) {
      const double threshold = transform.thresholdForBytes(static_cast<std::size_t>(rate * raw));
      const PaperTree paper = transform.build(threshold);
      VOLUTE_ASSIGN(const Tree4d tree, compactAt(transform.relativeRmsAt(threshold)));
      std::vector<float> dense(info.frameValues());
      rows.push_back({{"rate", static_cast<double>(paper.bytes().size()) / raw},
                      {"rms", transform.relativeRmsAt(threshold)},
                      {"compact_rate", static_cast<double>(tree.memoryBytes()) / raw},
                      {"traversal", perSecond([&](int run) {
                         renderByTraversal(paper, view(frameOf(run)), kViewSide, nullptr);
                       })},
                      {"traversal_boxes", perSecond([&](int run) {
                         const int t = frameOf(run);
                         renderByTraversal(paper, view(t), kViewSide, &tree.occupiedBox(t));
                       })},
                      {"slices", perSecond([&](int run) {
                         tree.extractFrame(frameOf(run), dense);
                         picture(withoutBoxes(info, dense), camera, 0);
                       })},
                      {"slices_boxes", perSecond([&](int run) {
                         picture(tree.extractSlice(frameOf(run)), camera, 0);
                       })}});
    }
    return rows;
  }

  /// Figure 9, and the original first.
  Result<Json> strip(std::span<const double> rates, const std::string& prefix) const {
    const VolumeInfo& info = sequence.info;
    const int t = info.frames / 2;
    const Camera camera = frontView(info, kStripPixels);
    const Image original =
        picture(BrickSlice::fromDense(info, sequence.frame(t)), camera, extinction);
    const double exposure = suggestExposure(original);
    Json rows = Json::array();
    auto add = [&](const Image& image, const std::string& name, double rate, double rms) -> Status {
      const std::string file = fmt::format("{}_{}.png", prefix, name);
      VOLUTE_TRY(writeImage(file, exposed(image, exposure)));
      rows.push_back(
          {{"file", file}, {"rate", rate}, {"rms", rms}, {"frame", info.frameNumbers[t]}});
      return {};
    };
    VOLUTE_TRY(add(original, "original", 1, 0));
    for (double rate : reachable(rates)) {
      const double threshold = transform.thresholdForBytes(static_cast<std::size_t>(rate * raw));
      const PaperTree paper = transform.build(threshold);
      const Image image =
          picture(BrickSlice::fromDense(info, denseFrame(paper, t)), camera, extinction);
      VOLUTE_TRY(add(image, fmt::format("{:.3f}", rate),
                     static_cast<double>(paper.bytes().size()) / raw,
                     transform.relativeRmsAt(threshold)));
    }
    return rows;
  }
};

Result<Json> run(const std::string& input, const std::vector<double>& rates,
                 const std::string& prefix, double extinction) {
  VOLUTE_ASSIGN(auto source, openSource(input, {}));
  VOLUTE_ASSIGN(const Sequence sequence, readAll(*source, std::uint64_t{8} << 30));
  const Figures figures{sequence, extinction};
  Json json{{"input", input}, {"threads", threadCount()}, {"raw_bytes", sequence.info.rawBytes()}};
  VOLUTE_ASSIGN(json["rate_distortion"], figures.rateDistortion());
  VOLUTE_ASSIGN(json["frame_rates"], figures.frameRates(std::vector<double>{
                                         0.305, 0.106, 0.066, 0.051, 0.035, 0.019, 0.01, 0.005}));
  VOLUTE_ASSIGN(json["strip"], figures.strip(rates, prefix));
  return json;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"The figures of Ahrenberg et al. 2005 with a volume of one's own, as JSON"};
  std::string input, prefix = "strip";
  std::vector<double> rates{0.305, 0.106, 0.019};
  double extinction = 0;
  app.add_option("INPUT", input, "a volume sequence")->required();
  app.add_option("--rates", rates, "bit rates of the pictures")->delimiter(',');
  app.add_option("--strip", prefix, "where the pictures go: PREFIX_<rate>.png");
  app.add_option("--extinction", extinction, "of the pictures, 1/m per unit");
  CLI11_PARSE(app, argc, argv);
  const auto json = run(input, rates, prefix, extinction);
  if (!json) {
    fmt::print(stderr, "volute-paper-figures: {}\n", json.error().message);
    return 1;
  }
  fmt::print("{}\n", json->dump(1));
  return 0;
}
