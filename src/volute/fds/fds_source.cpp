// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <compare>
#include <iterator>
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
    case FdsFileKind::kClear:
      return 8;
  }
  return 8;
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

/// How a source spells a quantity of FDS in its name: slice-gas-temperature.
std::string spelled(std::string_view quantity) {
  std::string name;
  for (const char c : quantity)
    name += c == ' ' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

/// What is looked for: smoke in any spelling, or one quantity.
struct Wanted {
  std::string_view quantity{};  // empty: smoke

  struct Found {
    SmokeQuantity smoke = SmokeQuantity::kExtinction;
    std::string name;

    auto operator<=>(const Found&) const = default;
  };

  std::optional<Found> in(const FdsLabels& labels) const {
    if (!quantity.empty()) {
      return labels.quantity == quantity ? std::optional(Found{{}, spelled(quantity)})
                                         : std::nullopt;
    }
    const auto smoke = smokeQuantityOf(labels);
    return smoke ? std::optional(Found{*smoke, std::string(nameOf(*smoke))}) : std::nullopt;
  }
};

void addSlices(const SmvIndex& index, const Wanted& wanted, std::vector<FdsSource>& sources) {
  std::map<std::tuple<Wanted::Found, bool, bool>, FdsSource> groups;
  for (std::size_t i = 0; i < index.slices.size(); ++i) {
    const FdsSliceEntry& slice = index.slices[i];
    const auto found = wanted.in(slice.labels);
    if (!found)
      continue;
    const bool volume = isVolume(slice);
    FdsSource& group = groups[{*found, volume, slice.cellCentred}];
    group.kind = FdsFileKind::kSlice;
    group.quantity = found->smoke;
    group.cellCentred = slice.cellCentred;
    group.volume = volume;
    group.name = fmt::format("slice{}-{}{}", volume ? "3d" : "", found->name,
                             slice.cellCentred ? "-cells" : "");
    group.description = fmt::format("{} slices of {}, {}", volume ? "3D" : "2D", found->name,
                                    slice.cellCentred ? "values of cells" : "values at nodes");
    group.parts.push_back({slice.mesh, i});
  }
  for (auto& [key, group] : groups) sources.push_back(std::move(group));
}

bool isFire(std::string_view quantity) {
  return quantity == kFdsHeatRelease || quantity == kFdsFlameTemperature;
}

/// Bytes of heat release, or of the flames' or the air's temperature.
void addBytes(const SmvIndex& index, std::string_view quantity, std::vector<FdsSource>& sources) {
  FdsSource bytes;
  bytes.name = "s3d-" + spelled(quantity);
  bytes.description = fmt::format("8-bit {} at nodes (.s3d)",
                                  quantity == kFdsHeatRelease        ? "heat release"
                                  : quantity == kFdsFlameTemperature ? "flame temperature"
                                                                     : "temperature");
  bytes.volume = true;
  for (std::size_t i = 0; i < index.smoke.size(); ++i) {
    if (index.smoke[i].labels.quantity == quantity)
      bytes.parts.push_back({index.smoke[i].mesh, i});
  }
  if (!bytes.parts.empty())
    sources.push_back(std::move(bytes));
}

bool isSmoke(const FdsSmokeEntry& entry) {
  return entry.labels.quantity.find("SOOT") != std::string::npos ||
         (entry.massExtinction && !isFire(entry.labels.quantity));
}

/// Each kind of smoke by itself, soot first.
void addSmoke(const SmvIndex& index, std::vector<FdsSource>& sources) {
  std::vector<std::string> kinds;
  for (const FdsSmokeEntry& smoke : index.smoke) {
    if (isSmoke(smoke) && std::ranges::find(kinds, smoke.labels.quantity) == kinds.end())
      kinds.push_back(smoke.labels.quantity);
  }
  std::ranges::stable_partition(
      kinds, [](const std::string& kind) { return kind.find("SOOT") != std::string::npos; });
  for (const std::string& kind : kinds) {
    const bool first = &kind == kinds.data();
    const bool soot = kind.find("SOOT") != std::string::npos;
    const std::string more = first ? "" : "-" + spelled(kind);
    const std::string of = soot ? "soot" : kind;
    const auto source = [&](std::string name, std::string description, FdsFileKind file) {
      FdsSource made;
      made.name = std::move(name) + more;
      made.description = std::move(description);
      made.kind = file;
      made.quantity = SmokeQuantity::kSootDensity;
      made.volume = true;
      made.smoke = kind;
      return made;
    };
    FdsSource bytes = source("s3d",
                             soot ? "8-bit smoke at nodes (.s3d)"
                                  : fmt::format("8-bit smoke ({}) at nodes (.s3d)", kind),
                             FdsFileKind::kSmoke);
    FdsSource density = source("s3dd", fmt::format("8-bit density of {} at nodes (.s3dd)", of),
                               FdsFileKind::kSmokeDensity);
    FdsSource words = source("s16", fmt::format("16-bit density of {} at nodes (.s16)", of),
                             FdsFileKind::kSmoke16);
    for (std::size_t i = 0; i < index.smoke.size(); ++i) {
      const FdsSmokeEntry& smoke = index.smoke[i];
      if (smoke.labels.quantity != kind)
        continue;
      bytes.parts.push_back({smoke.mesh, i});
      if (isThere(std::filesystem::path(smoke.file).replace_extension(".s3dd")))
        density.parts.push_back({smoke.mesh, i});
      if (isThere(std::filesystem::path(smoke.file).replace_extension(".s16")))
        words.parts.push_back({smoke.mesh, i});
    }
    for (FdsSource* one : {&words, &density, &bytes}) {
      if (!one->parts.empty())
        sources.push_back(std::move(*one));
    }
  }
}

void addPlots(const SmvIndex& index, const Wanted& wanted, std::vector<FdsSource>& sources) {
  std::vector<FdsSource> found;  // in the order of the index
  std::set<std::pair<std::string, int>> begun;
  for (std::size_t i = 0; i < index.plots.size(); ++i) {
    const FdsPlotEntry& plot = index.plots[i];
    for (const FdsLabels& labels : plot.labels) {
      const auto what = wanted.in(labels);
      if (!what || !begun.emplace(labels.quantity, plot.mesh).second)
        continue;
      auto source = std::ranges::find(found, labels.quantity, &FdsSource::plotted);
      if (source == found.end()) {
        FdsSource made;
        made.name = "plot3d-" + what->name;
        made.description = fmt::format("PLOT3D files of {}, values at nodes", what->name);
        made.kind = FdsFileKind::kPlot;
        made.quantity = what->smoke;
        made.volume = true;
        made.plotted = labels.quantity;
        source = found.insert(found.end(), std::move(made));
      }
      source->parts.push_back({plot.mesh, i});
    }
  }
  std::ranges::move(found, std::back_inserter(sources));
}

void sortByRank(std::vector<FdsSource>& sources) {
  std::stable_sort(sources.begin(), sources.end(), [](const FdsSource& a, const FdsSource& b) {
    return std::make_tuple(rankOf(a), !a.volume, -meshesOf(a), !a.cellCentred) <
           std::make_tuple(rankOf(b), !b.volume, -meshesOf(b), !b.cellCentred);
  });
}

}  // namespace

std::optional<std::size_t> plotVariable(const FdsPlotEntry& plot, std::string_view quantity) {
  const auto found = std::ranges::find(plot.labels, quantity, &FdsLabels::quantity);
  return found != plot.labels.end()
             ? std::optional(static_cast<std::size_t>(found - plot.labels.begin()))
             : std::nullopt;
}

const FdsLabels& labelsOf(const SmvIndex& index, const FdsSource& source,
                          const FdsSourcePart& part) {
  switch (source.kind) {
    case FdsFileKind::kPlot: {
      const FdsPlotEntry& plot = index.plots[part.entry];
      return plot.labels[plotVariable(plot, source.plotted).value_or(0)];
    }
    case FdsFileKind::kSlice:
      return index.slices[part.entry].labels;
    default:
      return index.smoke[part.entry].labels;
  }
}

int meshesOf(const FdsSource& source) {
  std::set<int> meshes;
  for (const FdsSourcePart& part : source.parts) meshes.insert(part.mesh);
  return static_cast<int>(meshes.size());
}

std::vector<FdsSource> findSources(const SmvIndex& index) {
  std::vector<FdsSource> sources;
  addSlices(index, {}, sources);
  addSmoke(index, sources);
  addPlots(index, {}, sources);
  sortByRank(sources);
  return sources;
}

FdsSource clearSource(const SmvIndex& index) {
  FdsSource source;
  source.name = "none";
  source.description = "the case stores no smoke";
  source.kind = FdsFileKind::kClear;
  source.cellCentred = true;
  source.volume = true;
  for (std::size_t mesh = 0; mesh < index.meshes.size(); ++mesh)
    source.parts.push_back({static_cast<int>(mesh), mesh});
  return source;
}

std::vector<FdsSource> findSources(const SmvIndex& index, std::string_view quantity) {
  std::vector<FdsSource> sources;
  addSlices(index, {quantity}, sources);
  if (isFire(quantity))
    addBytes(index, quantity, sources);
  addPlots(index, {quantity}, sources);
  sortByRank(sources);
  if (quantity == kFdsTemperature)
    addBytes(index, quantity, sources);  // steps of 8 degrees: after all others
  return sources;
}

}  // namespace volute
