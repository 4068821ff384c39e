// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <tuple>

namespace volute {
namespace {

/// What a quantity of FDS says about smoke, if anything.
std::optional<SmokeQuantity> smokeQuantityOf(const FdsLabels& labels) {
  const auto says = [&](const char* text) {
    return labels.quantity.find(text) != std::string::npos;
  };
  if (says("EXTINCTION COEFFICIENT") && labels.unit == "1/m")
    return SmokeQuantity::kExtinction;
  if (says("OPTICAL DENSITY") && labels.unit == "1/m")
    return SmokeQuantity::kOpticalDensity;
  if (says("SOOT DENSITY") && labels.unit == "kg/m3")
    return SmokeQuantity::kSootDensity;
  if (says("VISIBILITY") && labels.unit == "m")
    return SmokeQuantity::kVisibility;
  return std::nullopt;
}

int rankOf(SmokeQuantity quantity) {
  switch (quantity) {
    case SmokeQuantity::kExtinction:
      return 0;
    case SmokeQuantity::kOpticalDensity:
      return 1;
    case SmokeQuantity::kSootDensity:
      return 2;
    default:
      return 3;
  }
}

int rankOf(const FdsSource& source) {
  switch (source.kind) {
    case FdsFileKind::kSlice:
      return rankOf(source.quantity);
    case FdsFileKind::kSmoke16:
      return 4;
    case FdsFileKind::kSmokeDensity:
      return 5;
    case FdsFileKind::kSmoke:
      return 6;
    case FdsFileKind::kPlot:
      return 7;
  }
  return 8;
}

int meshesOf(const FdsSource& source) {
  std::set<int> meshes;
  for (const FdsSourcePart& part : source.parts) meshes.insert(part.mesh);
  return static_cast<int>(meshes.size());
}

bool isThere(const std::filesystem::path& path) {
  std::error_code code;
  return std::filesystem::exists(path, code);
}

bool isVolume(const FdsSliceEntry& slice) {
  if (!slice.nodes)
    return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (slice.nodes->begin[axis] == slice.nodes->end[axis])
      return false;
  }
  return true;
}

void addSlices(const SmvIndex& index, std::vector<FdsSource>& sources) {
  std::map<std::tuple<SmokeQuantity, bool, bool>, FdsSource> groups;
  for (std::size_t i = 0; i < index.slices.size(); ++i) {
    const FdsSliceEntry& slice = index.slices[i];
    const auto quantity = smokeQuantityOf(slice.labels);
    if (!quantity)
      continue;
    const bool volume = isVolume(slice);
    FdsSource& group = groups[{*quantity, volume, slice.cellCentred}];
    group.kind = FdsFileKind::kSlice;
    group.quantity = *quantity;
    group.cellCentred = slice.cellCentred;
    group.volume = volume;
    group.name = fmt::format("slice{}-{}{}", volume ? "3d" : "", nameOf(*quantity),
                             slice.cellCentred ? "-cells" : "");
    group.description = fmt::format("{} slices of {}, {}", volume ? "3D" : "2D", nameOf(*quantity),
                                    slice.cellCentred ? "values of cells" : "values at nodes");
    group.parts.push_back({slice.mesh, i});
  }
  for (auto& [key, group] : groups) sources.push_back(std::move(group));
}

void addSmoke(const SmvIndex& index, std::vector<FdsSource>& sources) {
  FdsSource bytes{"s3d", "8-bit smoke at nodes (.s3d)", FdsFileKind::kSmoke, {}, false, true, 0,
                  {}};
  FdsSource density{"s3dd",
                    "8-bit density of soot at nodes (.s3dd)",
                    FdsFileKind::kSmokeDensity,
                    {},
                    false,
                    true,
                    0,
                    {}};
  FdsSource words{
      "s16", "16-bit density of soot at nodes (.s16)", FdsFileKind::kSmoke16, {}, false, true, 0,
      {}};
  for (FdsSource* source : {&bytes, &density, &words})
    source->quantity = SmokeQuantity::kSootDensity;
  for (std::size_t i = 0; i < index.smoke.size(); ++i) {
    const FdsSmokeEntry& smoke = index.smoke[i];
    if (smoke.labels.quantity.find("SOOT") == std::string::npos)
      continue;
    bytes.parts.push_back({smoke.mesh, i});
    if (isThere(std::filesystem::path(smoke.file).replace_extension(".s3dd")))
      density.parts.push_back({smoke.mesh, i});
    if (isThere(std::filesystem::path(smoke.file).replace_extension(".s16")))
      words.parts.push_back({smoke.mesh, i});
  }
  for (FdsSource* source : {&words, &density, &bytes}) {
    if (!source->parts.empty())
      sources.push_back(std::move(*source));
  }
}

void addPlots(const SmvIndex& index, std::vector<FdsSource>& sources) {
  for (int variable = 0; variable < 5; ++variable) {
    FdsSource source;
    source.kind = FdsFileKind::kPlot;
    source.volume = true;
    source.plotVariable = variable;
    std::set<int> meshes;
    for (std::size_t i = 0; i < index.plots.size(); ++i) {
      const FdsPlotEntry& plot = index.plots[i];
      const auto quantity = smokeQuantityOf(plot.labels[static_cast<std::size_t>(variable)]);
      if (!quantity || !meshes.insert(plot.mesh).second)
        continue;
      source.quantity = *quantity;
      source.parts.push_back({plot.mesh, i});
    }
    if (source.parts.empty())
      continue;
    source.name = fmt::format("plot3d-{}", nameOf(source.quantity));
    source.description =
        fmt::format("PLOT3D files of {}, values at nodes", nameOf(source.quantity));
    sources.push_back(std::move(source));
  }
}

}  // namespace

std::vector<FdsSource> findSources(const SmvIndex& index) {
  std::vector<FdsSource> sources;
  addSlices(index, sources);
  addSmoke(index, sources);
  addPlots(index, sources);
  std::stable_sort(sources.begin(), sources.end(), [](const FdsSource& a, const FdsSource& b) {
    return std::make_tuple(rankOf(a), !a.volume, -meshesOf(a), !a.cellCentred) <
           std::make_tuple(rankOf(b), !b.volume, -meshesOf(b), !b.cellCentred);
  });
  return sources;
}

}  // namespace volute
