// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/render_job.hpp"

#include <sys/resource.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>

#include "volute/cli/gl_drawer.hpp"

namespace volute::cli {
namespace {

/// The most memory that this program has held. getrusage() would count what its parent held before
/// it started us.
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

nlohmann::ordered_json smokeStats(const std::vector<SmokeLayer>& smokes) {
  SmokeCounts sum;
  for (const SmokeLayer& smoke : smokes) {
    sum.stepsRead += smoke.counts().stepsRead;
    sum.lightsComputed += smoke.counts().lightsComputed;
    sum.lightsReused += smoke.counts().lightsReused;
    sum.clamped += smoke.counts().clamped;
    sum.lightMilliseconds += smoke.counts().lightMilliseconds;
  }
  return {{"steps_read", sum.stepsRead},
          {"lights_computed", sum.lightsComputed},
          {"lights_reused", sum.lightsReused},
          {"negative_values_clamped", sum.clamped},
          {"light_milliseconds", sum.lightMilliseconds}};
}

}  // namespace

Result<Still> RenderJob::stillAt(const Moment& moment, std::vector<VoxelMedium>& volumes) {
  const double factor = law.factor();
  Still still;
  still.law = law;
  still.lights = lights;
  still.signs = signs;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (gl && volumeMethod == GlVolumeMethod::kTree)
      break;  // no instant of it is needed
    VOLUTE_ASSIGN(auto volume, layers[i].mediumAt(moment.positions[i], factor));
    still.media.push_back(layers[i].placed(volume));
    volumes.push_back(std::move(volume));
  }
  for (BillboardLayer& board : billboards) {
    VOLUTE_ASSIGN(auto medium, mediumOf(board, moment.time));
    still.viewed.push_back(std::move(medium));
  }
  for (const FdsLayer& fds : fdsCases) {
    if (gl)
      break;  // it has its own
    VOLUTE_ASSIGN(auto medium, fds.mediumAt(moment.time));
    still.media.push_back(seenBy(law, std::move(medium)));
    VOLUTE_ASSIGN(auto flame, fds.flameAt(moment.time));
    if (flame)
      still.media.push_back(std::move(*flame));
  }
  VOLUTE_TRY(placeBuildings(moment.time));
  still.geometry = geometry;
  for (const FogLayer& fog : fogs) {
    still.viewed.push_back(
        [&fog, time = moment.time, this](const Camera& eye) -> Result<AnyMedium> {
          VOLUTE_ASSIGN(auto medium, fog.mediumAt(time, eye));
          return seenBy(law, std::move(medium));
        });
  }
  for (SmokeLayer& smoke : smokes) {
    VOLUTE_ASSIGN(auto state, smoke.at(moment.time));
    still.smokes.push_back(std::move(state));
    still.walls.push_back(smoke.description().walls);
  }
  return still;
}

Result<Image> RenderJob::pictureOf(const Still& still, const Moment& moment, Progress& progress,
                                   StillCounts& counts) {
  if (contour) {
    VOLUTE_TRY(processorMayDraw("a slice or an isosurface"));
    return lookAtContour(camera, still.smokes, *contour);
  }
  if (gl) {
    GlDrawer drawer(*gl, {.layers = layers,
                          .positions = moment.positions,
                          .fogs = fogs,
                          .time = moment.time,
                          .smokes = still.smokes,
                          .factor = law.factor(),
                          .billboards = billboards,
                          .fdsCases = fdsCases,
                          .geometry = fixedGeometry ? *fixedGeometry : geometry,
                          .smokeMethod = smokeMethod,
                          .volumeMethod = volumeMethod});
    return still.picture(camera, options, drawer, progress, &counts);
  }
  VOLUTE_TRY(processorMayDraw("this picture"));
  return still.picture(camera, options, drawer, progress, &counts);
}

Result<Image> RenderJob::picture(const Moment& moment, Progress& progress) {
  auto image = pictureBy(moment, progress);
  if (image || !gl || !glIsWish || image.error().code == ErrorCode::kCancelled)
    return image;
  progress.remark(
      fmt::format("the processor draws, since OpenGL does not: {}", image.error().message));
  gl.reset();
  smokeMethod = GlSmokeMethod::kAuto;
  volumeMethod = GlVolumeMethod::kBricks;
  return pictureBy(moment, progress);
}

Result<Image> RenderJob::pictureBy(const Moment& moment, Progress& progress) {
  std::vector<VoxelMedium> volumes;
  Result<Still> still = [&] {
    const Stopwatch watch(totals.slices);
    return stillAt(moment, volumes);
  }();
  VOLUTE_TRY(still);
  StillCounts counts;
  Result<Image> image = [&] {
    const Stopwatch watch(totals.render);
    return pictureOf(*still, moment, progress, counts);
  }();
  VOLUTE_TRY(image);
  totals.surfaces += counts.surfaceMilliseconds;
  totals.surfacePixels += counts.surfacePixels;
  totals.shadowRays += counts.shadowRays;
  totals.rays += counts.render.rays;
  totals.segments += counts.render.segments;
  totals.pieces += counts.render.pieces;
  for (const VoxelMedium& volume : volumes) {
    const MarchCounts counts = volume.counts();
    totals.voxels += counts.voxels;
    totals.bricksVisited += counts.bricksVisited;
    totals.bricksSkipped += counts.bricksSkipped;
    totals.bricksStored += volume.slice().storedBricks();
  }
  ++totals.pictures;
  return image;
}

nlohmann::ordered_json RenderJob::stats() const {
  std::uint64_t bytesRead = 0, blocksDecoded = 0;
  TreeCounts tree;
  for (const VolumeLayer& layer : layers) {
    if (!layer.reader())
      continue;
    bytesRead += layer.reader()->bytesRead();
    blocksDecoded += layer.reader()->blocksDecoded();
    tree.nodes += layer.treeCounts().nodes;
    tree.treeBytes += layer.treeCounts().treeBytes;
    tree.nodesVisited += layer.treeCounts().nodesVisited;
  }
  nlohmann::ordered_json json = {
      {"renderer", gl                                         ? "gl"
                   : options.renderer == Renderer::kReference ? "reference"
                                                              : "cpu"},
      {"size", {camera.width(), camera.height()}},
      {"pictures", totals.pictures},
      {"rays", totals.rays},
      {"segments", totals.segments},
      {"pieces", totals.pieces},
      {"voxels_visited", totals.voxels},
      {"bricks_visited", totals.bricksVisited},
      {"bricks_skipped", totals.bricksSkipped},
      {"bricks_stored", totals.bricksStored},
      {"bytes_read", bytesRead},
      {"blocks_decoded", blocksDecoded},
      {"tree_nodes", tree.nodes},
      {"tree_bytes", tree.treeBytes},
      {"nodes_visited", tree.nodesVisited},
      {"milliseconds",
       {{"open", totals.open},
        {"slices", totals.slices},
        {"render", totals.render},
        {"surfaces", totals.surfaces},
        {"write", totals.write}}},
      {"peak_memory_bytes", peakMemoryBytes()}};
  const bool threshold = law.mode == PictureMode::kThreshold;
  json["mode"] = contour ? modeOf(*contour) : std::string(nameOf(law.mode));
  if (contour ? contour->shows == SmokeContour::Shows::kVisibility : threshold)
    json["C"] = law.c;
  if (!geometry.empty()) {
    json["geometry"] = {{"triangles", geometry.triangles().size()},
                        {"surface_pixels", totals.surfacePixels},
                        {"shadow_rays", totals.shadowRays}};
  }
  if (gl)
    json["gl"] = gl->stats();
  if (!smokes.empty())
    json["smoke"] = smokeStats(smokes);
  return json;
}

}  // namespace volute::cli
