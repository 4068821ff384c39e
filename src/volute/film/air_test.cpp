// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "volute/base/program.hpp"
#include "volute/fds/fds_writer.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_sight.hpp"
#include "volute/visibility/exposure_meter.hpp"
#include "volute/visibility/loss.hpp"

// Air that is not stored is not known: what is left out of a case never makes it safer.

namespace volute {
namespace {

using fdswriter::Indices;

constexpr double kNever = std::numeric_limits<double>::infinity();
/// Doses are sums of trapezoids, whose times those of the smoke are among: rates that bend upwards
/// are a little less overestimated with more of them.
constexpr double kTrapezoids = 1e-3, kStep = 0.5;  // [s]

/// A hall whose air gets worse linearly in time, so that any stored times interpolate it exactly.
struct Fire {
  double smoke = 0.01, slope = 0.02, heat = 1, monoxide = 1e-5;

  double extinction(double t, double x) const { return t * (smoke + slope * x / 8); }

  double temperature(double t, double x) const { return 20 + t * heat * (1 + x / 8); }
};

enum class What { kSlices, kVisibility, kBytes, kHeat, kPlots, kDevice, kMonoxide, kDioxide };

/// A source of a case: its stored times, and of which halves of the hall it has files.
struct Source {
  What what;
  std::vector<double> times;
  std::array<bool, 2> halves{true, true};
};

using Sources = std::vector<Source>;

/// Two meshes.
const std::array<fdswriter::Planes, 2> kHall{
    {{{{0, 1, 2, 3, 4}, {0, 1, 2, 3, 4}, {0, 0.5, 1, 1.5, 2, 2.5, 3}}},
     {{{4, 5, 6, 7, 8}, {0, 1, 2, 3, 4}, {0, 0.5, 1, 1.5, 2, 2.5, 3}}}}};
constexpr Indices kWhole{0, 4, 0, 4, 0, 6}, kLayer{0, 4, 0, 4, 4, 4};
const std::vector<Vec3> kEyes{Vec3(1.5, 1.5, 2), Vec3(4.5, 2.5, 2), Vec3(6.5, 1.5, 2)};

void save(const ScratchFolder& folder, const Fire& fire, const Sources& sources) {
  fdswriter::Index index;
  for (const fdswriter::Planes& half : kHall) index.meshes.push_back({half, {}, {}});
  std::string devices;
  const auto slices = [&](const Source& source, fdswriter::Slice slice, auto&& value) {
    for (std::size_t half = 0; half < 2; ++half) {
      if (!source.halves[half])
        continue;
      const std::string name = fmt::format("slice_{}_{}.sf", static_cast<int>(source.what), half);
      std::vector<std::pair<float, std::vector<float>>> frames;
      for (const double t : source.times) {
        frames.emplace_back(
            static_cast<float>(t),
            fdswriter::atNodes(kHall[half], slice.at,
                               [&](double x, double, double) { return value(t, x); }));
      }
      fdswriter::sliceFile(slice, frames).save(folder / name);
      index.slice(static_cast<int>(half) + 1, slice, name, false);
    }
  };
  for (const Source& source : sources) {
    switch (source.what) {
      case What::kSlices:
        slices(source, {kWhole}, [&](double t, double x) { return fire.extinction(t, x); });
        break;
      case What::kVisibility:
        slices(source, {kLayer, "VISIBILITY", "vis", "m"}, [&](double t, double x) {
          return std::min(30.0, 3 / std::max(1e-9, fire.extinction(t, x)));
        });
        break;
      case What::kHeat:
        slices(source, {kLayer, "TEMPERATURE", "temp", "C"},
               [&](double t, double x) { return fire.temperature(t, x); });
        break;
      case What::kMonoxide:
        slices(source, {kLayer, "CARBON MONOXIDE VOLUME FRACTION", "X_CO", "mol/mol"},
               [&](double t, double) { return t * fire.monoxide; });
        break;
      case What::kDioxide:
        slices(source, {kLayer, "CARBON DIOXIDE VOLUME FRACTION", "X_CO2", "mol/mol"},
               [](double t, double) { return 1e-3 * t; });
        break;
      case What::kBytes:
        for (std::size_t half = 0; half < 2; ++half) {
          if (!source.halves[half])
            continue;
          std::vector<std::pair<float, std::vector<std::uint8_t>>> frames;
          std::string sizes = "           0\n";
          for (const double t : source.times) {
            std::vector<std::uint8_t> bytes;
            double most = 0;
            for (const double k : fdswriter::atNodes(kHall[half], [&](double x, double, double) {
                   return fire.extinction(t, x);
                 })) {
              const double opacity = 254 * (1 - std::exp(-k));
              bytes.push_back(static_cast<std::uint8_t>(std::lround(opacity)));
              most = std::max(most, opacity);
            }
            sizes += fmt::format(" {} {} 10 {}\n", t, bytes.size(), most);
            frames.emplace_back(static_cast<float>(t), std::move(bytes));
          }
          const std::string name = fmt::format("made_{}.s3d", half);
          fdswriter::smokeFile({4, 4, 6}, frames).save(folder / name);
          fdswriter::saveText(folder / (name + ".sz"), sizes);
          index.smoke(static_cast<int>(half) + 1, name, 8700);
        }
        break;
      case What::kPlots:
        for (std::size_t half = 0; half < 2; ++half) {
          for (const double t : source.times) {
            if (!source.halves[half])
              continue;
            std::vector<float> all;
            for (int variable = 0; variable < 5; ++variable) {
              const auto values =
                  fdswriter::atNodes(kHall[half], kWhole, [&](double x, double, double) {
                    return variable == 1 ? fire.extinction(t, x) : fire.temperature(t, x);
                  });
              all.insert(all.end(), values.begin(), values.end());
            }
            const std::string name = fmt::format("made_{}_{}.q", half, t);
            fdswriter::plotFile({4, 4, 6}, all).save(folder / name);
            index.plot(static_cast<int>(half) + 1, t, name, "MASS FRACTION");
          }
        }
        break;
      case What::kDevice: {
        std::string table = "s,C\nTime,\"T\"\n";
        for (const double t : source.times)
          table += fmt::format("{:.7E},{:.7E}\n", t, fire.temperature(t, kEyes[1].x()));
        fdswriter::saveText(folder / "made_devc.csv", table);
        devices += fmt::format("DEVICE\n T % TEMPERATURE\n {} {} {} 0 0 -1 0 0 % null\n",
                               kEyes[1].x(), kEyes[1].y(), kEyes[1].z());
        break;
      }
    }
  }
  index.files += devices;
  fdswriter::saveText(folder / "made_hrr.csv", "s,kW\nTime,HRR\n0.0,0.0\n60.0,100.0\n");
  index.save(folder / "made.smv");
}

/// What is said of each eye.
struct Answers {
  std::map<std::string, LossTimes> times;
  std::map<std::string, LossTimes> latest;           // by the least that means at nodes allow
  std::map<std::string, std::vector<double>> doses;  // NaN: not known
  std::map<std::string, std::vector<Air>> assumed;
};

std::vector<Criterion> criteria() {
  std::vector<Criterion> all;
  for (const Criterion& one : usualCriteria()) {
    if (one.name == "visibility" || one.name == "temperature" || one.name == "fed-gas-iso" ||
        one.name == "fed-heat")
      all.push_back(one);
  }
  all[2].limit = 0.01;
  return all;
}

std::optional<Answers> judge(const Fire& fire, const Sources& sources) {
  const ScratchFolder folder;
  save(folder, fire, sources);
  Progress quiet;
  auto field = openSight((folder / "made.smv").string(), {}, quiet);
  if (!field)
    return std::nullopt;
  const SafetySign sign{.name = "exit",
                        .position = Vec3(8, 2, 2),
                        .normal = Vec3(-1, 0, 0),
                        .law = visibilityLaw("jin-reflecting").value(),
                        .angle = {}};
  const std::vector<SightTarget> targets{{sign, sign.position}};
  const auto asked = criteria();
  ExposureMeter meter(AirField::open(**field, asked), asked, kEyes.size());
  SignLoss loss(targets, {{0}}, kEyes.size());
  if (meter.air().smokeIsLate())
    loss.loseAll();
  for (std::size_t i = 0; i < (*field)->times().size(); ++i) {
    const double time = (*field)->times()[i];
    auto snapshot = (*field)->read(i).value();
    std::vector<Sighting> seen(kEyes.size());
    lookAround(*snapshot, targets, kEyes, seen);
    loss.update(time, seen);
    std::vector<double> low(kEyes.size()), high(kEyes.size());
    snapshot->extinctionBounds(kEyes, low, high);
    EXPECT_TRUE(meter.advance(
        time, [](double, std::span<Vec3> out) { std::ranges::copy(kEyes, out.begin()); },
        {high, low}, kStep));
  }
  Answers answers;
  // Of the end of the smoke, all that follows is not known.
  constexpr double kEnd = 60;
  const auto cut = [&](LossTimes times) {
    for (std::size_t i = 0; i < times.up.size(); ++i) {
      if (std::isinf(times.up[i]) && (*field)->times().back() < kEnd)
        times.lose(i, (*field)->times().back());
    }
    return times;
  };
  answers.times["sign"] = cut(loss.earliest(0));
  for (std::size_t c = 0; c < meter.criteria().size(); ++c) {
    const std::string& name = meter.criteria()[c].name;
    answers.times[name] = cut(meter.times(c));
    const LossTimes* latest = meter.latest(c);
    answers.latest[name] = latest != nullptr ? cut(*latest) : answers.times[name];
    answers.assumed[name] = meter.assumed(c);
    if (!meter.criteria()[c].isDose())
      continue;
    for (std::size_t i = 0; i < kEyes.size(); ++i) {
      const bool known = !meter.unknown(c, i) && (*field)->times().back() >= kEnd;
      answers.doses[name].push_back(known ? meter.values(c)[i] : std::nan(""));
    }
  }
  return answers;
}

/// When it is so, by the formulas; infinite: after the end.
double truth(const Fire& fire, const std::string& name, const Vec3& eye) {
  double time = kNever;
  if (name == "visibility")
    time = 0.3 / fire.extinction(1, eye.x());
  if (name == "temperature")
    time = 40 / (fire.temperature(1, eye.x()) - 20);
  if (name == "sign")
    time = 3 / (fire.extinction(1, 0.5 * (eye.x() + 8)) * (eye - Vec3(8, 2, 2)).norm());
  return time > 60 ? kNever : time;
}

TEST(Air, WhatIsLeftOutOfACaseNeverMakesItSafer) {
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto evenly = [](int count) {
    std::vector<double> times;
    for (int i = 0; i <= count; ++i) times.push_back(60.0 * i / count);
    return times;
  };
  int compared = 0, unknown = 0, certain = 0;
  for (int trial = 0; trial < 18; ++trial) {
    const Fire fire{uniform(0.001, 0.02), uniform(0, 0.02), uniform(0.3, 2), uniform(1e-6, 1e-4)};
    Sources sources;
    for (const What what : {What::kSlices, What::kVisibility, What::kBytes, What::kHeat,
                            What::kPlots, What::kDevice, What::kMonoxide, What::kDioxide}) {
      const int counts[] = {2, 6, 12, 30};
      if (uniform(0, 1) < 0.7)
        sources.push_back({what, evenly(counts[random() % 4])});
    }
    const auto whole = judge(fire, sources);
    if (!whole)
      continue;
    const auto compare = [&](const Sources& other, const std::string& how) {
      const auto less = judge(fire, other);
      if (!less)
        return;
      for (const auto& [name, times] : less->times) {
        ASSERT_TRUE(whole->times.contains(name));
        const LossTimes& all = whole->times.at(name);
        for (std::size_t i = 0; i < kEyes.size(); ++i) {
          ++compared;
          const double real = truth(fire, name, kEyes[i]);
          const std::string what = fmt::format("trial {}, {}: {} at eye {}", trial, how, name, i);
          if (!times.complete(i)) {
            ++unknown;
            // Not before it is known not to be.
            EXPECT_LE(times.known[i], std::max(real, all.none[i]) + 1e-3) << what;
            continue;
          }
          ++certain;
          EXPECT_TRUE(all.complete(i)) << what;
          if (name == "fed-gas-iso" || name == "fed-heat") {
            if (less->assumed.at(name) == whole->assumed.at(name)) {
              // What is left may know better than the means at nodes that served before.
              const double last = whole->latest.at(name).none[i];
              EXPECT_LE(times.none[i], last * (1 + kTrapezoids)) << what;
              EXPECT_LE(all.none[i], last) << what;
            }
          } else {
            EXPECT_LE(times.none[i], real + 1e-3) << what;
            EXPECT_LE(times.down[i], times.none[i]) << what;
            EXPECT_GE(times.up[i], times.none[i]) << what;
          }
        }
      }
      for (const auto& [name, doses] : less->doses) {
        for (std::size_t i = 0; i < doses.size(); ++i) {
          const bool known = !std::isnan(doses[i]) && !std::isnan(whole->doses.at(name)[i]);
          if (known && less->assumed.at(name) == whole->assumed.at(name)) {
            EXPECT_GE(doses[i], whole->doses.at(name)[i] * (1 - kTrapezoids))
                << trial << how << name;
          }
        }
      }
    };
    compare(sources, "whole");
    for (std::size_t s = 0; s < sources.size(); ++s) {
      Sources removed = sources;
      removed.erase(removed.begin() + static_cast<std::ptrdiff_t>(s));
      compare(removed, fmt::format("without {}", static_cast<int>(sources[s].what)));
      for (const bool half : {false, true}) {
        Sources part = sources;
        part[s].halves[half ? 1 : 0] = false;
        compare(part, fmt::format("{} in one half, {}", static_cast<int>(sources[s].what), half));
      }
      Sources cut = sources;
      const double end = uniform(0, 60);
      std::erase_if(cut[s].times, [&](double t) { return t > end; });
      compare(cut, fmt::format("{} until {:g} s", static_cast<int>(sources[s].what), end));
      Sources late = sources;
      std::erase_if(late[s].times, [&](double t) { return t < end; });
      compare(late, fmt::format("{} from {:g} s", static_cast<int>(sources[s].what), end));
    }
  }
  EXPECT_GT(compared, 1000);
  EXPECT_GT(unknown, 200);
  EXPECT_GT(certain, 200);
}

/// How often each file of a folder was opened since.
class OpenCounts {
 public:
  explicit OpenCounts(const std::filesystem::path& folder) : watch_(inotify_init1(IN_NONBLOCK)) {
    EXPECT_GE(inotify_add_watch(watch_, folder.c_str(), IN_OPEN), 0);
  }

  ~OpenCounts() { close(watch_); }

  OpenCounts(const OpenCounts&) = delete;
  OpenCounts& operator=(const OpenCounts&) = delete;

  std::map<std::string, int> take() const {
    std::map<std::string, int> counts;
    alignas(inotify_event) char events[1 << 16];
    const ssize_t bytes = read(watch_, events, sizeof events);
    for (ssize_t at = 0; at < bytes;) {
      const auto* event = reinterpret_cast<const inotify_event*>(events + at);
      if (event->len > 0 && (event->mask & IN_ISDIR) == 0)
        ++counts[event->name];
      at += static_cast<ssize_t>(sizeof *event) + event->len;
    }
    return counts;
  }

 private:
  int watch_;
};

TEST(SceneSight, ACaseIsOpenedOnceForPicturesAndSight) {
  const ScratchFolder folder;
  fdswriter::Index index;
  const fdswriter::Planes planes{{{0, 1, 2, 3}, {0, 1, 2}, {0, 1, 2}}};
  index.meshes.push_back({planes, {}, {}});
  const fdswriter::Slice slice{{0, 3, 0, 2, 0, 2}};
  const std::vector<float> values(4 * 3 * 3, 0.1F);
  fdswriter::sliceFile(slice, {{0, values}, {1, values}}).save(folder / "k.sf");
  index.slice(1, slice, "k.sf", false);
  index.save(folder / "made.smv");
  fdswriter::saveText(
      folder / "scene.json",
      R"({"format": "volute-scene-2", "media": [{"kind": "smoke", "case": "made.smv"}]})");
  const OpenCounts opens(folder / "");
  Progress quiet;
  SceneOptions options;
  auto scene = Scene::open((folder / "scene.json").string(), options, quiet);
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_TRUE(scene->at({.time = 0}, quiet));
  const auto forPictures = opens.take();
  EXPECT_EQ(forPictures.at("made.smv"), 1);
  EXPECT_EQ(forPictures.at("k.sf"), 1);
  auto field = sightOf(std::move(*scene), options, quiet);
  ASSERT_TRUE(field) << field.error().message;
  const SightLine line{{0.5, 1, 1}, {2.5, 1, 1}};
  Sight sight;
  (*field)->read(1).value()->look({&line, 1}, {&sight, 1});
  EXPECT_NEAR(sight.depth, 0.2, 1e-6);
  EXPECT_EQ(opens.take(), (std::map<std::string, int>{}));
}

}  // namespace
}  // namespace volute
