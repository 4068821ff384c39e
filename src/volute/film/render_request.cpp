// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/film/render_request.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "volute/base/plain_number.hpp"
#include "volute/film/write_film.hpp"
#include "volute/io/color_view.hpp"
#include "volute/media/medium_kind.hpp"
#include "volute/scene/kinds.hpp"
#include "volute/scene/picture_camera.hpp"

namespace volute {
namespace {

PictureStyle styleOf(const RenderRequest& request, const FilmJob& job) {
  PictureStyle style;
  style.exposure = request.exposure;
  if (job.measured)
    return style;
  style.dither = true;
  style.glow = request.bloom;
  const bool plain =
      measuresLight(job.scene) || job.contour || job.scene.law().mode == PictureMode::kThreshold;
  const bool burns = std::ranges::any_of(job.scene.media(),
                                         [](const auto& medium) { return medium->info().burns; });
  const bool flames = burns && measuresLight(job.scene) && !job.contour &&
                      job.scene.law().mode != PictureMode::kThreshold;
  style.tone = request.tone.value_or(flames  ? ToneCurve::kShoulder
                                     : plain ? ToneCurve::kNone
                                             : ToneCurve::kFilmic);
  style.view = request.view;
  return style;
}

/// Adds the whole path of a camera that moves, whichever frames of it are requested: parts of one
/// film that several machines draw are drawn alike.
void addViewsAlongPath(const FilmJob& job, std::vector<Camera>& views) {
  constexpr int kBetween = 8, kTurns = 16;
  const auto add = [&](double time) {
    for (int turn = 0; turn < (job.orbit == 0 ? 1 : kTurns); ++turn)
      views.push_back(job.cameraAt({0, time, static_cast<double>(turn) / kTurns}));
  };
  const std::vector<CameraKey> keys =
      job.cameraPath ? job.cameraPath->keys : std::vector<CameraKey>();
  for (std::size_t i = 1; i < keys.size(); ++i) {
    for (int k = 0; k <= kBetween; ++k)
      add(std::lerp(keys[i - 1].time, keys[i].time, static_cast<double>(k) / kBetween));
  }
  if (keys.size() < 2 && job.orbit != 0 && !job.frames.empty())
    add(job.frames.front().time);
}

}  // namespace

Status takeTone(const std::string& name, RenderRequest& request) {
  if (namesColorView(name)) {
    VOLUTE_ASSIGN(request.view, openColorView(name));
    request.tone = ToneCurve::kFilmic;  // for whose middle the exposure is chosen
    return {};
  }
  for (const ToneCurve tone :
       {ToneCurve::kNone, ToneCurve::kFilmic, ToneCurve::kAgx, ToneCurve::kShoulder}) {
    if (name == nameOf(tone))
      request.tone = tone;
  }
  if (request.tone || name == "auto")
    return {};
  return failFor("tone", ErrorCode::kInvalidArgument,
                 "'{}' is unknown; expected auto, none, filmic, agx, shoulder, aces, ocio, "
                 "ocio:VIEW or ocio:DISPLAY/VIEW",
                 name);
}

namespace {

/// A camera of a glTF has a shape, and the picture another.
void tellOfShape(const CameraDescription& camera, const Camera& taken, Progress& progress) {
  const double width = taken.width(), height = taken.height();
  const double stated = camera.aspect.value_or(width / height);
  if (std::abs(stated * height - width) <= std::max(1.5, 0.01 * width))
    return;
  progress.remark(
      {RemarkCode::kDoubtful,
       fmt::format("the camera's pictures are {:.3g} times as wide as high, this one is {:.3g} "
                   "times: it shows as much from bottom to top, and {} at the sides",
                   stated, width / height, width / height < stated ? "less" : "more")});
}

/// Fog has no end in time: its first map is there before, its last one after.
void tellOfMapsEnds(const FilmJob& job, Progress& progress) {
  constexpr double kSlack = 1e-6;  // [s]
  const auto [first, last] = std::ranges::minmax(job.frames, {}, &FilmFrame::time);
  for (const auto& medium : job.scene.media()) {
    const MediumInfo& info = medium->info();
    if (!info.endless || info.loops || info.times.size() < 2)
      continue;
    const auto tell = [&](double time, const char* which, double at) {
      progress.remark(Remark{RemarkCode::kAssumed,
                             fmt::format("{}: {} s is {} map, at {} s, which stays", info.file,
                                         plainNumber(time), which, plainNumber(at))}
                          .in(info.file));
    };
    if (first.time < info.times.front() - kSlack)
      tell(first.time, "before the first", info.times.front());
    if (last.time > info.times.back() + kSlack)
      tell(last.time, "after the last", info.times.back());
  }
}

}  // namespace

void addUsualMembers(const std::string& path, const RenderUse& use, SceneOptions& options) {
  options.files.measured = use.measured;
  options.files.byTree = use.tree;
  options.files.depths = use.depth;
  if (isScenePath(path) || (!use.moves && !use.values))
    return;
  registerUsualMedia();
  if (use.values && !use.depth && !options.members->contains("preset") &&
      mediumKindOf(path, true)->fields().find("preset"))
    (*options.members)["preset"] = "none";
  if (use.moves && !options.members->contains("interpolate") &&
      mediumKindOf(path, true)->fields().find("interpolate"))
    (*options.members)["interpolate"] = "auto";
}

Status prepare(FilmJob& job, const RenderRequest& request, std::uint64_t maxMemory,
               Progress& progress) {
  VOLUTE_ASSIGN(auto seen, pictureCamera(job.scene, request.camera, request.size, request.parts));
  FrameRequest frames = request.frames;
  if (seen.description && !seen.description->keys.empty())
    frames.pathEnd = seen.description->keys.back().time;
  VOLUTE_ASSIGN(auto chosen, chooseFrames(frames, job.scene, progress));
  job.frames = std::move(chosen.frames);
  job.reason = std::move(chosen.reason);
  VOLUTE_TRY(checkPictureMemory(seen.camera, maxMemory));
  job.camera = seen.camera;
  job.options = {};
  job.options.background = request.background.value_or(job.scene.description().background);
  job.options.aov = request.aov;
  job.framesPerSecond = framesPerSecond(job.scene, request.frames, job.frames);
  const SceneMedium* leader = leaderOf(job.scene);
  job.frameScale = leader ? leader->info().frameScale : FrameScale{};
  const auto media = job.scene.media();
  const bool captioned = !job.scene.isFile() && !media.empty() && media.front()->info().captioned &&
                         request.aov == Aov::kNone;
  job.legend = request.legend.value_or(captioned);
  job.orbit = request.frames.orbit.value_or(0) * std::numbers::pi / 180;
  job.orbitCentre =
      seen.description ? seen.description->view.target : Vec3(job.scene.framed().centre());
  constexpr double kNarrow = 2;  // [degrees]: a lens of 700 mm on film of 24 x 36 mm
  if (const auto fov = seen.description ? seen.description->fov : std::nullopt;
      fov && *fov < kNarrow) {
    progress.remark(
        {RemarkCode::kDoubtful,
         fmt::format("fov {:g} degrees shows {:.3g} m at the target: is it in radians? "
                     "{:.4g} degrees would be",
                     *fov,
                     2 * (seen.description->view.target - seen.description->view.eye).norm() *
                         std::tan(*fov * std::numbers::pi / 360),
                     *fov * 180 / std::numbers::pi)});
  }
  if (seen.description)
    tellOfShape(*seen.description, seen.camera, progress);
  tellOfMapsEnds(job, progress);
  job.cameraPath = std::move(seen.description);
  job.measured = request.measured || request.aov != Aov::kNone;
  job.samples = job.measured || job.contour ? 1 : request.samples;
  if (!job.measured) {
    std::vector<Camera> views;
    for (const FilmFrame& frame : job.frames) views.push_back(job.cameraAt(frame));
    if (!request.frames.time)
      addViewsAlongPath(job, views);
    job.scene.setViews(std::move(views));
  }
  if (!(request.shutter > 0))
    return {};
  if (request.aov != Aov::kNone || job.contour || !job.layers.empty()) {
    return failFor("shutter", ErrorCode::kInvalidArgument,
                   "averages light; depths, slices and layers are of an instant");
  }
  double frame = request.frames.speed / job.framesPerSecond;
  if (job.frames.size() < 2 && leader && leader->info().times.size() > 1) {
    const auto& times = leader->info().times;
    frame = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  }
  job.shutter = request.shutter * frame;
  if (std::ranges::none_of(
          media,
          [](const auto& medium) { return medium->info().interpolates || medium->info().moves; }) &&
      !(job.cameraPath && !job.cameraPath->keys.empty())) {
    progress.remark(
        {RemarkCode::kDoubtful,
         "nothing moves while the shutter is open, as no medium is interpolated between "
         "its frames"});
  }
  return {};
}

namespace {

/// The colours of a slice are values, which its legend names.
Status checkSliceStyle(const RenderRequest& request, const FilmJob& job) {
  if (!job.contour || job.contour->kind != Contour::Kind::kSlice)
    return {};
  const bool exposed = request.exposure != 0 && request.exposure != 1;
  const bool toned = request.view || request.tone.value_or(ToneCurve::kNone) != ToneCurve::kNone;
  for (const auto& [name, given] : {std::pair("exposure", exposed), std::pair("tone", toned),
                                    std::pair("bloom", request.bloom > 0)}) {
    if (given)
      return failFor(name, ErrorCode::kInvalidArgument,
                     "changes colours; those of a slice are values: leave it out");
  }
  return {};
}

}  // namespace

Result<Development> developmentOf(const RenderRequest& request, const FilmJob& job) {
  VOLUTE_TRY(checkSliceStyle(request, job));
  Development development;
  development.style = styleOf(request, job);
  development.colorMap = request.colors;
  for (const auto& [name, given] :
       {std::pair("bloom", request.bloom > 0), std::pair("tone", request.tone || request.view)}) {
    if (request.colors && given)
      return failFor(name, ErrorCode::kInvalidArgument,
                     "has no effect on a colour map, whose colours are values: leave it out");
  }
  if (!request.colors || job.options.aov != Aov::kNone)
    return development;
  if (request.background.value_or(Rgb::Zero()).maxCoeff() > 0) {
    return failFor("background", ErrorCode::kInvalidArgument,
                   "would count as a value that the colour map shows: leave it out");
  }
  for (const auto& medium : job.scene.media()) {
    if (medium->info().channels == 1)
      continue;
    auto failed =  // a preset that was asked for
        failFor("colormap", ErrorCode::kInvalidArgument,
                "is for volumes with one channel and for optical depths; {}",
                medium->info().measured
                    ? "this shows " + medium->info().kind
                    : "this one is RGB: its values, its flames or the light on it have colours");
    if (!job.scene.isFile() && medium->info().kind == "volume")
      failed.value().hints = {Hint::set("preset", "none").so("shows the values of one channel")};
    return failed;
  }
  if (!job.scene.geometry().empty()) {
    return failFor("colormap", ErrorCode::kInvalidArgument,
                   "is for volumes with one channel and for optical depths; this shows "
                   "surfaces");
  }
  return development;
}

Result<Image> linearPicture(FilmJob& job, const Development& development, Progress& progress) {
  job.style = development.style;
  if (job.style.exposure == 0)
    job.style.exposure = 1;
  return job.picture(job.frames.front(), progress);
}

Result<Image> visiblePicture(FilmJob& job, Development& development, Progress& progress) {
  if (development.style.exposure == 0) {
    VOLUTE_ASSIGN(development.style.exposure, usualExposure(job, development, progress));
  }
  VOLUTE_ASSIGN(const Image image, linearPicture(job, development, progress));
  return developed(image, development, job.textOf(job.frames.front()));
}

}  // namespace volute
