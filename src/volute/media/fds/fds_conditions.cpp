// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_conditions.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "volute/base/parallel.hpp"
#include "volute/base/plain_number.hpp"
#include "volute/base/printable.hpp"
#include "volute/fds/fds_case.hpp"
#include "volute/fds/fds_input.hpp"
#include "volute/io/unit.hpp"
#include "volute/media/fds/fds_devices.hpp"
#include "volute/media/fds/touching_cells.hpp"
#include "volute/report/sha256.hpp"

namespace volute {
namespace {

struct Stored {
  std::string_view name;  ///< in Volute
  std::string_view fds;   ///< what FDS calls it
  double factor = 1;
  bool devicesAlone = false;  ///< no slice has it under this name
};

/// Quantities in the order in which they are preferred.
constexpr Stored kStored[] = {
    {"temperature", "TEMPERATURE"},
    {"radiant-flux", "RADIATIVE HEAT FLUX GAS"},
    {"radiant-flux", "INTEGRATED INTENSITY", 0.25},
    // As the index calls devices of RADIATIVE HEAT FLUX GAS, and targets in the gas.
    {"radiant-flux", "RADIATIVE HEAT FLUX", 1, true},
    {"radiant-flux", "RADIANT HEAT FLUX GAS", 1, true},
    {"temperature", "GAS TEMPERATURE", 1, true},
    {"carbon-monoxide", "CARBON MONOXIDE VOLUME FRACTION"},
    {"carbon-dioxide", "CARBON DIOXIDE VOLUME FRACTION"},
    {"oxygen", "OXYGEN VOLUME FRACTION"},
    {"hydrogen-cyanide", "HYDROGEN CYANIDE VOLUME FRACTION"},
    {"nitric-oxide", "NITRIC OXIDE VOLUME FRACTION"},
    {"nitrogen-dioxide", "NITROGEN DIOXIDE VOLUME FRACTION"},
    {"hydrogen-chloride", "HYDROGEN CHLORIDE VOLUME FRACTION"},
    {"hydrogen-bromide", "HYDROGEN BROMIDE VOLUME FRACTION"},
    {"hydrogen-fluoride", "HYDROGEN FLUORIDE VOLUME FRACTION"},
    {"sulfur-dioxide", "SULFUR DIOXIDE VOLUME FRACTION"},
    {"acrolein", "ACROLEIN VOLUME FRACTION"},
    {"formaldehyde", "FORMALDEHYDE VOLUME FRACTION"},
    // As FDS 5 called them.
    {"carbon-monoxide", "carbon monoxide"},
    {"carbon-dioxide", "carbon dioxide"},
    {"oxygen", "oxygen"},
};

constexpr std::string_view kFraction = "mol/mol";

/// In which criteria have a quantity.
std::string_view unitOf(std::string_view quantity) {
  return quantity == "temperature" ? "C" : quantity == "radiant-flux" ? "kW/m2" : kFraction;
}

/// What an undisturbed air has of a quantity.
double cleanOf(const SmvIndex& index, std::string_view quantity) {
  const double ambient = inputOf(index).ambient.value_or(20);
  if (quantity == "radiant-flux")
    return 5.67e-11 * std::pow(ambient + 273.15, 4);  // of a black body [kW/m2]
  return quantity == "temperature" ? ambient : quantity == "oxygen" ? 0.2095 : 0;
}

/// Values at nodes are means of the cells around them, of which one alone may have it all: eight
/// times as much as the mean, which leaves every verdict open. It is assumed that a cell is between
/// the least and the largest of the nodes at its corners, and, in layers, of which only the nodes
/// on one side of a cell are known, that it is not farther from clean air than 1.5 times the
/// farthest of these, nor nearer to it than half of the nearest: from one cell to the next this
/// changes by less than three times. In a fire on grids of 0.25 and 0.5 m, no more than 0.03 % of
/// the cells above 30, 60 and 100 degrees were there unnoticed, 0.3 to 1.2 % by the nodes' own
/// values, and none in layers.
class FdsPoints final : public PointField {
 public:
  /// `change` is from what is stored to what criteria mean, `factor` of the quantity after it.
  FdsPoints(FdsCase fds, UnitChange change, double factor, std::string_view quantity,
            bool fraction = false)
      : case_(std::move(fds)),
        change_(change),
        factor_(factor),
        quantity_(quantity),
        fraction_(fraction),
        clean_(cleanOf(case_.index(), quantity)) {}

  std::string description() const override {
    return fmt::format("{} ({}{})", quantity_, case_.source().name, factor_ == 1 ? "" : " / 4");
  }

  std::span<const double> times() const override { return case_.times(); }

  Status at(double time, std::span<const Vec3> points, std::span<double> out) override {
    return valuesOf(time, points, out);
  }

  bool isExact() const override {
    return std::ranges::none_of(case_.grid().lattices(), [](const auto& one) { return one.nodal; });
  }

  Status answer(double time, std::span<const Vec3> points, std::span<PointValue> out) override {
    const auto place = storedPlace(times(), time);
    for (PointValue& one : out) one = {.span = place ? place->span : one.span};
    if (!place)
      return {};
    const auto [first, second, share, span] = *place;
    VOLUTE_TRY(hold(first, second));
    if (share > 0)
      VOLUTE_TRY(hold(second, first));
    const FdsField& a = *held(first);
    const FdsField* b = share > 0 ? held(second) : nullptr;
    parallelRanges(points.size(), 256, [&, share = share](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        PointValue& now = out[i];
        read(a, points[i], now);
        if (b == nullptr)
          continue;
        PointValue then;
        read(*b, points[i], then);
        for (const auto part : {&PointValue::value, &PointValue::low, &PointValue::high})
          now.*part = (1 - share) * now.*part + share * then.*part;
      }
    });
    if (!fraction_)
      return {};
    constexpr double kMaxRounded = 1.01;
    const auto many = std::ranges::find_if(
        out, [](double value) { return value > kMaxRounded; }, &PointValue::value);
    if (many == out.end())
      return {};
    return fail(ErrorCode::kInvalidData,
                "{}: {} is {:.4g} mol/mol at {} s; expected a fraction of at most 1: the file is "
                "damaged, or in another unit than it says",
                case_.index().path.string(), case_.source().name, many->value, plainNumber(time));
  }

 private:
  void read(const FdsField& field, const Vec3& point, PointValue& out) const {
    const auto place = field.placeOf(point);
    if (!place || field.cellIn(*place) != FdsCell::kGas)
      return;
    out.value = factor_ * change_(field.extinction(*place, point));
    out.low = out.high = out.value;
    const auto number = static_cast<std::size_t>(place->lattice);
    const FdsLattice& lattice = field.grid().lattices()[number];
    if (!lattice.nodal || std::isnan(out.value))
      return;
    const SmokeBand nodes =
        nodesAround(lattice, field.values(number), field.cells(number), *place, point);
    const double low = factor_ * change_(nodes.low), high = factor_ * change_(nodes.high);
    const bool layer = lattice.thinAxis >= 0;
    const auto from = [&](double value, double outwards) {
      return clean_ + (layer ? outwards : 1) * (value - clean_);
    };
    const double least = quantity_ == "temperature" ? -273.15 : 0;
    const double most = fraction_ ? 1 : std::numeric_limits<double>::infinity();
    out.low = std::min(out.low, std::max(from(low, low > clean_ ? 0.5 : 1.5), least));
    out.high = std::max(out.high, std::min(from(high, high > clean_ ? 1.5 : 0.5), most));
  }

  /// The least and the largest at the corners of the gas cells that touch a point; of bytes, that
  /// they may stand for. The last byte may be anything. Where walls take most of the eight cells
  /// round a node, the rounding is that many times as large: such a node counts with the middle of
  /// what its byte stands for, if others of the cells are surer.
  static SmokeBand nodesAround(const FdsLattice& lattice, const FdsValues& values,
                               const std::vector<FdsCell>& cells, const FdsField::Place& place,
                               const Vec3& point) {
    const std::size_t nx = lattice.planes[0].size(), ny = lattice.planes[1].size();
    constexpr float kNever = std::numeric_limits<float>::infinity(), kLargest = 1e4F;
    constexpr float kMuchSurer = 2.1F;  // a node on a wall's face is not, one at its edge is
    const std::vector<float>& low = values.low.empty() ? values.value : values.low;
    const std::vector<float>& high = values.high.empty() ? values.value : values.high;
    const auto forNodes = [&](auto&& each) {
      forTouchingCells(lattice, point, place.cell, [&](const std::array<int, 3>& cell) {
        if (cells[lattice.cellAt(cell)] != FdsCell::kGas)
          return;
        for (int corner = 0; corner < 8; ++corner) {
          const auto at = [&](int axis) {
            return static_cast<std::size_t>(cell[axis] + (corner >> axis & 1));
          };
          each((at(2) * ny + at(1)) * nx + at(0));
        }
      });
    };
    // Of what is no number the other one, as std::fmin() has it, which is a call.
    const auto least = [](float a, float b) { return b < a ? b : a; };
    float surest = kNever;
    if (!values.high.empty()) {
      forNodes([&](std::size_t node) {
        surest = least(surest, least(kLargest, high[node]) - values.value[node]);
      });
    }
    SmokeBand band{0, kNever, -kNever};
    forNodes([&](std::size_t node) {
      const float value = values.value[node], most = least(kLargest, high[node]);
      const float highest = most - value <= kMuchSurer * surest ? most : value;
      band.low = least(band.low, low[node]);
      band.high = highest > band.high ? highest : band.high;
    });
    return band;
  }

  const FdsField* held(std::size_t frame) const {
    for (const auto& one : held_) {
      if (one && one->first == frame)
        return &one->second;
    }
    return nullptr;
  }

  /// Reads a frame, unless it is one of the two that are held, in the place of another than `keep`.
  Status hold(std::size_t frame, std::size_t keep) {
    if (held(frame) != nullptr)
      return {};
    VOLUTE_ASSIGN(auto field, case_.field(case_.times()[frame]));
    auto& place = held_[0] && held_[0]->first == keep ? held_[1] : held_[0];
    place.emplace(frame, std::move(field));
    return {};
  }

  FdsCase case_;
  UnitChange change_;
  double factor_;
  std::string quantity_;
  bool fraction_;
  double clean_;
  std::array<std::optional<std::pair<std::size_t, FdsField>>, 2> held_;
};

/// From the unit of a source's files, which is to be one, to another.
Result<UnitChange> unitChangeOf(const SmvIndex& index, const FdsSource& source,
                                std::string_view to) {
  std::set<std::string> units;
  for (const FdsSourcePart& part : source.parts) {
    units.insert(labelsOf(index, source, part).unit);
  }
  const auto change = unitChange(*units.begin(), to);
  if (units.size() == 1 && !units.begin()->empty() && change)
    return *change;
  std::string stated;
  for (const std::string& unit : units)
    stated += fmt::format("{}'{}'", stated.empty() ? "" : " and ", printable(unit));
  return fail(ErrorCode::kInvalidData, "{} is in {}; expected {}, or another unit of it",
              source.name, stated, to);
}

std::string cellsText(const SmvIndex& index) {
  double least = std::numeric_limits<double>::infinity(), most = 0, count = 0;
  for (const FdsMesh& mesh : index.meshes) {
    count += static_cast<double>(mesh.cellCount());
    for (const auto& planes : mesh.planes) {
      for (std::size_t i = 1; i < planes.size(); ++i) {
        least = std::min(least, planes[i] - planes[i - 1]);
        most = std::max(most, planes[i] - planes[i - 1]);
      }
    }
  }
  const std::string size = most - least < 1e-4 * most
                               ? fmt::format("{} m", plainNumber(most, 4))
                               : fmt::format("{:.3g} to {:.3g} m", least, most);
  return fmt::format("{:.0f} in {} mesh{}, edges {}", count, index.meshes.size(),
                     index.meshes.size() == 1 ? "" : "es", size);
}

}  // namespace

Result<std::unique_ptr<PointField>> fdsConditions(const SmvIndex& index, std::string_view quantity,
                                                  std::uint64_t maxMemory) {
  std::string names, unread;  // what cannot be read
  std::vector<std::unique_ptr<PointField>> sources;
  std::vector<std::string> notes;  // of what does not serve
  std::vector<FdsQuantity> spellings;
  const auto failed = [&](const Error& error) {
    unread += (unread.empty() ? "" : "; ") + error.message;
    notes.push_back(error.message);
  };
  for (const Stored& stored : kStored) {
    if (stored.name != quantity)
      continue;
    spellings.push_back({stored.fds, stored.factor});
    if (stored.devicesAlone)
      continue;
    names += (names.empty() ? "" : " or ") + std::string(stored.fds);
    for (const FdsSource& source : findSources(index, stored.fds)) {
      const auto change = unitChangeOf(index, source, unitOf(quantity));
      if (!change) {
        notes.push_back(change.error().message);
        continue;
      }
      FdsOptions options;
      options.quantity = stored.fds;
      options.source = source.name;
      options.partly = true;
      options.maxMemory = maxMemory;
      auto fds = FdsCase::open(index, options);
      if (!fds) {
        failed(fds.error());
        continue;
      }
      for (const Remark& remark : fds->leftOut()) notes.push_back(remark.sentence);
      sources.push_back(std::make_unique<FdsPoints>(std::move(*fds), *change, stored.factor,
                                                    quantity, unitOf(quantity) == kFraction));
    }
  }
  auto devices = fdsDevicePoints(index, spellings, unitOf(quantity), quantity);
  if (!devices)
    failed(devices.error());
  else if (*devices)
    sources.push_back(std::move(*devices));
  if (sources.empty() && !unread.empty())
    return fail(ErrorCode::kInvalidData, "{}", unread);
  if (sources.empty() && !notes.empty())
    return fail(ErrorCode::kNotFound, "{}", notes.front());
  // For a list of such reasons: the case is named above it.
  if (sources.empty()) {
    return fail(ErrorCode::kNotFound, "no slice, PLOT3D file or device has {}",
                names.empty() ? quantity : names);
  }
  return std::make_unique<BestPoints>(std::move(sources), std::move(notes));
}

std::vector<std::string> fdsQuantities(const SmvIndex& index) {
  std::set<std::string> names;
  for (const FdsSliceEntry& slice : index.slices) names.insert(slice.labels.quantity);
  for (const FdsPlotEntry& plot : index.plots) {
    for (const FdsLabels& labels : plot.labels) names.insert(labels.quantity);
  }
  for (const FdsSmokeEntry& smoke : index.smoke) names.insert(smoke.labels.quantity);
  return {names.begin(), names.end()};
}

Result<std::pair<std::unique_ptr<PointField>, std::string>> fdsStored(const SmvIndex& index,
                                                                      const std::string& quantity,
                                                                      std::uint64_t maxMemory) {
  std::vector<std::unique_ptr<PointField>> sources;
  std::optional<std::string> unit;
  std::optional<Error> error;
  for (const FdsSource& source : findSources(index, quantity)) {
    const std::string& own = labelsOf(index, source, source.parts.front()).unit;
    const auto change = unit && *unit != own ? unitChange(own, *unit) : UnitChange{};
    auto fds =
        FdsCase::open(index, {.quantity = quantity, .source = source.name, .maxMemory = maxMemory});
    if (!fds || !change) {
      error = fds ? error : fds.error();
      continue;
    }
    unit = unit.value_or(own);
    sources.push_back(std::make_unique<FdsPoints>(std::move(*fds), *change, 1, quantity));
  }
  if (!sources.empty())
    return std::pair<std::unique_ptr<PointField>, std::string>(
        std::make_unique<BestPoints>(std::move(sources)), *unit);
  if (error)
    return tl::unexpected(std::move(*error));
  return fail(ErrorCode::kNotFound, "nothing stores {}", quantity);
}

namespace {

/// Vents and obstructions with a surface that burns, by the case's input file.
std::vector<FirePlace> burners(const SmvIndex& index) {
  std::vector<FirePlace> burners;
  const std::set<std::string>& burning = inputOf(index).burning;
  const auto nameOf = [&](int surface) {
    const auto place = static_cast<std::size_t>(surface);
    return surface >= 0 && place < index.surfaces.size() ? index.surfaces[place].name
                                                         : std::string();
  };
  const auto add = [&](const FdsMesh& mesh, const FdsNodeBox& nodes, const std::string& name) {
    burners.push_back({boxOf(mesh, nodes), fmt::format("burner '{}' ({})", name,
                                                       inputOf(index).path.filename().string())});
  };
  for (const FdsMesh& mesh : index.meshes) {
    for (const FdsVent& vent : mesh.vents) {
      if (burning.contains(nameOf(vent.surface)))
        add(mesh, vent.nodes, nameOf(vent.surface));
    }
    for (const FdsObstruction& one : mesh.obstructions) {
      const auto face = std::ranges::find_if(
          one.surfaces, [&](int surface) { return burning.contains(nameOf(surface)); });
      if (face != one.surfaces.end())
        add(mesh, one.nodes, nameOf(*face));
    }
  }
  return burners;
}

}  // namespace

Result<std::vector<FirePlace>> fdsFires(const SmvIndex& index, std::uint64_t maxMemory) {
  constexpr double kFlame = 200;   // [kW/m3]: what Smokeview draws as flames
  constexpr double kSpreads = 30;  // [s] after the first flames; people are where it burns later
  constexpr std::size_t kTimes = 50;
  std::vector<FirePlace> fires = burners(index);
  if (findSources(index, kFdsHeatRelease).empty())
    return fires;
  FdsOptions options;
  options.quantity = kFdsHeatRelease;
  options.volume = true;
  options.maxMemory = maxMemory;
  auto fds = FdsCase::open(index, options);
  if (!fds) {
    if (fds.error().code == ErrorCode::kNotFound)
      return fires;  // in layers alone
    return tl::unexpected(std::move(fds.error()));
  }
  const std::span<const FdsLattice> lattices = fds->grid().lattices();

  constexpr auto isFlame = [](double value) { return value >= kFlame; };
  // The value in the middle of a cell.
  const auto middleOf = [](const FdsLattice& lattice, const std::vector<float>& values,
                           const std::array<int, 3>& cell) -> double {
    if (!lattice.nodal)
      return values[lattice.cellAt(cell)];
    const std::size_t rows = lattice.planes[0].size(), layers = rows * lattice.planes[1].size();
    const float* corner = &values[cell[2] * layers + cell[1] * rows + cell[0]];
    double sum = 0;
    for (const std::size_t row : {std::size_t{0}, rows, layers, layers + rows})
      sum += static_cast<double>(corner[row]) + corner[row + 1];
    return sum / 8;
  };

  struct Column {
    double low = std::numeric_limits<double>::infinity(), high = -low;  // where it burns at a time
    double since = std::numeric_limits<double>::infinity();
  };

  std::vector<std::vector<Column>> columns;
  for (const FdsLattice& lattice : lattices)
    columns.emplace_back(static_cast<std::size_t>(lattice.cells(0)) * lattice.cells(1));
  const std::size_t times = fds->times().size(), taken = std::min(times, kTimes);
  for (std::size_t n = 0; n < taken; ++n) {
    const double time = fds->times()[taken > 1 ? n * (times - 1) / (taken - 1) : 0];
    VOLUTE_ASSIGN(const FdsField field, fds->field(time));
    parallelFor(lattices.size(), [&](std::size_t l) {
      if (!fds->grid().holds(l) || !std::ranges::any_of(field.values(l).value, isFlame))
        return;
      const FdsLattice& lattice = lattices[l];
      const FdsPlanes& planes = lattice.planes;
      std::array<int, 3> cell;
      auto& [i, j, k] = cell;
      for (k = 0; k < lattice.cells(2); ++k) {
        for (j = 0; j < lattice.cells(1); ++j) {
          for (i = 0; i < lattice.cells(0); ++i) {
            if (field.cells(l)[lattice.cellAt(cell)] != FdsCell::kGas ||
                !isFlame(middleOf(lattice, field.values(l).value, cell)))
              continue;
            auto& [low, high, since] =
                columns[l][static_cast<std::size_t>(j) * lattice.cells(0) + i];
            low = std::min(low, planes[2][k]);
            high = std::max(high, planes[2][k + 1]);
            since = std::min(since, time);
          }
        }
      }
    });
  }
  double first = std::numeric_limits<double>::infinity();
  for (const auto& ofALattice : columns) {
    for (const Column& column : ofALattice) first = std::min(first, column.since);
  }
  for (std::size_t l = 0; l < lattices.size(); ++l) {
    const FdsPlanes& planes = lattices[l].planes;
    for (std::size_t j = 0; j + 1 < planes[1].size(); ++j) {
      for (std::size_t i = 0; i + 1 < planes[0].size(); ++i) {
        const auto [low, high, since] = columns[l][j * (planes[0].size() - 1) + i];
        if (low < high && since <= first + kSpreads) {
          fires.push_back({{Vec3(planes[0][i], planes[1][j], low),
                            Vec3(planes[0][i + 1], planes[1][j + 1], high)},
                           fmt::format("flames of {:g} kW/m3 in the first {:g} s ({})", kFlame,
                                       kSpreads, fds->source().name)});
        }
      }
    }
  }
  return fires;
}

CaseFacts fdsFacts(const SmvIndex& index) {
  CaseFacts facts;
  facts.title = {{"case", index.path.filename().string()}};
  if (!index.title.empty())
    facts.title.emplace_back("title", index.title);
  facts.title.emplace_back("computed by",
                           index.version.empty() ? "FDS, version not stated" : index.version);
  facts.title.emplace_back("cells", cellsText(index));
  for (const FdsInput::Reaction& reaction : inputOf(index).reactions) {
    facts.title.emplace_back(
        "reaction", fmt::format("{}: soot yield {:g}, CO yield {:g} kg/kg ({})",
                                reaction.fuel.empty() ? "fuel" : reaction.fuel, reaction.sootYield,
                                reaction.coYield, inputOf(index).path.filename().string()));
  }
  if (const auto& input = inputOf(index); !input.path.empty()) {
    if (const auto sum = sha256Of(input.path))
      facts.title.emplace_back(
          "input file", fmt::format("{} (SHA-256 {})", input.path.filename().string(), *sum));
  }
  facts.title.emplace_back("state", index.ended ? "FDS has ended"
                                                : "FDS has not ended, or was "
                                                  "stopped");
  const auto take = [&](const char* kind, std::vector<FactCurve>& curves,
                        const WantedCurve& wanted) {
    auto read = readCurves(index, kind, wanted);
    if (read) {
      curves = std::move(read->curves);
      facts.remarks.insert(facts.remarks.end(), read->remarks.begin(), read->remarks.end());
    } else if (read.error().code != ErrorCode::kNotFound) {
      facts.remarks.push_back(read.error().message);
    }
  };
  take("hrr", facts.fire,
       [](const std::string& name, const std::string&) { return name == "HRR"; });
  if (!index.devices.empty()) {
    constexpr std::size_t kMax = 400;
    take("devc", facts.devices,
         [n = kMax](const auto&, const auto&) mutable { return n > 0 && n-- > 0; });
    std::map<std::string_view, const FactCurve*> columns;
    for (const FactCurve& curve : facts.devices) columns.emplace(curve.name, &curve);
    std::vector<std::string> missing;
    for (const FdsDevice& device : index.devices) {
      if (!columns.contains(device.label))
        missing.push_back(device.label);
    }
    if (!missing.empty() && !facts.devices.empty() && facts.devices.size() < kMax) {
      facts.remarks.push_back(fmt::format(
          "{} of {} devices have no column in the table of devices: '{}'{}", missing.size(),
          index.devices.size(), missing.front(), missing.size() > 1 ? " and others" : ""));
    }
    std::vector<std::string> unread, unnamed, ofNothing;
    DeviceUnits units(index);
    for (const FdsDevice& device : index.devices) {
      const auto curve = columns.find(device.label);
      const std::string measured = measuredBy(index, device);
      if (measured == "VOLUME FRACTION")
        ofNothing.push_back(device.label);
      const auto* stored = std::ranges::find_if(kStored, [&](const Stored& one) {
        return std::ranges::equal(one.fds, measured, {},
                                  [](unsigned char c) { return std::toupper(c); });
      });
      if (curve == columns.end() || stored == std::end(kStored))
        continue;
      if (const std::string why = units.misfit(*curve->second, unitOf(stored->name)); !why.empty())
        unread.push_back(fmt::format("'{}' ({} {})", device.label, measured, why));
      else if (curve->second->unit.empty())
        unnamed.push_back(fmt::format("'{}' in {}", device.label, unitOf(stored->name)));
    }
    if (!ofNothing.empty()) {
      facts.remarks.push_back(fmt::format(
          "{} of {} devices measure VOLUME FRACTION of a species that {}: they serve no criterion: "
          "'{}'{}",
          ofNothing.size(), index.devices.size(),
          inputOf(index).path.empty() ? "the input file would say, which is not there"
                                      : inputOf(index).path.filename().string() + " does not name",
          printable(ofNothing.front()), ofNothing.size() > 1 ? " and others" : ""));
    }
    if (!unnamed.empty()) {
      facts.remarks.push_back(
          fmt::format("{} of {} devices have columns without a unit, which are taken in the unit "
                      "that FDS writes: {}{}",
                      unnamed.size(), index.devices.size(), printable(unnamed.front()),
                      unnamed.size() > 1 ? " and others" : ""));
    }
    if (!unread.empty()) {
      facts.remarks.push_back(
          fmt::format("{} of {} devices are left out, because their column is in no unit of what "
                      "they measure: {}{}",
                      unread.size(), index.devices.size(), printable(unread.front()),
                      unread.size() > 1 ? " and others" : ""));
    }
  }
  return facts;
}

}  // namespace volute
