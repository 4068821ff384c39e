// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/render_job.hpp"

#include <sys/resource.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>

namespace volute::cli {
namespace {

double now() {
  const auto time = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::milli>(time).count();
}

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

}  // namespace

Stopwatch::Stopwatch(double& total) : total_(total), begin_(now()) {}

Stopwatch::~Stopwatch() {
  total_ += now() - begin_;
}

Result<Image> RenderJob::glPicture(const Moment& moment, Progress& progress) {
  {
    const Stopwatch watch(totals.slices);
    for (std::size_t i = 0; i < layers.size(); ++i) {
      VOLUTE_ASSIGN(const auto slice, layers[i].sliceAt(moment.positions[i]));
      totals.bricksStored += slice->storedBricks();
    }
  }
  const Stopwatch watch(totals.render);
  RenderStats found;
  VOLUTE_ASSIGN(auto image, gl->picture(camera, {layers, moment.positions, fogs, moment.time},
                                        options, progress, found));
  totals.rays += found.rays;
  totals.segments += found.segments;
  ++totals.pictures;
  return image;
}

Result<Image> RenderJob::picture(const Moment& moment, Progress& progress) {
  if (gl)
    return glPicture(moment, progress);
  std::vector<VoxelMedium> volumes;
  std::vector<AnyMedium> media;
  {
    const Stopwatch watch(totals.slices);
    for (std::size_t i = 0; i < layers.size(); ++i) {
      VOLUTE_ASSIGN(auto volume, layers[i].mediumAt(moment.positions[i]));
      media.emplace_back(volume);
      volumes.push_back(std::move(volume));
    }
    for (const FogLayer& fog : fogs) {
      VOLUTE_ASSIGN(auto medium, fog.mediumAt(moment.time, camera.eye()));
      media.push_back(std::move(medium));
    }
  }
  const Stopwatch watch(totals.render);
  RenderStats found;
  VOLUTE_ASSIGN(auto image, render(camera, media, options, progress, &found));
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
  const bool reference = options.renderer == Renderer::kReference;
  nlohmann::ordered_json stats = {{"renderer", gl          ? "gl"
                                               : reference ? "reference"
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
                                    {"write", totals.write}}},
                                  {"peak_memory_bytes", peakMemoryBytes()}};
  if (gl)
    stats["gl"] = gl->stats();
  return stats;
}

}  // namespace volute::cli
