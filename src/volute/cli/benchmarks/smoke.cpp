// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench smoke`: smoke on tetrahedra, frame after frame (Staubli et al. 2005, table 3).
#include <sys/resource.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>

#include "volute/base/parallel.hpp"
#include "volute/cli/benchmarks/benchmarks.hpp"
#include "volute/cli/benchmarks/smoke_drawers.hpp"
#include "volute/io/mesh_source.hpp"
#include "volute/tetmesh/made_meshes.hpp"

namespace volute::cli {
namespace {

/// Extinction of 1 g/m3 of the field [1/m].
constexpr float kPerGram = 0.15F;

SmokeCase madeCase(std::string name, double cell) {
  SmokeCase made{std::move(name), hallMesh(cell, 1), {}};
  for (int i = 0; i < 4; ++i) made.extinction.push_back(plume(*made.mesh, i, 1));
  return made;
}

/// The last instants of a case that have the same mesh as the last; of a single one, shares of it.
Result<SmokeCase> caseOf(const BenchInput& input) {
  const MeshOptions options{.field = "smoke", .negatives = Negatives::kClamp};
  VOLUTE_ASSIGN(auto source, MeshSource::open(input.volume, options));
  SmokeCase read{std::filesystem::path(input.volume).filename().string(), nullptr, {}};
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
  return file.ends_with(".vtu") || file.ends_with(".pvd") || isMeshCase(file);
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

struct Mode {
  const char* name;
  bool newSmoke, moving;
};

/// "Fixed" is an eye that turns, as in the paper.
constexpr Mode kModes[] = {{"steady smoke, fixed eye", false, false},
                           {"new smoke, fixed eye", true, false},
                           {"steady smoke, moving eye", false, true},
                           {"new smoke, moving eye", true, true}};

struct Setting {
  const SmokeCase& smoke;
  const Eye& eye;
  int width, height;
  bool sign;

  std::string name() const {
    return fmt::format("{}, {}, {}x{}{}", smoke.name, eye.name, width, height,
                       sign ? ", exit sign" : "");
  }

  /// The view at step i: turned a little, or moved a little aside.
  SmokeView view(int field, int turn, int move) const {
    const Vec3 across = (eye.target - eye.eye).cross(Vec3::UnitZ()).normalized();
    const Vec3 towards = eye.target - eye.eye;
    SmokeView view;
    view.eye = eye.eye + 0.005 * towards.norm() * move * across;
    view.target = eye.target + 0.01 * towards.norm() * turn * across;
    view.fov = eye.fov;
    view.width = width;
    view.height = height;
    view.field = field;
    if (sign) {
      const Vec3 centre = eye.eye + 0.8 * towards;
      const Vec3 right = 0.04 * towards.norm() * across, up = 0.4 * right.norm() * Vec3::UnitZ();
      view.sign = {centre - right + up, centre + right + up, centre + right - up,
                   centre - right - up};
    }
    return view;
  }
};

double processorSeconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

/// Opacities of some pixels, by the reference: always the same ones of a picture.
struct Judgement {
  static constexpr std::size_t kPixels = 2000;

  double secondsPerPixel = 0;
  std::vector<std::size_t> pixels;
  std::vector<double> alpha;

  Judgement(const TetMedium& medium, const SmokeView& view) {
    const Camera camera = view.camera();
    const std::vector<float> opaque = opaqueDepth(view);
    const auto all = static_cast<std::size_t>(view.width) * view.height;
    std::vector<Segment> rays;
    for (std::size_t i = 0; i < kPixels; ++i) {
      pixels.push_back(i * 2654435761u % all);
      rays.push_back(pixelRay(camera, static_cast<int>(pixels[i] % view.width),
                              static_cast<int>(pixels[i] / view.width), opaque));
    }
    std::vector<double> depths(kPixels);
    const double begin = processorSeconds();
    parallelRanges(kPixels, 8, [&](std::size_t first, std::size_t last) {
      medium.opticalDepth(std::span(rays).subspan(first, last - first),
                          std::span(depths).subspan(first, last - first));
    });
    secondsPerPixel = (processorSeconds() - begin) / kPixels;
    for (const double depth : depths) alpha.push_back(1 - std::exp(-depth));
  }

  /// The largest error, and how many pixels are off by more than one step of 8 bits.
  std::pair<double, double> errors(std::span<const float> opacity) const {
    double worst = 0, off = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const double error = std::abs(opacity[pixels[i]] - alpha[i]);
      worst = std::max(worst, error);
      off += error > 1.0 / 255;
    }
    return {worst, off / static_cast<double>(pixels.size())};
  }
};

/// The least of several frames.
struct Timing {
  double wall = std::numeric_limits<double>::infinity(), processor = wall;
  int frames = 0;
  std::string trouble;

  void add(const DrawTimes& times) {
    wall = std::min(wall, times.wall);
    processor = std::min(processor, times.processor);
    ++frames;
  }
};

class Table {
 public:
  Table(const Setting& setting, const std::shared_ptr<const TetLocator>& locator,
        std::span<const std::unique_ptr<SmokeDrawer>> drawers, std::vector<std::string>& stopped)
      : setting_(setting),
        drawers_(drawers),
        stopped_(stopped),
        judgement_(TetMedium(locator, setting.smoke.extinction[0]), setting.view(0, 0, 0)) {}

  Status measure(BenchRows& rows, Progress& progress) {
    VOLUTE_TRY(judge(rows));
    for (const Mode& mode : kModes) {
      if (progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped in {}", setting_.name());
      const std::vector<Timing> timings = draw(mode);
      const Timing& peer = timings.front();
      for (std::size_t i = 0; i < drawers_.size(); ++i) {
        BenchRow row = rowOf(*drawers_[i], mode.name);
        row.unit = "ms";
        row.value = timings[i].frames > 0 ? 1e3 * timings[i].wall
                                          : std::numeric_limits<double>::quiet_NaN();
        if (peer.frames > 0 && timings[i].frames > 0)
          row.ratio = peer.wall / timings[i].wall;
        row.note = timings[i].trouble;
        if (timings[i].frames > 0)
          row.note +=
              fmt::format("{}{:.0f} ms of processor time, {} frames", row.note.empty() ? "" : "; ",
                          1e3 * timings[i].processor, timings[i].frames);
        rows.add(std::move(row));
      }
    }
    return {};
  }

 private:
  BenchRow rowOf(const SmokeDrawer& drawer, const char* what) const {
    BenchRow row;
    row.name = fmt::format("{}: {}, {}", setting_.name(), drawer.name(), what);
    row.labels = {{"case", setting_.smoke.name},
                  {"eye", setting_.eye.name},
                  {"size", fmt::format("{}x{}", setting_.width, setting_.height)},
                  {"sign", setting_.sign ? "yes" : "no"},
                  {"drawer", std::string(drawer.name())},
                  {"what", what}};
    return row;
  }

  /// One frame of each, the first: their errors. Drawers that fail or are too slow stop here.
  Status judge(BenchRows& rows) {
    const double reference = judgement_.secondsPerPixel * setting_.width * setting_.height;
    rows.add({fmt::format("{}: reference, double", setting_.name()),
              1e3 * reference,
              "ms",
              std::nullopt,
              {},
              fmt::format("of processor time, from {} pixels", Judgement::kPixels)});
    for (std::size_t i = 0; i < drawers_.size(); ++i) {
      if (!stopped_[i].empty())
        continue;
      std::vector<float> opacity(static_cast<std::size_t>(setting_.width) * setting_.height);
      const SmokeView view = setting_.view(0, 0, 0);
      const auto begin = std::chrono::steady_clock::now();
      const auto times = drawers_[i]->draw(view, opacity);
      const double wall =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      BenchRow row = rowOf(*drawers_[i], "largest error of opacity");
      if (!times) {
        stopped_[i] = times.error().message;
        row.value = std::numeric_limits<double>::quiet_NaN();
        row.note = stopped_[i];
      } else {
        const auto [worst, off] = judgement_.errors(opacity);
        row.value = worst;
        row.note = fmt::format("{:.2f} % of the pixels off by more than 1/255", 100 * off);
        if (wall > 4 * kPatience)
          stopped_[i] = fmt::format("one frame took {:.1f} s; no more were drawn", times->wall);
      }
      rows.add(std::move(row));
    }
    return {};
  }

  /// All drawers in turn, so that what else the machine does meets all of them.
  std::vector<Timing> draw(const Mode& mode) {
    constexpr int kRounds = 4;
    std::vector<Timing> timings(drawers_.size());
    std::vector<float> opacity(static_cast<std::size_t>(setting_.width) * setting_.height);
    std::vector<double> spent(drawers_.size(), 0);
    for (int frame = 1; frame <= kRounds; ++frame) {
      const int field =
          mode.newSmoke ? frame % static_cast<int>(setting_.smoke.extinction.size()) : 0;
      for (std::size_t i = 0; i < drawers_.size(); ++i) {
        Timing& timing = timings[i];
        timing.trouble = stopped_[i];
        if (!stopped_[i].empty() || (frame > 2 && spent[i] > kPatience))
          continue;
        const auto times =
            drawers_[i]->draw(setting_.view(field, frame, mode.moving ? frame : 0), opacity);
        if (!times) {
          timing.trouble = stopped_[i] = times.error().message;
          continue;
        }
        timing.add(*times);
        spent[i] += times->wall;
      }
    }
    return timings;
  }

  static constexpr double kPatience = 5;  // seconds for one drawer and mode

  Setting setting_;
  std::span<const std::unique_ptr<SmokeDrawer>> drawers_;
  std::vector<std::string>& stopped_;  // why a drawer draws no more from this eye
  Judgement judgement_;
};

}  // namespace

Status benchSmoke(const BenchInput& input, BenchRows& rows, Progress& progress) {
  std::vector<SmokeCase> cases;
  if (isMesh(input.volume)) {
    VOLUTE_ASSIGN(cases.emplace_back(), caseOf(input));
  } else {
    cases.push_back(madeCase("made hall", 0.42));
    if (!input.quick)
      cases.push_back(madeCase("made hall, fine", 0.18));
  }
  for (SmokeCase& smoke : cases) {
    for (auto& field : smoke.extinction) {
      for (float& value : field) value *= kPerGram;
    }
    const auto locator = std::make_shared<const TetLocator>(smoke.mesh);
    rows.add({fmt::format("{}: tetrahedra", smoke.name),
              static_cast<double>(smoke.mesh->tets().size()), "", std::nullopt});
    const auto drawers = smokeDrawers(smoke, locator, input.quick);
    for (const Eye& eye : eyesOf(smoke.mesh->bounds())) {
      std::vector<std::string> stopped(drawers.size());
      for (const auto& [width, height] : {std::pair(800, 600), {1920, 1080}}) {
        for (const bool sign : {false, true}) {
          if ((width > 800 || input.quick) && (sign || (input.quick && width > 800)))
            continue;
          Table table({smoke, eye, width, height, sign}, locator, drawers, stopped);
          VOLUTE_TRY(table.measure(rows, progress));
        }
      }
    }
  }
  return {};
}

}  // namespace volute::cli
