// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/render_job.hpp"

#include <sys/resource.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>

#include "volute/render/scaled_medium.hpp"

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

Status RenderJob::processorMayDraw(const char* what) {
  const char* cpu = std::getenv("VOLUTE_CPU_RENDERER");
  if (!cpu || std::string_view(cpu) != "off")
    return {};
  return fail(ErrorCode::kUnsupported,
              "{} is drawn by the processor, which VOLUTE_CPU_RENDERER=off forbids", what);
}

Result<Image> RenderJob::picture(const Moment& moment, Progress& progress) {
  auto image = pictureBy(moment, progress);
  if (image || !gl || !glIsWish || image.error().code == ErrorCode::kCancelled)
    return image;
  progress.remark(
      fmt::format("the processor draws, since OpenGL does not: {}", image.error().message));
  gl.reset();
  smokeMethod = GlSmokeMethod::kAuto;
  return pictureBy(moment, progress);
}

Result<Image> RenderJob::pictureBy(const Moment& moment, Progress& progress) {
  glSubject = {.layers = layers,
               .positions = moment.positions,
               .fogs = fogs,
               .time = moment.time,
               .factor = law.factor(),
               .billboards = billboards,
               .fdsCases = fdsCases,
               .smokeMethod = smokeMethod};
  std::vector<VoxelMedium> volumes;
  std::vector<AnyMedium> media;
  const double factor = law.factor();
  {
    const Stopwatch watch(totals.slices);
    for (std::size_t i = 0; i < layers.size(); ++i) {
      VOLUTE_ASSIGN(auto volume, layers[i].mediumAt(moment.positions[i], factor));
      media.push_back(layers[i].placed(volume));
      volumes.push_back(std::move(volume));
    }
    if (!gl)
      VOLUTE_TRY(addBillboards(moment.time, media, progress));
    for (const FdsLayer& fds : fdsCases) {
      if (gl)
        break;  // it has its own
      VOLUTE_ASSIGN(auto medium, fds.mediumAt(moment.time));
      media.push_back(factor == 1 ? std::move(medium)
                                  : AnyMedium(ScaledMedium(std::move(medium), factor)));
      VOLUTE_ASSIGN(auto flame, fds.flameAt(moment.time));
      if (flame)
        media.push_back(std::move(*flame));
    }
    VOLUTE_TRY(placeBuildings(moment.time));
    glSubject.geometry = fixedGeometry ? *fixedGeometry : geometry;  // fog knows no buildings
    for (const FogLayer& fog : fogs) {
      if (gl)
        break;  // it has its own
      VOLUTE_ASSIGN(auto medium, fog.mediumAt(moment.time, camera));
      media.push_back(factor == 1 ? std::move(medium)
                                  : AnyMedium(ScaledMedium(std::move(medium), factor)));
    }
  }
  RenderStats found;
  const bool plain = smokes.empty() && signs.empty() && geometry.empty();
  const double begun = totals.slices;
  Result<Image> image = [&]() -> Result<Image> {
    const Stopwatch watch(totals.render);
    if (plain && gl)
      return gl->picture(camera, glSubject, options, progress, found);
    if (!gl)
      VOLUTE_TRY(processorMayDraw("this picture"));
    return plain ? render(camera, media, options, progress, &found)
                 : pictureWithSmoke(moment.time, media, progress, found);
  }();
  VOLUTE_TRY(image);
  totals.render -= totals.slices - begun;  // steps are read meanwhile
  totals.rays += found.rays;
  totals.segments += found.segments;
  totals.pieces += found.pieces;
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
  json["mode"] = nameOf(law.mode);
  if (law.mode == PictureMode::kThreshold)
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
