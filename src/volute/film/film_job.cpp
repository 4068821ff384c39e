// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/film/film_job.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "volute/base/cancel_only.hpp"
#include "volute/base/gather_values.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/process_usage.hpp"
#include "volute/image/picture_tiles.hpp"

namespace volute {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// Media that contours can be cut from.
std::vector<const MediumInfo*> contouredIn(const Scene& scene) {
  std::vector<const MediumInfo*> media;
  for (const auto& medium : scene.media()) {
    if (medium->info().mass || !medium->info().noMass.empty())
      media.push_back(&medium->info());
  }
  return media;
}

/// One plane has one scale of mass per volume.
Status checkConcentrations(std::span<const MediumInfo* const> media) {
  for (const MediumInfo* medium : media) {
    if (!medium->mass) {
      return failFor("slice_shows", ErrorCode::kInvalidArgument,
                     "concentration: {}, which tells no mass per volume; choose "
                     "visibility or extinction",
                     medium->noMass);
    }
    if (medium->mass->field != media.front()->mass->field) {
      return failFor("slice_shows", ErrorCode::kInvalidArgument,
                     "concentration: {} holds {} and {} {}, which have no scale in "
                     "common; choose visibility or extinction",
                     media.front()->file, media.front()->mass->field, medium->file,
                     medium->mass->field);
    }
  }
  return {};
}

}  // namespace

Status checkContour(const Contour& contour, const Scene& scene) {
  const bool slice = contour.kind == Contour::Kind::kSlice;
  const auto media = contouredIn(scene);
  if (media.empty()) {
    return failFor(slice ? "slice" : "isosurface", ErrorCode::kInvalidArgument,
                   "is for media on a mesh; there is none");
  }
  if (!slice)
    return {};
  Box3 bounds;
  for (const MediumInfo* medium : media) bounds.extend(medium->bounds);
  const double low = bounds.min[contour.axis], high = bounds.max[contour.axis];
  if (!(contour.place >= low && contour.place < high)) {
    return failFor("slice", ErrorCode::kInvalidArgument,
                   "{}={} misses the mesh, which reaches from {} to {} m along {}",
                   "xyz"[contour.axis], plainNumber(contour.place), plainNumber(low),
                   plainNumber(high), "xyz"[contour.axis]);
  }
  return contour.shows == Contour::Shows::kConcentration ? checkConcentrations(media) : Status();
}

/// A volume whose colours are values is seen as it is in any scene.
bool measuresLight(const Scene& scene) {
  const bool values = std::ranges::any_of(scene.media(), [](const auto& medium) {
    return medium->info().measured && medium->info().kind == "volume";
  });
  return values || (!scene.isFile() && scene.media().front()->info().measured);
}

Status cpuMayDraw(const char* what) {
  const char* cpu = std::getenv("VOLUTE_CPU_RENDERER");
  if (!cpu || std::string_view(cpu) != "off")
    return {};
  return fail(ErrorCode::kUnsupported,
              "{} is drawn by the CPU, which VOLUTE_CPU_RENDERER=off forbids", what);
}

namespace {

/// Around all media, however far they reach and wherever the wind takes them.
Box3 reachOf(const Scene& scene) {
  Box3 reach;
  for (const auto& medium : scene.media()) {
    if (medium->info().moves)
      reach = {Vec3::Constant(-std::numeric_limits<double>::infinity()),
               Vec3::Constant(std::numeric_limits<double>::infinity())};
    else if (!medium->info().bounds.empty())
      reach.extend(medium->info().bounds);
  }
  return reach;
}

/// Each pixel of the larger picture is the one of the smaller that it lies in.
Image enlarged(const Image& small, int width, int height) {
  Image image(width, height, small.channels);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < small.channels; ++c)
        image.at(x, y, c) = small.at(x * small.width / width, y * small.height / height, c);
    }
  }
  return image;
}

}  // namespace

Camera FilmJob::cameraAt(const FilmFrame& frame) const {
  Camera now = camera;
  if (cameraPath && !cameraPath->keys.empty()) {
    CameraDescription there = *cameraPath;
    there.view = cameraPath->viewAt(frame.time);
    now = makeCamera(there, {camera.width(), camera.height()});
  }
  if (orbit == 0)
    return now;
  const Vec3 up = cameraPath ? cameraPath->view.up : Vec3(Vec3::UnitZ());
  return now.turned(orbitCentre, up, frame.turn * orbit);
}

Result<Image> FilmJob::pictureOf(const SceneSnapshot& snapshot, const Camera& camera,
                                 Progress& progress, PictureCounts& counts) {
  if (contour) {
    VOLUTE_TRY(cpuMayDraw("a slice or an isosurface"));
    return lookAtContour(camera, snapshot.media, *contour);
  }
  if (renderer->name() != "gl")
    VOLUTE_TRY(cpuMayDraw("this picture"));
  const auto drawn = [&] {
    return partial && options.aov == Aov::kNone
               ? drawUntilStopped(snapshot, camera, progress, counts)
               : draw(snapshot, camera, samples, progress, counts);
  };
  auto image = drawn();
  if (image || !mayFallBack || renderer->name() != "gl" ||
      image.error().code == ErrorCode::kCancelled)
    return image;
  progress.remark({RemarkCode::kFallback,
                   fmt::format("the CPU draws, since OpenGL does not: {}", image.error().message)});
  renderer = std::make_unique<CpuRenderer>();
  VOLUTE_TRY(cpuMayDraw("this picture"));
  return drawn();
}

Result<Image> FilmJob::draw(const SceneSnapshot& snapshot, const Camera& camera, int rays,
                            Progress& progress, PictureCounts& counts) {
  const bool alpha = options.aov == Aov::kAlpha;
  return rays > 1 && (alpha || options.aov == Aov::kNone)
             ? renderer->renderSmooth(snapshot, camera, options, rays,
                                      alpha ? PictureStyle() : style, progress, &counts)
             : renderer->render(snapshot, camera, options, progress, &counts);
}

Result<Image> FilmJob::drawUntilStopped(const SceneSnapshot& snapshot, const Camera& camera,
                                        Progress& progress, PictureCounts& counts) {
  constexpr int kCoarse = 8;           // pixels a side that one of the coarse picture stands for
  constexpr double kTile = 128 * 128;  // pixels, about
  constexpr int kBeside = 2;  // pixels around a tile, so that edges are found as in the whole
  const int width = camera.width(), height = camera.height();
  const Camera small =
      camera.resized((width + kCoarse - 1) / kCoarse, (height + kCoarse - 1) / kCoarse);
  CancelOnly quiet(progress);
  VOLUTE_ASSIGN(Image picture, draw(snapshot, small, 1, quiet, counts));
  picture = enlarged(picture, width, height);
  drawnShare = 0;
  const double all = static_cast<double>(width) * height;
  for (const PictureTile& tile :
       pictureTiles(width, height, static_cast<int>(std::ceil(all / kTile)))) {
    const int left = std::max(tile.left - kBeside, 0), top = std::max(tile.top - kBeside, 0);
    const int right = std::min(tile.left + tile.width + kBeside, width);
    const int bottom = std::min(tile.top + tile.height + kBeside, height);
    const auto part = draw(snapshot, camera.cropped(left, top, right - left, bottom - top), samples,
                           quiet, counts);
    if (!part && part.error().code == ErrorCode::kCancelled)
      return picture;
    VOLUTE_TRY(part);
    for (int y = 0; y < tile.height; ++y) {
      for (int x = 0; x < tile.width; ++x) {
        for (int c = 0; c < picture.channels; ++c) {
          picture.at(tile.left + x, tile.top + y, c) =
              part->at(tile.left + x - left, tile.top + y - top, c);
        }
      }
    }
    drawnShare += tile.width * static_cast<double>(tile.height) / all;
    progress.report("rendering", drawnShare, 1);
  }
  drawnShare = 1;
  return picture;
}

Result<Image> FilmJob::picture(const FilmFrame& frame, Progress& progress) {
  if (!(shutter > 0))
    return pictureAt(frame, progress);
  constexpr int kMaxShutterTimes = 81;
  constexpr double kError = 1.0 / 256;
  Image mean;
  std::vector<double> sum;
  double change = 0;
  // The middles of fewer parts are among those of three times as many.
  for (int count = 1;; count *= 3) {
    for (int part = 0; part < count; ++part) {
      if (count > 1 && part % 3 == 1)
        continue;
      FilmFrame within = frame;
      within.time += (part + 0.5) / count * shutter;
      VOLUTE_ASSIGN(auto image, pictureAt(within, progress));
      sum.resize(image.pixels.size());
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += image.pixels[i];
      if (mean.pixels.empty())
        mean = std::move(image);
    }
    double brightest = 0;
    change = 0;
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const double now = sum[i] / count;
      change = std::max(change, std::abs(now - mean.pixels[i]));
      brightest = std::max(brightest, std::abs(now));
      mean.pixels[i] = static_cast<float>(now);
    }
    change = brightest > 0 ? change / brightest : 0;
    if (count == 1 || (change > kError && count < kMaxShutterTimes))
      continue;
    if (change > kError && totals.shutterError <= kError) {
      progress.remark({RemarkCode::kDoubtful,
                       fmt::format("frame {}: the light while the shutter is open is the mean of "
                                   "{} instants, and a third of them differs by {:.2g} of the "
                                   "brightest value",
                                   frame.number, count, change)});
    }
    totals.shutterTimes = std::max(totals.shutterTimes, count);
    totals.shutterError = std::max(totals.shutterError, change);
    return mean;
  }
}

Result<SceneSnapshot> FilmJob::snapshotAt(const FilmFrame& frame, Progress& progress) {
  const Stopwatch watch(totals.snapshots);
  VOLUTE_ASSIGN(auto snapshot, scene.at({.time = frame.time,
                                         .lit = options.aov == Aov::kNone && !contour,
                                         .tree = tree,
                                         .eye = seenFrom(camera)},
                                        progress));
  snapshot.background = options.background;
  return snapshot;
}

Result<Image> FilmJob::pictureAt(const FilmFrame& frame, Progress& progress) {
  VOLUTE_ASSIGN(const SceneSnapshot snapshot, snapshotAt(frame, progress));
  return drawn(snapshot, frame, progress);
}

Result<Image> FilmJob::drawn(const SceneSnapshot& snapshot, const FilmFrame& frame,
                             Progress& progress) {
  PictureCounts counts;
  Result<Image> image = [&] {
    const Stopwatch watch(totals.render);
    return pictureOf(snapshot, cameraAt(frame), progress, counts);
  }();
  VOLUTE_TRY(image);
  PictureCounts& sum = totals.counts;
  sum.surfaceMilliseconds += counts.surfaceMilliseconds;
  sum.surfacePixels += counts.surfacePixels;
  sum.shadowRays += counts.shadowRays;
  sum.render.rays += counts.render.rays;
  sum.render.segments += counts.render.segments;
  sum.render.pieces += counts.render.pieces;
  for (const auto& medium : snapshot.media) addCounts(totals.media, medium->counts());
  ++totals.pictures;
  return image;
}

Result<std::vector<ImageChannel>> FilmJob::layersAt(const FilmFrame& frame, Progress& progress) {
  const RenderOptions before = options;
  const auto has = [&](std::string_view name) {
    return std::ranges::find(layers, name) != layers.end();
  };
  std::vector<ImageChannel> channels;
  const auto drawn = [&](Aov aov) {
    options.aov = aov;
    options.within = reachOf(scene);
    auto image = picture(frame, progress);
    options = before;
    return image;
  };
  if (has("beauty")) {
    VOLUTE_ASSIGN(const auto image, drawn(Aov::kNone));
    for (std::size_t c = 0; c < 3; ++c) {
      ImageChannel& channel = channels.emplace_back(ImageChannel{std::string(1, "RGB"[c]), {}});
      for (std::size_t i = c; i < image.pixels.size(); i += 3)
        channel.values.push_back(image.pixels[i]);
    }
  }
  if (has("alpha")) {
    VOLUTE_ASSIGN(auto image, drawn(Aov::kAlpha));
    channels.push_back({"A", std::move(image.pixels)});
  }
  if (has("z")) {
    VOLUTE_ASSIGN(auto image, drawn(Aov::kDistance));
    channels.push_back({"Z", std::move(image.pixels)});
  }
  for (const auto& [name, aov] : {std::pair("transmittance", Aov::kTransmittance),
                                  std::pair("optical-depth", Aov::kOpticalDepth)}) {
    if (!has(name))
      continue;
    VOLUTE_ASSIGN(auto image, drawn(aov));
    channels.push_back({std::string(name) + ".Y", std::move(image.pixels)});
  }
  return channels;
}

OrderedJson FilmJob::stats() const {
  OrderedJson json = {{"renderer", renderer->name()},
                      {"size", {camera.width(), camera.height()}},
                      {"pictures", totals.pictures},
                      {"rays", totals.counts.render.rays},
                      {"segments", totals.counts.render.segments},
                      {"pieces", totals.counts.render.pieces}};
  OrderedJson media = {{"voxels_visited", 0}, {"bricks_visited", 0}, {"bricks_skipped", 0},
                       {"bricks_stored", 0},  {"bytes_read", 0},     {"blocks_decoded", 0},
                       {"tree_nodes", 0},     {"tree_bytes", 0},     {"nodes_visited", 0}};
  addCounts(media, totals.media);
  for (const auto& medium : scene.media()) addCounts(media, medium->counts());
  const OrderedJson last = {{"milliseconds",
                             {{"open", totals.open},
                              {"slices", totals.snapshots},
                              {"render", totals.render},
                              {"surfaces", totals.counts.surfaceMilliseconds},
                              {"convert", totals.convert},
                              {"write", totals.write}}},
                            {"peak_memory_bytes", peakMemoryBytes()}};
  json.update(media);
  json.update(last);
  if (totals.wall > 0) {
    // Stages run at once: their sum may be more than the time on the wall.
    const double all = totals.snapshots + totals.render + totals.write;
    json["stages"] = {{"read", totals.snapshots / all},
                      {"draw", totals.render / all},
                      {"convert", totals.convert / all},
                      {"encode", (totals.write - totals.convert) / all}};
    json["cores"] = {{"threads", threadCount()},
                     {"busy", totals.cpu / totals.wall / threadCount()},
                     {"wall_milliseconds", totals.wall}};
  }
  if (shutter > 0) {
    json["shutter"] = {
        {"seconds", shutter}, {"instants", totals.shutterTimes}, {"error", totals.shutterError}};
  }
  const PictureLaw law = scene.law();
  json["mode"] = contour ? modeOf(*contour) : std::string(nameOf(law.mode));
  if (contour ? contour->shows == Contour::Shows::kVisibility : law.mode == PictureMode::kThreshold)
    json["C"] = law.c;
  if (!scene.geometry().empty() || totals.counts.surfacePixels > 0) {
    json["geometry"] = {{"triangles", scene.surfaces().flat().size()},
                        {"surface_pixels", totals.counts.surfacePixels},
                        {"shadow_rays", totals.counts.shadowRays}};
  }
  if (auto own = renderer->stats(); !own.empty())
    json[std::string(renderer->name())] = std::move(own);
  return json;
}

Status scaleContour(FilmJob& job, Progress& progress, Team& team) {
  if (!job.contour || job.contour->shows == Contour::Shows::kVisibility)
    return {};
  double largest = 0;
  VOLUTE_TRY(team.forUnits("scaling", static_cast<std::int64_t>(job.frames.size()), progress,
                           [&](std::int64_t i) -> Status {
                             const FilmFrame& frame = job.frames[static_cast<std::size_t>(i)];
                             VOLUTE_ASSIGN(
                                 const auto snapshot,
                                 job.scene.at({.time = frame.time, .lit = false}, progress));
                             largest = std::max(largest, largestOn(*job.contour, snapshot.media));
                             return {};
                           }));
  VOLUTE_ASSIGN(const auto all, gatherValues(team, std::span<const double>(&largest, 1)));
  largest = std::ranges::max(all);
  job.contour->most = largest > 0 ? largest : 1;
  return {};
}

Result<std::vector<std::string>> parseLayers(const std::string& list) {
  constexpr std::string_view kNames[] = {"beauty", "alpha", "z", "transmittance", "optical-depth"};
  std::vector<std::string> layers;
  std::string rest = list;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(','), rest.size());
    layers.push_back(rest.substr(0, end));
    rest.erase(0, end + 1);
    const std::string& last = layers.back();
    if (std::ranges::find(kNames, last) == std::end(kNames)) {
      return fail(ErrorCode::kInvalidArgument, "'{}' is none of {}", last, fmt::join(kNames, ", "));
    }
    if (std::ranges::count(layers, last) > 1)
      return fail(ErrorCode::kInvalidArgument, "'{}' is named twice", last);
  }
  if (layers.size() == 1 && (layers[0] == "optical-depth" || layers[0] == "transmittance"))
    layers.clear();
  return layers;
}

Status checkTogether(const FilmJob& job) {
  if (!job.together)
    return {};
  std::string_view beyond;
  if (job.renderer->name() != "cpu")
    beyond = "is drawn by the renderer cpu";
  else if (job.contour)
    beyond = "has no slices and isosurfaces";
  else if (!job.layers.empty())
    beyond = "gives one layer at a time";
  else if (job.scene.media().size() != 1 || !job.scene.media().front()->info().shared)
    beyond = "is of one medium, that lies in several pieces or meshes";
  else if (!job.scene.geometry().empty() && !job.scene.description().lights.lamps.empty() &&
           !job.scene.media().front()->info().sharesAll)
    beyond = "has no surfaces in it that lamps light";
  if (beyond.empty())
    return {};
  return fail(ErrorCode::kUnsupported, "a picture of a mesh that ranks hold together {}", beyond);
}

Status checkPictureMemory(const Camera& camera, std::uint64_t maxMemory) {
  constexpr std::uint64_t kBytesAPixel = 32;
  const std::uint64_t bytes = kBytesAPixel * camera.width() * camera.height();
  if (bytes <= maxMemory)
    return {};
  return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
              "a picture of {} x {} pixels needs {} MiB of memory, more than the {} MiB allowed",
              camera.width(), camera.height(), (bytes >> 20) + 1, maxMemory >> 20);
}

}  // namespace volute
