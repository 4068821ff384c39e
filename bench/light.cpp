// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench light`: every kind of light on every kind of medium, and on media beside each
// other, against brute force in double: from each of many places along a ray, a ray to each lamp.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "bench/benchmark.hpp"
#include "bench/scratch.hpp"
#include "bench/timing.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/read_text.hpp"
#include "volute/grid/sequence.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/npy.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_renderer.hpp"
#include "volute/synth/hall_files.hpp"
#include "volute/synth/synth.hpp"
#ifdef VOLUTE_WITH_GL
#include "volute/gl/gl_scene_renderer.hpp"
#endif

namespace volute::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kAlbedo = 0.8;  ///< of all media, which scatter evenly
constexpr int kLitWidth = 48, kLitHeight = 36, kLitSteps = 600;

/// Where media are, how large they are, and from where they are seen.
struct Place {
  Vec3 middle;
  double size;
  Vec3 eye;
  Vec3 fire;  ///< where one burns that is not seen

  Json at(double x, double y, double z) const {
    const Vec3 point = middle + size * Vec3(x, y, z);
    return Json::array({point.x(), point.y(), point.z()});
  }
};

struct NamedLight {
  std::string name;
  Json (*lights)(const Place&);
  bool fire = false;
};

const NamedLight kLights[] = {
    {"sun",
     [](const Place&) { return Json::array({{{"kind", "sun"}, {"direction", {0.4, 0.3, -1}}}}); }},
    {"spot",
     [](const Place& place) {
       const double power = 10 * place.size * place.size;
       return Json::array({{{"kind", "spot"},
                            {"position", place.at(-0.35, -0.3, 0.45)},
                            {"target", place.at(0.05, 0, 0)},
                            {"angle", 50},
                            {"intensity", {power, power, power}}}});
     }},
    {"point",
     [](const Place& place) {
       const double power = place.size * place.size;
       return Json::array({{{"kind", "spot"},
                            {"position", place.at(0.3, -0.2, 0.3)},
                            {"target", place.at(0, 0, 0)},
                            {"angle", 360},
                            {"edge", 0},
                            {"intensity", {power, power, power}}}});
     }},
    {"fire", [](const Place&) { return Json::array(); }, true},
    {"sky",
     [](const Place&) { return Json::array({{{"kind", "ambient"}, {"radiance", {1, 1, 1}}}}); }}};

/// Media as a scene says them.
class Cases {
 public:
  [[nodiscard]] static Result<Cases> write(Progress& progress) {
    VOLUTE_ASSIGN(auto folder, ScratchFolder::create());
    Cases cases(std::move(folder));
    VOLUTE_ASSIGN(
        const auto smoke,
        synthesize({.kind = SynthKind::kSmoke, .size = 32, .frames = 1, .channels = 1}, progress));
    VOLUTE_TRY(cases.writeVolume("puff.npy", smoke.info, smoke.values));
    VolumeInfo info = smoke.info;
    info.x = info.y = info.z = 8;
    VOLUTE_TRY(cases.writeVolume("fire.npy", info, std::vector<float>(8 * 8 * 8, 1.0F)));
    Image map(16, 16, 1);
    for (int i = 0; i < 16 * 16; ++i) {
      map.pixels[static_cast<std::size_t>(i)] = static_cast<float>(
          0.5 + 0.4 * std::sin(0.9 * (i % 16)) * std::cos(0.7 * static_cast<double>(i / 16)));
    }
    VOLUTE_TRY(writeMap(cases.folder_.path() / "map.png", map));
    VOLUTE_TRY(writeBall(cases.folder_.path() / "ball.vtu", 1));
    VOLUTE_TRY(writeHall({.cell = 0.5, .steps = 13}, cases.folder_.path() / "hall.smv", progress));
    VOLUTE_TRY(cases.openRoof("hall.smv"));
    return cases;
  }

  std::string path(const char* name) const { return (folder_.path() / name).string(); }

  Json volume(const Place& place) const {
    return {
        {"kind", "volume"}, {"file", "puff.npy"},           {"bounds", box(place, 0.1, 0, 0.25)},
        {"emission", 0},    {"extinction", 2 / place.size}, {"albedo", grey()}};
  }

  Json fire(const Place& place) const {
    return {{"kind", "volume"},
            {"file", "fire.npy"},
            {"bounds", boxAround(place.fire, 0.05 * place.size)},
            {"emission", 1000 / place.size},
            {"lights_scene", "always"}};
  }

  Json fog(const Place& place) const {
    return {
        {"kind", "fog"},
        {"map", "map.png"},
        {"cell", place.size / 16},
        {"origin", place.at(-0.5, -0.5, -0.5)},
        {"degree", 2},
        {"sigma_max", 1.5 / place.size},
        {"color", {0, 0, 0}},
        {"albedo", grey()},
        {"profile", {{"kind", "slab"}, {"bottom", 0.1 * place.size}, {"top", 0.9 * place.size}}}};
  }

  Json mesh() const {
    return {{"kind", "smoke"}, {"case", "ball.vtu"}, {"quantity", "soot-density"},
            {"unit", "g/m3"},  {"scale", 0.3},       {"albedo", grey()}};
  }

  Json fds() const {
    return {{"kind", "smoke"}, {"case", "hall.smv"},       {"albedo", grey()},
            {"fire", false},   {"time", {{"offset", 50}}}, {"building", "inside"}};
  }

 private:
  explicit Cases(ScratchFolder folder) : folder_(std::move(folder)) {}

  static Json grey() { return {kAlbedo, kAlbedo, kAlbedo}; }

  static Json box(const Place& place, double x, double z, double half) {
    return boxAround(place.middle + place.size * Vec3(x, 0, z), half * place.size);
  }

  static Json boxAround(const Vec3& middle, double half) {
    return Json::array({{middle.x() - half, middle.y() - half, middle.z() - half},
                        {middle.x() + half, middle.y() + half, middle.z() + half}});
  }

  Status writeVolume(const char* name, const VolumeInfo& info, std::span<const float> values) {
    VOLUTE_ASSIGN(auto sink, NpySink::create(folder_.path() / name, info));
    VOLUTE_TRY(sink->writeFrame(values));
    return sink->finish();
  }

  /// So that the sun shines in.
  Status openRoof(const char* name) const {
    VOLUTE_ASSIGN(std::string text, readText(folder_.path() / name));
    const std::string closed = "   12   12   99    0";
    const auto roof = text.find(closed);
    if (roof == std::string::npos)
      return fail(ErrorCode::kInvalidData, "{}: has no roof", name);
    text[roof + closed.size() - 1] = '2';
    std::ofstream(folder_.path() / name, std::ios::binary) << text;
    return {};
  }

  ScratchFolder folder_;
};

/// Light along rays by brute force.
class BruteForce {
 public:
  /// @param glows  media that send light themselves, out of view
  /// @param shades  media that take their part of the sky's light
  /// @param steps  of each ray, through all media
  BruteForce(const SceneSnapshot& snapshot, std::vector<bool> glows, std::vector<bool> shades,
             int steps)
      : snapshot_(snapshot), glows_(std::move(glows)), shades_(std::move(shades)), steps_(steps) {
    for (std::size_t i = 0; i < snapshot.media.size(); ++i) {
      std::vector<AnyMedium> parts;
      snapshot.media[i]->addExtinction(parts);
      for (AnyMedium& part : parts) {
        media_.push_back(std::move(part));
        of_.push_back(i);
      }
    }
  }

  Image picture(const Camera& camera) const {
    Image image(camera.width(), camera.height(), 3);
    parallelFor(static_cast<std::size_t>(camera.height()), [&](std::size_t y) {
      for (int x = 0; x < camera.width(); ++x) {
        const Rgb light = along(camera.ray(x + 0.5, static_cast<double>(y) + 0.5));
        for (int c = 0; c < 3; ++c)
          image.at(x, static_cast<int>(y), c) = static_cast<float>(light[c]);
      }
    });
    return image;
  }

 private:
  static constexpr int kStepsOfSky = 4;  ///< between those where it is asked for

  Rgb along(Segment ray) const {
    const SurfaceScene surfaces{snapshot_.geometry, snapshot_.lights.lamps,
                                snapshot_.lights.ambient, media_};
    const SurfacePoint wall = lookAtSurfaces(surfaces, {&ray, 1})[0];
    ray.end = std::min(ray.end, wall.hit.distance);
    Interval seen;
    bool first = true;
    for (const AnyMedium& medium : media_) {
      const Interval one =
          medium.bounds().intersect(ray.origin, ray.direction).intersect({ray.begin, ray.end});
      if (one.empty())
        continue;
      seen = first ? one : Interval{std::min(seen.begin, one.begin), std::max(seen.end, one.end)};
      first = false;
    }
    if (first)
      return wall.hit.found() ? wall.radiance : snapshot_.background;
    const auto count = static_cast<std::size_t>(steps_);
    std::vector<Segment> steps(count, ray);
    std::vector<Vec3> middles;
    for (std::size_t i = 0; i < count; ++i) {
      steps[i].begin = seen.begin + seen.length() * static_cast<double>(i) / steps_;
      steps[i].end = seen.begin + seen.length() * static_cast<double>(i + 1) / steps_;
      middles.push_back(ray.at(0.5 * (steps[i].begin + steps[i].end)));
    }
    std::vector<std::vector<double>> depths(media_.size(), std::vector<double>(count));
    std::vector<std::vector<double>> sky(media_.size(), std::vector<double>(count, 1));
    for (std::size_t m = 0; m < media_.size(); ++m) {
      media_[m].opticalDepth(steps, depths[m]);
      if (shades_[of_[m]] && !snapshot_.lights.ambient.isZero(0))
        sky[m] = sharesOfSky(media_[m], middles);
    }
    const std::vector<Rgb> arriving = arrivingAt(middles);
    Rgb sum = Rgb::Zero();
    double transmittance = 1;
    for (std::size_t i = 0; i < count; ++i) {
      double depth = 0;
      Rgb scattered = Rgb::Zero();
      for (std::size_t m = 0; m < media_.size(); ++m) {
        depth += depths[m][i];
        if (!glows_[of_[m]])
          scattered += depths[m][i] * (arriving[i] + sky[m][i] * snapshot_.lights.ambient);
      }
      if (depth > 0)
        sum += transmittance * -std::expm1(-depth) * kAlbedo / depth * scattered;
      transmittance *= std::exp(-depth);
    }
    return sum + transmittance * (wall.hit.found() ? wall.radiance : snapshot_.background);
  }

  /// What comes through a medium, in the mean of all directions: at every kStepsOfSky-th place, and
  /// linear between.
  static std::vector<double> sharesOfSky(const AnyMedium& medium, std::span<const Vec3> places) {
    std::vector<double> shares(places.size());
    std::size_t before = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (i % kStepsOfSky != 0 && i + 1 != places.size())
        continue;
      shares[i] = shareOfSky(medium, places[i]);
      for (std::size_t k = before + 1; k < i; ++k) {
        const double part = static_cast<double>(k - before) / static_cast<double>(i - before);
        shares[k] = std::lerp(shares[before], shares[i], part);
      }
      before = i;
    }
    return shares;
  }

  static double shareOfSky(const AnyMedium& medium, const Vec3& point) {
    constexpr int kDirections = 256;
    std::vector<Segment> ways;
    for (int i = 0; i < kDirections; ++i) {  // a spiral
      const double up = 1 - (2 * i + 1.0) / kDirections, aside = std::sqrt(1 - up * up);
      const double turn = 2.399963229728653 * i;
      ways.push_back({point, Vec3(aside * std::cos(turn), aside * std::sin(turn), up), 0,
                      std::numeric_limits<double>::infinity()});
    }
    std::vector<double> depths(ways.size());
    medium.opticalDepth(ways, depths);
    double sum = 0;
    for (const double depth : depths) sum += std::exp(-depth);
    return sum / kDirections;
  }

  /// Of lamps, scattered evenly, of albedo 1.
  std::vector<Rgb> arrivingAt(std::span<const Vec3> points) const {
    std::vector<Rgb> light(points.size(), Rgb::Zero());
    for (const Lamp& lamp : snapshot_.lights.lamps) {
      std::vector<Segment> ways;
      for (const Vec3& point : points) ways.push_back(lamp.towards(point));
      std::vector<double> depth(ways.size()), sum(ways.size(), 0);
      for (const AnyMedium& medium : media_) {
        medium.opticalDepth(ways, depth);
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += depth[i];
      }
      std::vector<std::uint8_t> blocked(ways.size(), 0);
      snapshot_.geometry.occluded(ways, blocked);
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (!blocked[i])
          light[i] += std::exp(-sum[i]) / (4 * std::numbers::pi) * lamp.irradiance(points[i]);
      }
    }
    return light;
  }

  const SceneSnapshot& snapshot_;
  std::vector<bool> glows_, shades_;
  std::vector<AnyMedium> media_;
  std::vector<std::size_t> of_;  ///< the scene's medium that it is of
  int steps_;
};

struct Difference {
  double most = 0, rms = 0;  ///< of the brightest
};

Difference differenceOf(const Image& found, const Image& exact) {
  double brightest = 0, squares = 0;
  Difference out;
  for (std::size_t i = 0; i < exact.pixels.size(); ++i) {
    const double off = std::abs(double(found.pixels[i]) - exact.pixels[i]);
    brightest = std::max(brightest, double(exact.pixels[i]));
    out.most = !(off <= out.most) ? off : out.most;
    squares += off * off;
  }
  if (out.most == 0)
    return out;  // all may be black
  out.rms = std::sqrt(squares / static_cast<double>(exact.pixels.size())) / brightest;
  out.most /= brightest;
  return out;
}

struct NamedMedia {
  std::string name;
  Place place;
  std::vector<Json> media;
};

/// Without its renderer.
std::string rowName(const NamedMedia& what, const NamedLight& light) {
  return fmt::format("{}, {}, ", light.name, what.name);
}

Status judge(const Cases& cases, const NamedMedia& what, const NamedLight& light, BenchRows& rows,
             Progress& progress) {
  Json json = {
      {"format", "volute-scene-2"}, {"media", what.media}, {"lights", light.lights(what.place)}};
  std::vector<bool> glows(what.media.size(), false), shades(what.media.size(), false);
  for (std::size_t i = 0; i < what.media.size(); ++i) {
    // Fog has the colour of its sky; a volume takes of it what comes through itself.
    if (light.name == "sky" && what.media[i]["kind"] == "fog")
      json["media"][i]["color"] = {kAlbedo, kAlbedo, kAlbedo};
    shades[i] = what.media[i]["kind"] == "volume";
  }
  if (light.fire) {
    json["media"].push_back(cases.fire(what.place));
    glows.push_back(true), shades.push_back(false);
  }
  Progress quiet;
  const SceneOptions options;
  VOLUTE_ASSIGN(auto scene, Scene::make(json, cases.path("scene.json"), options, quiet));
  const Camera camera =
      Camera::pinhole({what.place.eye, what.place.middle}, 50, kLitWidth, kLitHeight);
  scene.setViews({camera});
  VOLUTE_ASSIGN(const auto snapshot,
                scene.at({.factor = scene.law().factor(), .eye = camera.eye()}, quiet));
  const auto bySteps = [&](int steps) {
    return BruteForce(snapshot, glows, shades, steps).picture(camera);
  };
  const Image exact = bySteps(kLitSteps);
  const double own = differenceOf(bySteps(kLitSteps / 2), exact).most;
  std::vector<std::unique_ptr<SceneRenderer>> renderers;
  renderers.push_back(std::make_unique<CpuRenderer>());
#ifdef VOLUTE_WITH_GL
  if (auto gl = createGlRenderer(false))
    renderers.push_back(std::move(*gl));
#endif
  for (const auto& renderer : renderers) {
    const std::string name = rowName(what, light) + std::string(renderer->name());
    const auto image = renderer->render(snapshot, camera, {}, quiet);
    if (!image) {
      rows.add({name, NAN, "", std::nullopt, {}, image.error().message});
      continue;
    }
    const Difference off = differenceOf(*image, exact);
    rows.add(
        {name,
         100 * off.most,
         "% at most",
         std::nullopt,
         {{"light", light.name}, {"media", what.name}, {"renderer", std::string(renderer->name())}},
         fmt::format("RMS {:.2g} %; half as many steps of brute force {:.2g} % at most",
                     100 * off.rms, 100 * own)});
  }
  if (progress.cancelled())
    return fail(ErrorCode::kCancelled, "stopped in the benchmark of light");
  return {};
}

}  // namespace

Status benchLight(const BenchInput& input, BenchRows& rows, Progress& progress) {
  VOLUTE_ASSIGN(const auto cases, Cases::write(progress));
  bool any = false;
  const Place room{Vec3(0, 0, 2), 4, Vec3(-0.5, -6, 2.6), Vec3(0.3, -0.2, 5.6)};
  const Place hall{Vec3(12, 6, 3), 5.5, Vec3(3, 3, 2.5), Vec3(1.2, 4, 2.2)};
  std::vector<NamedMedia> all = {{"volume", room, {cases.volume(room)}},
                                 {"fog", room, {cases.fog(room)}},
                                 {"mesh", room, {cases.mesh()}},
                                 {"FDS", hall, {cases.fds()}},
                                 {"volume in fog", room, {cases.volume(room), cases.fog(room)}},
                                 {"mesh in fog", room, {cases.mesh(), cases.fog(room)}},
                                 {"volume and mesh", room, {cases.volume(room), cases.mesh()}},
                                 {"volume in FDS", hall, {cases.volume(hall), cases.fds()}}};
  if (input.quick)
    all.resize(2);
  for (const NamedMedia& media : all) {
    for (const NamedLight& light : kLights) {
      if (rowName(media, light).find(input.only) == std::string::npos)
        continue;
      any = true;
      VOLUTE_TRY(judge(cases, media, light, rows, progress));
    }
  }
  if (any)
    return {};
  return failFor("only", ErrorCode::kInvalidArgument, "no row of light has '{}' in its name",
                 input.only);
}

}  // namespace volute::bench
