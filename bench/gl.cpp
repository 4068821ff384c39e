// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench gl`: the papers' tables of frame rates by OpenGL on the device there is, against
// the CPU's.
#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/benchmark.hpp"
#include "bench/gl_case_drawer.hpp"
#include "bench/gl_cases.hpp"
#include "bench/timing.hpp"
#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_renderer.hpp"

namespace volute::bench {
namespace {

/// What a run may take without a graphics card [s]. With one all pictures have their size.
constexpr double kAllSeconds = 420, kQuickSeconds = 60;
/// And a case of it, when the time is over: small pictures are drawn all the same.
constexpr double kMinSeconds = 0.6;

double largestDifference(const Image& a, const Image& b) {
  double largest = 0, brightest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    largest = std::max<double>(largest, std::fabs(a.pixels[i] - b.pixels[i]));
    brightest = std::max<double>(brightest, b.pixels[i]);
  }
  return brightest > 0 ? largest / brightest : 0;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// The median of the seconds of some frames, from frame 1 on: until they took `seconds` together
/// and are `least`, but no more than one of them once they took three times that.
template <class Draw>
Result<double> medianFrame(double seconds, std::size_t least, Draw&& draw) {
  std::vector<double> frames;
  const auto begin = Clock::now();
  for (double spent = 0; frames.empty() || (spent < seconds && frames.size() < 200) ||
                         (frames.size() < least && spent < 3 * seconds);
       spent = secondsSince(begin)) {
    const auto frame = Clock::now();
    VOLUTE_TRY(draw(static_cast<int>(frames.size()) + 1));
    frames.push_back(secondsSince(frame));
  }
  return median(std::move(frames));
}

/// Draws the cases of a run in turn.
class GlBench {
 public:
  GlBench(const GlDevice& device, GlRenderer& renderer, BenchRows& rows)
      : device_(device), drawer_(renderer), rows_(rows) {}

  /// @param seconds  what this case may take on a device that is no graphics card
  Status measure(const GlCase& one, double seconds) {
    Size size{one.width, one.height};
    if (!device_.hardware && one.asLargeAsLast)
      size = last_;
    const auto image = device_.hardware || one.asLargeAsLast
                           ? drawer_.picture(one, size.width, size.height)
                           : drawWithin(one, seconds / kFramesACase, size);
    last_ = size;
    std::string name = one.name;
    if (one.width != 800 || size.width != one.width)
      name += fmt::format(", {} x {}", size.width, size.height);
    if (!image) {
      rows_.add({name + ": gl",
                 std::numeric_limits<double>::quiet_NaN(),
                 "frames/s",
                 std::nullopt,
                 {{"device", device_.renderer}},
                 image.error().message});
      return {};
    }
    const auto view = [&](int k) { return one.camera(k, size.width, size.height); };
    const double difference = largestDifference(*image, one.byCpu(view(0), 0));
    const double patience = std::min(1.0, seconds / kFramesACase);
    VOLUTE_ASSIGN(const double cpu, medianFrame(patience, 3, [&](int k) -> Status {
                    (void)one.byCpu(view(k), k);
                    return {};
                  }));
    (void)drawer_.takePasses();
    std::vector<GlPassTime> passes;
    int frames = 0;
    VOLUTE_ASSIGN(const double gl, medianFrame(patience, 3, [&](int k) -> Status {
                    VOLUTE_TRY(drawer_.frame(one, view(k), k));
                    add(drawer_.takePasses(), passes);  // waits for the device
                    ++frames;
                    return {};
                  }));
    rows_.add({name + ": cpu", 1 / cpu, "frames/s", 1.0});
    rows_.add({name + ": gl",
               1 / gl,
               "frames/s",
               cpu / gl,
               {{"device", device_.renderer}, {"difference", fmt::format("{:.2g}", difference)}},
               fmt::format("|gl - cpu| <= {:.2g} of the brightest; {}", difference,
                           words(passes, frames))});
    return {};
  }

 private:
  struct Size {
    int width = 0, height = 0;
  };

  /// Frames that a case takes at most, together with those of the CPU and the smaller ones
  /// before.
  static constexpr double kFramesACase = 6;

  /// The largest of an eighth, a quarter, a half of the size and itself that takes `seconds` at
  /// most as the smaller ones let expect.
  Result<Image> drawWithin(const GlCase& one, double seconds, Size& size) {
    const Size full = size;
    constexpr int kSmallest = 8;
    constexpr double kCompiling = 6;  // [s], at most
    size = {full.width / kSmallest, full.height / kSmallest};
    const auto first = Clock::now();
    VOLUTE_ASSIGN(auto compiled, drawer_.picture(one, size.width, size.height));
    if (secondsSince(first) > kCompiling + 2 * seconds)  // not by its pixels
      return compiled;
    for (int part = kSmallest;; part /= 2) {
      size = {full.width / part, full.height / part};
      const auto begin = Clock::now();
      VOLUTE_ASSIGN(auto image, drawer_.picture(one, size.width, size.height));
      if (part == 1 || 4 * secondsSince(begin) > seconds)
        return image;
    }
  }

  static void add(const std::vector<GlPassTime>& some, std::vector<GlPassTime>& sum) {
    for (const GlPassTime& pass : some) {
      const auto found = std::ranges::find(sum, pass.name, &GlPassTime::name);
      if (found == sum.end())
        sum.push_back(pass);
      else
        found->milliseconds += pass.milliseconds;
    }
  }

  static std::string words(const std::vector<GlPassTime>& passes, int frames) {
    std::string text;
    for (const GlPassTime& pass : passes)
      text += fmt::format("{}{} {:.3g} ms", text.empty() ? "" : ", ", pass.name,
                          pass.milliseconds / frames);
    return text;
  }

  const GlDevice& device_;
  GlCaseDrawer drawer_;
  Size last_{};
  BenchRows& rows_;
};

std::vector<GlGroup> groupsOf(const BenchInput& input, const GlExtent& extent) {
  return {{0.29,
           [extent](std::vector<GlCase>& cases, Progress&) -> Status {
             addHall(extent, cases);
             return {};
           }},
          {0.2,
           [&input, extent](std::vector<GlCase>& cases, Progress&) -> Status {
             return addMall(input, extent, cases);
           }},
          {0.24,
           [extent](std::vector<GlCase>& cases, Progress&) -> Status {
             return addFogTables(extent.quick, cases);
           }},
          {0.27, [&input](std::vector<GlCase>& cases, Progress& progress) -> Status {
             return addTrees(input, progress, cases);
           }}};
}

}  // namespace

Status benchGl(const BenchInput& input, BenchRows& rows, Progress& progress) {
  VOLUTE_ASSIGN(const auto gl, HeadlessGl::create());
  VOLUTE_ASSIGN(auto renderer, GlRenderer::create());
  GlBench bench(gl.device(), renderer, rows);
  if (!gl.device().hardware) {
    rows.add({"paper C, table 3: other motions of the mall, and of the hall with an exit sign",
              std::numeric_limits<double>::quiet_NaN(),
              "frames/s",
              std::nullopt,
              {{"device", gl.device().renderer}},
              "left out, for there is no graphics card and a frame takes seconds"});
  }
  const auto begin = Clock::now();
  const double all = input.quick ? kQuickSeconds : kAllSeconds;
  double share = 0;
  for (const GlGroup& group : groupsOf(input, {input.quick, gl.device().hardware})) {
    share += group.share;
    std::vector<GlCase> cases;
    VOLUTE_TRY(group.make(cases, progress));
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const double spent = secondsSince(begin);
      progress.report("measuring", std::min(spent, all), all);
      if (progress.cancelled())
        return fail(ErrorCode::kCancelled, "stopped before {}", cases[i].name);
      const double mine = (share * all - spent) / static_cast<double>(cases.size() - i);
      VOLUTE_TRY(bench.measure(cases[i], std::max(mine, kMinSeconds)));
    }
  }
  return {};
}

}  // namespace volute::bench
