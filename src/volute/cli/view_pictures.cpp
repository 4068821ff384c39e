// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/view_pictures.hpp"

#include <algorithm>

#include "volute/base/write_file.hpp"
#include "volute/cli/command.hpp"
#include "volute/cli/parse.hpp"
#include "volute/cli/report.hpp"
#include "volute/fds/smv_index.hpp"
#include "volute/report/page.hpp"

namespace volute::cli {
namespace {

/// Passes on the wish to stop and nothing else.
class Quiet final : public Progress {
 public:
  explicit Quiet(const Progress& next) : next_(next) {}

  bool cancelled() const override { return next_.cancelled(); }

 private:
  const Progress& next_;
};

Json vectorJson(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

/// The smoke of a scene from the options of a command line.
Json smokeJson(const std::string& casePath, const Arguments& arguments) {
  Json smoke = {
      {"kind", "smoke"}, {"case", std::filesystem::absolute(casePath).string()}, {"walls", true}};
  for (const auto& [option, key] : {std::pair("field", "field"),
                                    {"quantity", "quantity"},
                                    {"unit", "unit"},
                                    {"material", "material"},
                                    {"burning", "burning"},
                                    {"density-field", "density_field"},
                                    {"C", "C"}}) {
    if (const auto text = arguments.find<std::string>(option))
      smoke[key] = *text;
  }
  for (const auto& [option, key] : {std::pair("scale", "scale"),
                                    {"mass-extinction", "mass_extinction"},
                                    {"soot-yield", "soot_yield"}}) {
    if (const auto number = arguments.find<double>(option))
      smoke[key] = *number;
  }
  if (arguments.flag("clamp"))
    smoke["negatives"] = "clamp";
  return smoke;
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
Json lampOver(const Vec3& point, const SightInstant& instant, const Box3& bounds) {
  constexpr int kSteps = 100;
  const double step = (bounds.max[2] - point[2]) / kSteps;
  Vec3 lamp = point;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 higher = point + Vec3(0, 0, i * step);
    Place place{};
    instant.places({&higher, 1}, {&place, 1});
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
Json lampsBetween(const Vec3& eye, const Vec3& sign, const SightInstant& instant,
                  const Box3& bounds) {
  Json lamps = Json::array();
  for (const double share : {0.0, 0.5, 0.9})
    lamps.push_back(lampOver(eye + share * (sign - eye), instant, bounds));
  return lamps;
}

/// From everywhere: where a building's lamps are an FDS case does not say.
constexpr double kEvenLight = 0.8;

Json evenLight() {
  return Json::array(
      {Json{{"kind", "ambient"}, {"radiance", {kEvenLight, kEvenLight, kEvenLight}}}});
}

Status render(const std::string& scene, const std::string& target, double time, const char* mode,
              const std::string& exposure, Context& context) {
  const Command* command = findCommand("render");
  VOLUTE_ASSIGN(const auto arguments,
                parseArguments(*command, {scene, "-o", target, "--time", fmt::format("{}", time),
                                          "--mode", mode, "--legend", "--renderer", "cpu",
                                          "--cache", "none", "--exposure", exposure}));
  Quiet quiet(context.progress);
  Context own{quiet, context.maxMemory};
  return command->run(arguments, own);
}

}  // namespace

ViewPictures::ViewPictures(std::vector<Vec3> eyes, const std::string& casePath,
                           const Arguments& arguments, Context& context)
    : eyes_(std::move(eyes)),
      smoke_(smokeJson(casePath, arguments)),
      lit_(!isSmvPath(casePath)),
      context_(context) {}

Status ViewPictures::begin(const Survey& survey, const SightInstant& first) {
  if (eyes_.empty())
    return {};
  std::error_code error;
  std::filesystem::create_directory(survey.folder / "views", error);
  for (const Vec3& eye : eyes_) {
    const auto nearest = std::ranges::min_element(
        survey.signs, {}, [&](const SightTarget& sign) { return (sign.target - eye).norm(); });
    const Vec3 target = nearest->target;
    const Json lamps = lit_ ? lampsBetween(eye, target, first, survey.bounds) : evenLight();
    const Json scene = {{"format", "volute-scene-1"},
                        {"camera",
                         {{"eye", vectorJson(eye)},
                          {"target", vectorJson(target)},
                          {"up", {0, 0, 1}},
                          {"fov", 55},
                          {"size", {640, 400}}}},
                        {"lights", lamps},
                        {"media", {smoke_}},
                        {"signs", signsJson(survey)}};
    const std::string name = fmt::format("views/view_{}.json", views_.size() + 1);
    VOLUTE_TRY(writeFile(survey.folder / name, dumpJson(scene) + "\n"));
    views_.push_back({eye, static_cast<std::size_t>(nearest - survey.signs.begin()), name});
  }
  return {};
}

Result<std::string> ViewPictures::finish(const Survey& survey, Json& report) {
  if (views_.empty())
    return std::string();
  std::string page =
      "<h2>What is seen</h2>\n<p>Photometric: the light that passes. Threshold: what has faded to "
      "10 % is what the law calls no longer visible. The light is made up.</p>\n";
  report["pictures"] = Json::array();
  // In even light, what is white is as bright as the light.
  const std::string exposure = lit_ ? "auto" : fmt::format("{}", 1 / kEvenLight);
  const std::size_t count = survey.times.size();
  std::vector<std::size_t> shown{count / 2, count - 1};
  shown.erase(std::ranges::unique(shown).begin(), shown.end());
  for (const View& view : views_) {
    for (const std::size_t t : shown) {
      for (const char* mode : {"photometric", "threshold"}) {
        const std::string file =
            fmt::format("{}_{:04d}_{}.png", view.scene.substr(0, view.scene.size() - 5), t, mode);
        VOLUTE_TRY(render((survey.folder / view.scene).string(), (survey.folder / file).string(),
                          survey.times[t], mode, exposure, context_));
        report["pictures"].push_back({{"file", file},
                                      {"eye", vectorJson(view.eye)},
                                      {"sign", survey.signs[view.sign].sign.name},
                                      {"time", survey.times[t]},
                                      {"mode", mode}});
        VOLUTE_ASSIGN(
            const auto figure,
            htmlFigure(survey.folder / file,
                     fmt::format("From {:g}, {:g}, {:g} m towards {}, {:g} s, {}", view.eye[0],
                                 view.eye[1], view.eye[2], survey.signs[view.sign].sign.name,
                                 survey.times[t], mode)));
        page += figure;
      }
    }
  }
  return page;
}

}  // namespace volute::cli
