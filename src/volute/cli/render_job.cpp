// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/render_job.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>

namespace volute::cli {
namespace {

using OrderedJson = nlohmann::ordered_json;

}  // namespace

// getrusage() would count what this program's parent held before it started us.
std::uint64_t peakMemoryBytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:"))
      return 1024 * std::strtoull(line.c_str() + 6, nullptr, 10);
  }
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return 1024 * static_cast<std::uint64_t>(usage.ru_maxrss);
}

bool measuresLight(const Scene& scene) {
  return !scene.isFile() && scene.media().front()->info().measured;
}

Status cpuMayDraw(const char* what) {
  const char* cpu = std::getenv("VOLUTE_CPU_RENDERER");
  if (!cpu || std::string_view(cpu) != "off")
    return {};
  return fail(ErrorCode::kUnsupported,
              "{} is drawn by the CPU, which VOLUTE_CPU_RENDERER=off forbids", what);
}

Camera RenderJob::cameraAt(const Moment& moment) const {
  Camera now = camera;
  if (way && !way->keys.empty()) {
    CameraDescription there = *way;
    there.view = way->viewAt(moment.time);
    now = makeCamera(there, {camera.width(), camera.height()});
  }
  if (orbit == 0)
    return now;
  const Vec3 up = way ? way->view.up : Vec3(Vec3::UnitZ());
  return now.turned(orbitCentre, up, moment.turn * orbit);
}

Result<Image> RenderJob::pictureOf(const Snapshot& snapshot, const Camera& camera,
                                   Progress& progress, PictureCounts& counts) {
  if (contour) {
    VOLUTE_TRY(cpuMayDraw("a slice or an isosurface"));
    return lookAtContour(camera, snapshot.media, *contour);
  }
  if (renderer->name() != "gl")
    VOLUTE_TRY(cpuMayDraw("this picture"));
  const auto draw = [&] {
    return samples > 1 && options.aov == Aov::kNone
               ? renderer->renderSmooth(snapshot, camera, options, samples, style, progress,
                                        &counts)
               : renderer->render(snapshot, camera, options, progress, &counts);
  };
  auto image = draw();
  if (image || !mayFallBack || renderer->name() != "gl" ||
      image.error().code == ErrorCode::kCancelled)
    return image;
  progress.remark(fmt::format("the CPU draws, since OpenGL does not: {}", image.error().message));
  renderer = std::make_unique<CpuRenderer>();
  VOLUTE_TRY(cpuMayDraw("this picture"));
  return draw();
}

Result<Image> RenderJob::picture(const Moment& moment, Progress& progress) {
  Result<Snapshot> snapshot = [&] {
    const Stopwatch watch(totals.snapshots);
    return scene.at({.time = moment.time, .tree = tree, .eye = seenFrom(camera)}, progress);
  }();
  VOLUTE_TRY(snapshot);
  snapshot->background = options.background;
  PictureCounts counts;
  Result<Image> image = [&] {
    const Stopwatch watch(totals.render);
    return pictureOf(*snapshot, cameraAt(moment), progress, counts);
  }();
  VOLUTE_TRY(image);
  PictureCounts& sum = totals.counts;
  sum.surfaceMilliseconds += counts.surfaceMilliseconds;
  sum.surfacePixels += counts.surfacePixels;
  sum.shadowRays += counts.shadowRays;
  sum.render.rays += counts.render.rays;
  sum.render.segments += counts.render.segments;
  sum.render.pieces += counts.render.pieces;
  for (const auto& medium : snapshot->media) addCounts(totals.media, medium->counts());
  ++totals.pictures;
  return image;
}

Result<std::vector<ImageChannel>> RenderJob::layersAt(const Moment& moment, Progress& progress) {
  const RenderOptions before = options;
  const auto has = [&](std::string_view name) {
    return std::ranges::find(layers, name) != layers.end();
  };
  std::vector<ImageChannel> channels;
  const auto drawn = [&](Aov aov) {
    options.aov = aov;
    options.within = scene.bounds();
    auto image = picture(moment, progress);
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

OrderedJson RenderJob::stats() const {
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
                              {"write", totals.write}}},
                            {"peak_memory_bytes", peakMemoryBytes()}};
  json.update(media);
  json.update(last);
  const PictureLaw law = scene.law();
  json["mode"] = contour ? modeOf(*contour) : std::string(nameOf(law.mode));
  if (contour ? contour->shows == Contour::Shows::kVisibility : law.mode == PictureMode::kThreshold)
    json["C"] = law.c;
  if (!scene.geometry().empty() || totals.counts.surfacePixels > 0) {
    json["geometry"] = {{"triangles", scene.surfaces().triangles().size()},
                        {"surface_pixels", totals.counts.surfacePixels},
                        {"shadow_rays", totals.counts.shadowRays}};
  }
  if (auto own = renderer->stats(); !own.empty())
    json[std::string(renderer->name())] = std::move(own);
  return json;
}

}  // namespace volute::cli
