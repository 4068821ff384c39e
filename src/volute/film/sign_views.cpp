// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/film/sign_views.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "volute/base/cancel_only.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/write_file.hpp"
#include "volute/film/film_job.hpp"
#include "volute/film/picture_writer.hpp"
#include "volute/image/srgb.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/report/page.hpp"
#include "volute/scene/scene.hpp"

namespace volute {
namespace {

Json vectorJson(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

Json signsJson(const Survey& survey) {
  Json signs = Json::array();
  for (const SightTarget& target : survey.signs) {
    const SafetySign& sign = target.sign;
    Json json = {{"name", sign.name},
                 {"position", vectorJson(target.target)},
                 {"normal", vectorJson(sign.normal)},
                 {"C", sign.law.c}};
    if (sign.size[0] > 0)
      json["size"] = {sign.size[0], sign.size[1]};
    signs.push_back(std::move(json));
  }
  return signs;
}

/// A lamp that shines down from a little below the highest gas over a point.
Json lampOver(const Vec3& point, const SightSnapshot& snapshot, const Box3& bounds) {
  constexpr int kSteps = 100;
  const double step = (bounds.max[2] - point[2]) / kSteps;
  Vec3 lamp = point;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 higher = point + Vec3(0, 0, i * step);
    Place place{};
    snapshot.places({&higher, 1}, {&place, 1});
    if (place != Place::kGas)
      break;
    lamp = point + Vec3(0, 0, 0.9 * i * step);
  }
  return {{"kind", "spot"},
          {"position", vectorJson(lamp)},
          {"target", vectorJson(lamp - Vec3(0, 0, 1))},
          {"angle", 150},
          {"intensity", {30, 30, 30}}};
}

/// Over the eye, the sign and between them.
Json lampsBetween(const Vec3& eye, const Vec3& sign, const SightSnapshot& snapshot,
                  const Box3& bounds) {
  Json lamps = Json::array();
  for (const double share : {0.0, 0.5, 0.9})
    lamps.push_back(lampOver(eye + share * (sign - eye), snapshot, bounds));
  return lamps;
}

/// From everywhere: where a building's lamps are an FDS case does not say.
constexpr double kEvenLight = 0.8;

Json evenLight() {
  return Json::array(
      {Json{{"kind", "ambient"}, {"radiance", {kEvenLight, kEvenLight, kEvenLight}}}});
}

/// The nearest sign that can be read from there if there is no smoke; the nearest of all where none
/// can.
std::pair<const SightTarget*, bool> nearestInSight(const Vec3& eye,
                                                   std::span<const SightTarget> signs,
                                                   const SightSnapshot& first) {
  std::vector<Sighting> sightings(signs.size());
  lookAround(first, signs, {&eye, 1}, sightings);
  const SightTarget* nearest = nullptr;
  bool inSight = false;
  for (std::size_t s = 0; s < signs.size(); ++s) {
    const bool seen = !sightings[s].blocked && sightings[s].limit > 0;
    const bool nearer = !nearest || (signs[s].target - eye).norm() < (nearest->target - eye).norm();
    if ((seen && !inSight) || (seen == inSight && nearer)) {
      nearest = &signs[s];
      inSight = seen;
    }
  }
  return {nearest, inSight};
}

}  // namespace

Result<SignViews> SignViews::make(std::vector<Vec3> eyes, const std::string& path,
                                  const FieldValue& members, const std::string& source,
                                  Reading& reading) {
  SignViews views(reading);
  views.eyes_ = std::move(eyes);
  if (views.eyes_.empty())
    return views;
  if (isScenePath(path)) {
    return fail(
        ErrorCode::kUnsupported,
        "{}: pictures from where people stand are made of a file alone; a scene has a camera "
        "of its own",
        path);
  }
  const MediumKind& kind = *mediumKindOf(path, false);
  const auto file = std::filesystem::absolute(path);
  views.scene_ = kind.sceneOf("");
  views.lit_ = !views.scene_.contains("lights");
  // As a file alone looks, but whole: the eye is within.
  auto& entry = views.scene_["media"][0];
  entry.update(kind.sceneOf(file.filename().string())["media"][0]);
  entry.update(members);
  for (const std::string& member : filesIn(kind.fields())) entry[member] = file.string();
  if (kind.fields().find("walls"))
    entry["walls"] = true;
  if (kind.fields().find("building"))
    entry["building"] = "whole";
  if (!source.empty() && kind.fields().find("field") && !members.contains("field"))
    entry["field"] = source;
  return views;
}

Status SignViews::begin(const Survey& survey, const SightSnapshot& first) {
  if (eyes_.empty())
    return {};
  std::error_code error;
  std::filesystem::create_directory(survey.folder / "views", error);
  for (const Vec3& eye : eyes_) {
    const auto [nearest, seen] = nearestInSight(eye, survey.signs, first);
    const Vec3 target = nearest->target;
    if (!seen) {
      reading_->progress.remark(
          {RemarkCode::kDoubtful,
           fmt::format(
               "from {}, {}, {} m no sign is in sight, even in clear air; the picture looks "
               "towards the nearest, {}",
               plainNumber(eye.x()), plainNumber(eye.y()), plainNumber(eye.z()),
               nearest->sign.name)});
    }
    const Json lamps = lit_ ? lampsBetween(eye, target, first, survey.bounds) : evenLight();
    // In even light clear air is as bright as the light.
    const double air = lit_ ? 0 : kEvenLight;
    const Json background = {air, air, air};
    const Json scene = {{"format", kSceneFormat},
                        {"camera",
                         {{"eye", vectorJson(eye)},
                          {"target", vectorJson(target)},
                          {"up", {0, 0, 1}},
                          {"fov", 55},
                          {"size", {640, 400}}}},
                        {"background", background},
                        {"lights", lamps},
                        {"media", scene_["media"]},
                        {"signs", signsJson(survey)}};
    const std::string name = fmt::format("views/view_{}.json", views_.size() + 1);
    VOLUTE_TRY(writeFile(survey.folder / name, dumpJson(scene) + "\n"));
    views_.push_back({eye, static_cast<std::size_t>(nearest - survey.signs.data()), seen, name});
  }
  return {};
}

Status SignViews::render(const View& view, const std::filesystem::path& target, double time,
                         PictureMode mode) const {
  StopOnly quiet(reading_->progress);
  SceneOptions options;
  options.maxMemory = reading_->maxMemory;
  VOLUTE_ASSIGN(auto scene, Scene::open(view.scene, options, quiet));
  PictureLaw law = scene.law();
  law.mode = mode;
  scene.setLaw(law);
  const CameraDescription description = *scene.camera();
  FilmJob job{std::move(scene),
              makeCamera(description, *description.size),
              {},
              std::make_unique<CpuRenderer>()};
  job.options.background = job.scene.description().background;
  job.legend = true;
  const FilmFrame frame{0, time};
  VOLUTE_ASSIGN(const auto image, job.picture(frame, quiet));
  // In even light, what is white is as bright as the light.
  Development development;
  development.style.exposure = lit_ ? suggestExposure(image) : 1 / kEvenLight;
  VOLUTE_ASSIGN(const auto writer, imageFileWriter(target.string(), development));
  VOLUTE_TRY(writer->write(image, 0, job.textOf(frame)));
  return writer->finish();
}

Result<std::string> SignViews::finish(const Survey& survey, Json& report) {
  if (views_.empty())
    return std::string();
  std::string page =
      "<h2>Views</h2>\n<p>Photometric: the transmitted light. Threshold: at the limit of "
      "visibility, a sign has faded to 10 %. The lighting is synthetic.</p>\n";
  report["pictures"] = Json::array();
  const std::size_t count = survey.times.size();
  std::vector<std::size_t> shown{count / 2, count - 1};
  shown.erase(std::ranges::unique(shown).begin(), shown.end());
  for (const View& view : views_) {
    for (const std::size_t t : shown) {
      for (const PictureMode mode : {PictureMode::kPhotometric, PictureMode::kThreshold}) {
        const std::string file = fmt::format(
            "{}_{:04d}_{}.png", view.scene.substr(0, view.scene.size() - 5), t, nameOf(mode));
        VOLUTE_TRY(
            render({view.eye, view.sign, view.inSight, (survey.folder / view.scene).string()},
                   survey.folder / file, survey.times[t], mode));
        report["pictures"].push_back({{"file", file},
                                      {"eye", vectorJson(view.eye)},
                                      {"sign", survey.signs[view.sign].sign.name},
                                      {"sign_in_sight", view.inSight},
                                      {"time", survey.times[t]},
                                      {"mode", nameOf(mode)}});
        VOLUTE_ASSIGN(
            const auto figure,
            htmlFigure(survey.folder / file,
                       fmt::format("From {}, {}, {} m towards {}{}, {} s, {}",
                                   plainNumber(view.eye[0]), plainNumber(view.eye[1]),
                                   plainNumber(view.eye[2]), survey.signs[view.sign].sign.name,
                                   view.inSight ? "" : " (no sign is in sight from there)",
                                   plainNumber(survey.times[t]), nameOf(mode))));
        page += figure;
      }
    }
  }
  return page;
}

}  // namespace volute
