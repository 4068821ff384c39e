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
#include <span>
#include <tuple>

#include "volute/base/read_text.hpp"

namespace volute {
namespace {

constexpr std::string_view kSoot = "SOOT";

/// What a quantity of FDS says about smoke, and whose: FDS puts the species first.
struct SmokeSaid {
  SmokeQuantity quantity;
  std::string species;
};

std::optional<SmokeSaid> smokeOf(const FdsLabels& labels) {
  const auto says = [&](std::string_view text, std::string_view unit,
                        SmokeQuantity quantity) -> std::optional<SmokeSaid> {
    const std::size_t at = labels.quantity.find(text);
    if (at == std::string::npos || labels.unit != unit)
      return std::nullopt;
    const std::string_view species = trimmed(std::string_view(labels.quantity).substr(0, at));
    return SmokeSaid{quantity, std::string(species.empty() ? kSoot : species)};
  };
  if (const auto said = says("EXTINCTION COEFFICIENT", "1/m", SmokeQuantity::kExtinction))
    return said;
  if (const auto said = says("OPTICAL DENSITY", "1/m", SmokeQuantity::kOpticalDensity))
    return said;
  if (says("SOOT DENSITY", "kg/m3", SmokeQuantity::kSootDensity))
    return SmokeSaid{SmokeQuantity::kSootDensity, std::string(kSoot)};
  return says("VISIBILITY", "m", SmokeQuantity::kVisibility);
}

/// Whose smoke bytes are: "SOOT DENSITY".
std::string speciesOf(const FdsSmokeEntry& entry) {
  std::string_view species = entry.labels.quantity;
  for (const std::string_view held : {"DENSITY", "MASS FRACTION"}) {
    if (species.ends_with(held))
      species.remove_suffix(held.size());
  }
  species = trimmed(species);
  return std::string(species.empty() ? kSoot : species);
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
  std::string_view quantity{};             // empty: smoke
  std::span<const std::string> species{};  // of smoke: all that the case has, soot first

  /// What tells the smoke of others than the first.
  std::string of(const SmokeSaid& smoke) const {
    return species.empty() || smoke.species == species.front() ? "" : "-" + spelled(smoke.species);
  }

  struct Found {
    SmokeQuantity smoke = SmokeQuantity::kExtinction;
    std::string name;
    std::string species{};

    auto operator<=>(const Found&) const = default;
  };

  std::optional<Found> in(const FdsLabels& labels) const {
    if (!quantity.empty()) {
      return labels.quantity == quantity ? std::optional(Found{{}, spelled(quantity), {}})
                                         : std::nullopt;
    }
    const auto smoke = smokeOf(labels);
    return smoke ? std::optional(Found{smoke->quantity,
                                       std::string(nameOf(smoke->quantity)) + of(*smoke),
                                       smoke->species})
                 : std::nullopt;
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
    group.species = found->species;
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

/// Whose smoke the case has, soot's first.
std::vector<std::string> smokingSpecies(const SmvIndex& index) {
  std::vector<std::string> all;
  const auto add = [&](const std::string& species) {
    if (std::ranges::find(all, species) == all.end())
      all.push_back(species);
  };
  const auto addSaid = [&](const FdsLabels& labels) {
    if (const auto smoke = smokeOf(labels))
      add(smoke->species);
  };
  for (const FdsSliceEntry& slice : index.slices) addSaid(slice.labels);
  for (const FdsSmokeEntry& smoke : index.smoke) {
    if (isSmoke(smoke))
      add(speciesOf(smoke));
  }
  for (const FdsPlotEntry& plot : index.plots) std::ranges::for_each(plot.labels, addSaid);
  std::ranges::stable_partition(
      all, [](const std::string& one) { return one.find(kSoot) != std::string::npos; });
  std::ranges::stable_partition(all, [](const std::string& one) { return one == kSoot; });
  return all;
}

/// Each kind of smoke by itself.
void addSmoke(const SmvIndex& index, const std::vector<std::string>& species,
              std::vector<FdsSource>& sources) {
  std::vector<std::string> kinds;
  for (const FdsSmokeEntry& smoke : index.smoke) {
    if (isSmoke(smoke) && std::ranges::find(kinds, smoke.labels.quantity) == kinds.end())
      kinds.push_back(smoke.labels.quantity);
  }
  bool named = false;  // s3d alone
  for (const std::string& kind : kinds) {
    const auto entry = std::ranges::find(index.smoke, kind, [](const FdsSmokeEntry& one) {
      return std::string_view(one.labels.quantity);
    });
    const bool first = !named && speciesOf(*entry) == species.front();
    named = named || first;
    const bool soot = kind.find(kSoot) != std::string::npos;
    const std::string more = first ? "" : "-" + spelled(kind);
    const std::string of = soot ? "soot" : kind;
    const auto source = [&](std::string name, std::string description, FdsFileKind file) {
      FdsSource made;
      made.name = std::move(name) + more;
      made.description = std::move(description);
      made.kind = file;
      made.quantity = SmokeQuantity::kSootDensity;
      made.volume = true;
      made.species = speciesOf(*entry);
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
        made.species = what->species;
        made.volume = true;
        made.plotted = labels.quantity;
        source = found.insert(found.end(), std::move(made));
      }
      source->parts.push_back({plot.mesh, i});
    }
  }
  std::ranges::move(found, std::back_inserter(sources));
}

void sortByRank(std::vector<FdsSource>& sources, const std::vector<std::string>& species = {}) {
  const auto key = [&](const FdsSource& one) {
    return std::make_tuple(std::ranges::find(species, one.species) - species.begin(), rankOf(one),
                           !one.volume, -meshesOf(one), !one.cellCentred);
  };
  std::ranges::stable_sort(sources, {}, key);
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

std::set<int> meshesInPart(const SmvIndex& index, const FdsSource& source) {
  std::set<int> partly;
  if (source.kind != FdsFileKind::kSlice || !source.volume)
    return partly;
  std::map<int, std::uint64_t> cells;
  for (const FdsSourcePart& part : source.parts) {
    const auto& nodes = index.slices[part.entry].nodes;  // isVolume(): it has some
    std::uint64_t count = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const int first =
          source.cellCentred ? std::max(nodes->begin[axis], 1) - 1 : nodes->begin[axis];
      count *= static_cast<std::uint64_t>(std::max(nodes->end[axis] - first, 0));
    }
    cells[part.mesh] += count;
  }
  for (const auto& [mesh, count] : cells) {
    if (count < index.meshes[static_cast<std::size_t>(mesh)].cellCount())
      partly.insert(mesh);
  }
  return partly;
}

std::vector<FdsSource> findSources(const SmvIndex& index) {
  std::vector<FdsSource> sources;
  const std::vector<std::string> species = smokingSpecies(index);
  const Wanted smoke{.species = species};
  addSlices(index, smoke, sources);
  addSmoke(index, species, sources);
  addPlots(index, smoke, sources);
  sortByRank(sources, species);
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
  addSlices(index, {.quantity = quantity}, sources);
  if (isFire(quantity))
    addBytes(index, quantity, sources);
  addPlots(index, {.quantity = quantity}, sources);
  sortByRank(sources);
  if (quantity == kFdsTemperature)
    addBytes(index, quantity, sources);  // steps of 8 degrees: after all others
  return sources;
}

}  // namespace volute
