// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_devices.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "volute/base/plain_number.hpp"
#include "volute/base/printable.hpp"
#include "volute/fds/fds_input.hpp"
#include "volute/fds/text_lines.hpp"
#include "volute/io/table_row.hpp"
#include "volute/io/unit.hpp"

namespace volute {
namespace {

constexpr std::size_t kLongestLine = std::size_t{1} << 26;  // of a million devices
constexpr std::size_t kNamed = 5;                           // in a remark

/// The files of a kind of table.
std::vector<std::filesystem::path> tablesOf(const SmvIndex& index, std::string_view kind) {
  std::vector<std::filesystem::path> paths;
  for (const FdsOtherFile& other : index.others) {
    std::error_code code;
    if (other.kind == fmt::format("table of {}", kind) && std::filesystem::exists(other.file, code))
      paths.push_back(other.file);
  }
  if (paths.empty()) {
    const std::string name = std::filesystem::path(index.chid).filename().string();
    paths.push_back(
        index.path.parent_path() /
        fmt::format("{}_{}.csv", name.empty() ? index.path.stem().string() : name, kind));
  }
  return paths;
}

/// Some of many names.
std::string namesOf(const std::set<std::string>& names) {
  std::vector<std::string> shown(names.begin(), names.end());
  const bool more = shown.size() > kNamed;
  shown.resize(std::min(shown.size(), kNamed));
  return fmt::format("{}{}", fmt::join(shown, ", "), more ? ", ..." : "");
}

/// Reads one table.
class CurveReader {
 public:
  /// `spans` are those of the names of earlier tables, and of this one afterwards.
  CurveReader(const std::filesystem::path& path, FdsCurves& found,
              std::map<std::string, StoredSpan>& spans)
      : path_(path.string()), found_(found), spans_(spans) {}

  /// @param most  values of all curves together
  Status read(const WantedCurve& wanted, std::size_t most) {
    VOLUTE_ASSIGN(auto lines, TextLines::open(path_, kLongestLine));
    VOLUTE_ASSIGN(const auto units, lines.next());
    VOLUTE_ASSIGN(const auto names, lines.next());
    if (!units || !names)
      return fail(ErrorCode::kTruncated, "{}: has no line of names yet", path_);
    constexpr std::string_view kMark = "\xEF\xBB\xBF";  // of a spreadsheet
    const std::string_view unitNames =
        std::string_view(*units).substr(units->starts_with(kMark) ? kMark.size() : 0);
    // FDS and spreadsheets write 1,5;2,5 where that is what people write.
    if (unitNames.find(';') != unitNames.npos && unitNames.find(',') == unitNames.npos)
      separator_ = ';';
    const std::string time(fieldsOf(*names, separator_)[0]);
    const std::string unit(fieldsOf(unitNames, separator_)[0]);
    if (capitals(time).find("TIME") == time.npos) {
      return fail(ErrorCode::kInvalidData, "{}: its first column is '{}'; expected Time", path_,
                  printable(time));
    }
    const auto change = unitChange(unit.empty() ? "s" : unit, "s");
    if (!change) {
      return fail(ErrorCode::kInvalidData, "{}: its times are in '{}'; expected s", path_,
                  printable(unit));
    }
    seconds_ = *change;
    choose(asUtf8(unitNames), asUtf8(*names), wanted);
    named_ = fieldsOf(*names, separator_).size();
    while (!curves_.empty()) {
      VOLUTE_ASSIGN(const auto line, lines.next());
      if (!line)
        break;
      if (stored_ + curves_.size() > most) {
        leftOut("has more than {} values; those from line {} on, after {} s, are left out", most,
                lines.lineNumber(), plainNumber(last_));
        break;
      }
      take(*line, lines.lineNumber());
    }
    if (lines.endedWithinLine())
      leftOut("its last line has no end and is left out: a value may be cut off");
    finish();
    return {};
  }

 private:
  void choose(const std::string& units, const std::string& names, const WantedCurve& wanted) {
    const auto unitCells = fieldsOf(units, separator_), nameCells = fieldsOf(names, separator_);
    std::map<std::string, int> times;
    for (const std::string_view name : nameCells) ++times[std::string(name)];
    std::set<std::string> twice;
    for (std::size_t i = 1; i < std::min(unitCells.size(), nameCells.size()); ++i) {
      const std::string name(nameCells[i]), unit(unitCells[i]);
      if (!wanted(name, unit))
        continue;
      if (times[name] > 1) {
        twice.insert(name);
        continue;
      }
      curves_.push_back({name, unit, {}, {}});
      columns_.push_back(i);
    }
    if (!twice.empty()) {
      leftOut(
          "several columns have one name, so that it is not known which device is which: {} are "
          "left out",
          namesOf(twice));
    }
  }

  std::optional<double> valueOf(std::string_view cell) const {
    return fortranNumber(withPoint(cell, separator_));
  }

  void take(std::string_view line, int number) {
    auto cells = fieldsOf(line, separator_);
    while (cells.size() > named_ && trimmed(cells.back()).empty()) cells.pop_back();
    if (cells.size() > named_) {
      if (longLines_++ == 0)
        firstLong_ = number;
      return;
    }
    auto time = valueOf(cells[0]);
    if (time)
      time = seconds_(*time);
    if (!time) {
      ++badTimes_;
      return;
    }
    if (*time <= last_)
      goBack(*time, number);
    last_ = *time;
    for (std::size_t c = 0; c < curves_.size(); ++c) {
      const auto value =
          columns_[c] < cells.size() ? valueOf(cells[columns_[c]]) : std::optional<double>();
      if (!value) {
        ++badCells_;
        bad_.insert(curves_[c].name);
        if (firstBad_ == 0)
          firstBad_ = number;
        continue;
      }
      curves_[c].times.push_back(*time);
      curves_[c].values.push_back(*value);
      ++stored_;
    }
  }

  /// FDS was started again: what it wrote from that time on is replaced.
  void goBack(double time, int number) {
    stored_ = 0;
    for (FactCurve& curve : curves_) {
      const auto kept = std::ranges::lower_bound(curve.times, time) - curve.times.begin();
      stored_ += static_cast<std::size_t>(kept);
      curve.times.resize(static_cast<std::size_t>(kept));
      curve.values.resize(static_cast<std::size_t>(kept));
    }
    if (restarts_++ == 0)
      firstRestart_ =
          fmt::format("line {}, from {} to {} s", number, plainNumber(last_), plainNumber(time));
  }

  /// What no place can have: programs fill gaps with -1 and -999.
  void leaveOutFills(FactCurve& curve) {
    constexpr double kRounding = 0.001;  // of a fraction
    double least = -std::numeric_limits<double>::infinity();
    if (const auto kelvin = unitChange(curve.unit, "K"))
      least = 0 - kelvin->offset / kelvin->factor;
    for (const char* fraction : {"mol/mol", "kg/kg"}) {
      if (const auto share = unitChange(curve.unit, fraction); share && !curve.unit.empty())
        least = -kRounding / share->factor;
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < curve.values.size(); ++i) {
      if (curve.values[i] < least)
        continue;
      curve.times[kept] = curve.times[i];
      curve.values[kept++] = curve.values[i];
    }
    if (kept == curve.values.size())
      return;
    impossible_.insert(fmt::format("{} ({} of {} below {:g} {})", curve.name,
                                   curve.values.size() - kept, curve.values.size(), least,
                                   printable(curve.unit)));
    curve.times.resize(kept), curve.values.resize(kept);
  }

  void finish() {
    for (FactCurve& curve : curves_) leaveOutFills(curve);
    if (!impossible_.empty())
      leftOut("values that cannot be are left out: {}", namesOf(impossible_));
    if (longLines_ > 0) {
      leftOut(
          "{} lines have more cells than there are names (line {} is the first) and are left out: "
          "decimal commas between commas?",
          longLines_, firstLong_);
    }
    if (badCells_ > 0) {
      leftOut("{} left out (line {} is the first): of {}",
              badCells_ == 1 ? "1 cell holds no number and is"
                             : fmt::format("{} cells hold no number and are", badCells_),
              firstBad_, namesOf(bad_));
    }
    if (badTimes_ > 0)
      leftOut("{} lines without a time are left out", badTimes_);
    if (restarts_ > 0) {
      leftOut("times go back ({}{}): FDS was started again, and the later lines count",
              firstRestart_, restarts_ > 1 ? ", and again" : "");
    }
    if (!curves_.empty() && last_ == -std::numeric_limits<double>::infinity())
      leftOut("has no line of values yet");
    std::erase_if(curves_, [](const FactCurve& curve) { return curve.times.empty(); });
    std::set<std::string> single;
    for (const FactCurve& curve : curves_) {
      if (curve.times.size() == 1)
        single.insert(fmt::format("{} (at {} s)", curve.name, plainNumber(curve.times.front())));
    }
    if (!single.empty())
      leftOut("one value alone, and so nothing known at any other time: of {}", namesOf(single));
    std::set<std::string> again;
    for (const FactCurve& curve : curves_) {
      const StoredSpan own{curve.times.front(), curve.times.back()};
      const auto [other, isNew] = spans_.emplace(curve.name, own);
      if (!isNew && other->second.from < own.until && own.from < other->second.until)
        again.insert(curve.name);
    }
    if (!again.empty()) {
      leftOut("an earlier table has values at the same times, of which the worse count: of {}",
              namesOf(again));
    }
    std::ranges::move(curves_, std::back_inserter(found_.curves));
  }

  template <class... Arguments>
  void leftOut(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
    found_.remarks.push_back(path_ + ": " +
                             fmt::format(text, std::forward<Arguments>(arguments)...));
  }

  std::string path_;
  char separator_ = ',';
  UnitChange seconds_;
  FdsCurves& found_;
  std::map<std::string, StoredSpan>& spans_;
  std::vector<FactCurve> curves_;
  std::vector<std::size_t> columns_;  // of each curve
  double last_ = -std::numeric_limits<double>::infinity();
  std::size_t named_ = 0;   // columns
  std::size_t stored_ = 0;  // values
  std::size_t badCells_ = 0, badTimes_ = 0, restarts_ = 0, longLines_ = 0;
  int firstBad_ = 0, firstLong_ = 0;
  std::string firstRestart_;
  std::set<std::string> bad_;         // names of columns with such cells
  std::set<std::string> impossible_;  // names of columns with values that cannot be
};

struct Device {
  Vec3 position;
  FactCurve curve;
};

/// What devices read, near them.
class FdsDevicePoints final : public PointField {
 public:
  FdsDevicePoints(std::vector<Device> devices, std::string_view quantity, std::string leftOut)
      : devices_(std::move(devices)),
        quantity_(quantity),
        leftOut_(std::move(leftOut)),
        worst_(quantity == "oxygen" ? -1 : 1) {
    for (const Device& device : devices_)
      times_.insert(times_.end(), device.curve.times.begin(), device.curve.times.end());
    std::ranges::sort(times_);
    times_.erase(std::unique(times_.begin(), times_.end()), times_.end());
    std::ranges::stable_sort(devices_, {}, [](const Device& one) { return one.position.x(); });
  }

  std::string description() const override {
    return fmt::format("{} ({} devices, within {:g} m of each{}{})", quantity_, devices_.size(),
                       kNear, leftOut_.empty() ? "" : "; left out: ", leftOut_);
  }

  std::span<const double> times() const override { return times_; }

  Status at(double time, std::span<const Vec3> points, std::span<double> out) override {
    return valuesOf(time, points, out);
  }

  Status answer(double time, std::span<const Vec3> points, std::span<PointValue> out) override {
    for (std::size_t i = 0; i < points.size(); ++i) {
      out[i] = {.span = out[i].span};
      double least = kNear;
      const auto xOf = [](const Device& one) { return one.position.x(); };
      const double x = points[i].x(), reach = kNear + kSamePlace;
      for (auto at = std::ranges::lower_bound(devices_, x - reach, {}, xOf);
           at != devices_.end() && xOf(*at) <= x + reach; ++at) {
        const Device& device = *at;
        const double distance = (device.position - points[i]).norm();
        if (distance > least + kSamePlace)
          continue;
        // A device's own times: cells without a number leave longer intervals.
        const auto place = storedPlace(device.curve.times, time);
        if (!place)
          continue;
        const double value = (1 - place->share) * device.curve.values[place->first] +
                             place->share * device.curve.values[place->second];
        // Of several at one place, such as radiometers that face several ways, the worst counts.
        if (distance > least - kSamePlace && worst_ * value <= worst_ * out[i].value)
          continue;
        constexpr double kHere = 1e-3;  // [m]
        out[i] = {value, value, value, place->span, distance <= kHere};
        least = std::min(least, distance);
      }
    }
    return {};
  }

 private:
  static constexpr double kNear = 0.3;        // [m]
  static constexpr double kSamePlace = 1e-6;  // [m]

  std::vector<Device> devices_;
  std::vector<double> times_;  // at which any of them has a value
  std::string quantity_;
  std::string leftOut_;
  double worst_;  // -1: the least value
};

/// Names of gases that users give besides FDS's own.
std::string speciesOf(std::string_view name) {
  constexpr std::pair<std::string_view, std::string_view> kFormulas[] = {
      {"CO", "CARBON MONOXIDE"},    {"CO2", "CARBON DIOXIDE"},   {"O2", "OXYGEN"},
      {"HCN", "HYDROGEN CYANIDE"},  {"NO", "NITRIC OXIDE"},      {"NO2", "NITROGEN DIOXIDE"},
      {"HCL", "HYDROGEN CHLORIDE"}, {"HBR", "HYDROGEN BROMIDE"}, {"HF", "HYDROGEN FLUORIDE"},
      {"SO2", "SULFUR DIOXIDE"},    {"C3H4O", "ACROLEIN"},       {"CH2O", "FORMALDEHYDE"}};
  std::string species = capitals(name);
  for (const auto& [formula, full] : kFormulas) {
    if (species == formula)
      return std::string(full);
  }
  return species;
}

/// What a device measures, with its species: "OXYGEN VOLUME FRACTION".
std::string quantityOf(const FdsDevice& device, const FdsInput::Device* said) {
  const std::string stated = capitals(device.quantity);
  if (said == nullptr || said->quantity.empty())
    return stated;
  const std::string quantity = capitals(said->quantity);
  return said->species.empty() ? quantity : speciesOf(said->species) + " " + quantity;
}

/// What the input file says of a device; null: nothing.
const FdsInput::Device* saidOf(const SmvIndex& index, const FdsDevice& device) {
  const auto& devices = inputOf(index).devices;
  const auto found = devices.find(device.label);
  return found == devices.end() ? nullptr : &found->second;
}

}  // namespace

std::string measuredBy(const SmvIndex& index, const FdsDevice& device) {
  return quantityOf(device, saidOf(index, device));
}

std::string DeviceUnits::misfit(const FactCurve& curve, std::string_view unit) {
  constexpr double kMaxRounded = 1.01;  // of a fraction
  constexpr double kNoRoom = 200;       // [degrees C] from the first time on
  const auto change = unitChange(curve.unit.empty() ? unit : curve.unit, unit);
  if (!change)
    return fmt::format("in '{}'", printable(curve.unit));
  if (curve.values.empty())
    return "";
  if (unit == "C" && curve.unit.empty()) {
    const double least = std::ranges::min(curve.values);
    return least < kNoRoom ? "" : fmt::format("never below {:.4g} without a unit: in K?", least);
  }
  if (unit != "mol/mol")
    return "";
  const double most = std::ranges::max(curve.values);
  if ((*change)(most) > kMaxRounded) {
    const std::string stated =
        curve.unit.empty() ? "without a unit" : fmt::format("in '{}'", printable(curve.unit));
    return fmt::format("up to {:.4g} {}, where a fraction is at most 1: in {}?", most, stated,
                       most <= 100 ? "%" : "ppm");
  }
  if (!curve.unit.empty())
    return "";
  if (!unnamed_) {
    unnamed_ = "";
    std::set<std::string> fractions;
    for (const FdsDevice& device : index_.devices) {
      if (measuredBy(index_, device).ends_with("VOLUME FRACTION"))
        fractions.insert(device.label);
    }
    const auto all = readCurves(index_, "devc", [&](const auto& name, const auto& columnUnit) {
      return columnUnit.empty() && fractions.contains(name);
    });
    for (const FactCurve& one : all ? all->curves : std::vector<FactCurve>()) {
      if (std::ranges::max(one.values) > kMaxRounded) {
        unnamed_ = fmt::format("without a unit, as '{}', which is up to {:.4g}: in % or ppm?",
                               printable(one.name), std::ranges::max(one.values));
      }
    }
  }
  return *unnamed_;
}

Result<FdsCurves> readCurves(const SmvIndex& index, std::string_view kind,
                             const WantedCurve& wanted, std::size_t most) {
  FdsCurves found;
  std::map<std::string, StoredSpan> spans;
  for (const std::filesystem::path& path : tablesOf(index, kind))
    VOLUTE_TRY(CurveReader(path, found, spans).read(wanted, most));
  return found;
}

Result<std::unique_ptr<PointField>> fdsDevicePoints(const SmvIndex& index,
                                                    std::span<const FdsQuantity> quantities,
                                                    std::string_view unit,
                                                    std::string_view quantity) {
  struct Wanted {
    const FdsDevice* device;
    double factor;
  };

  std::map<std::string, Wanted> wanted;  // by label
  std::set<std::string> twice, left;
  for (const FdsDevice& device : index.devices) {
    const FdsInput::Device* said = saidOf(index, device);
    const std::string measured = measuredBy(index, device);
    const auto found = std::ranges::find_if(
        quantities, [&](const FdsQuantity& one) { return capitals(one.name) == measured; });
    // Means over a volume, extremes over time, and numbers that only the input's factor explains
    // are not the value at a point.
    if (found == quantities.end())
      continue;
    // What a wall takes in is less than what people receive: it is hot, and reflects.
    const bool ofWall = said != nullptr && capitals(said->quantity) == "RADIATIVE HEAT FLUX";
    if (said != nullptr && (!said->statistic.empty() || said->scaled || ofWall)) {
      left.insert(fmt::format("{} ({})", device.label,
                              ofWall         ? "the net flux of a wall"
                              : said->scaled ? "CONVERSION_FACTOR without UNITS"
                                             : said->statistic));
      continue;
    }
    if (!wanted.emplace(device.label, Wanted{&device, found->factor}).second)
      twice.insert(device.label);
  }
  for (const std::string& label : twice) {
    wanted.erase(label);
    left.insert(label + " (a name of several)");
  }
  std::unique_ptr<PointField> none;
  if (wanted.empty() && left.empty())
    return none;
  auto read = readCurves(index, "devc", [&](const std::string& name, const std::string&) {
    return wanted.contains(name);
  });
  if (!read && read.error().code == ErrorCode::kNotFound)
    return none;
  VOLUTE_TRY(read);
  std::vector<Device> devices;
  std::set<std::string_view> columns;
  for (const FactCurve& curve : read->curves) columns.insert(curve.name);
  for (const auto& [label, one] : wanted) {
    if (!columns.contains(label))
      left.insert(label + " (no column of that name)");
  }
  DeviceUnits units(index);
  for (FactCurve& curve : read->curves) {
    if (const std::string why = units.misfit(curve, unit); !why.empty()) {
      left.insert(fmt::format("{} ({})", curve.name, why));
      continue;
    }
    const auto change = unitChange(curve.unit.empty() ? unit : curve.unit, unit);
    const Wanted& one = wanted.at(curve.name);
    for (double& value : curve.values) value = one.factor * (*change)(value);
    devices.push_back({one.device->position, std::move(curve)});
  }
  if (devices.empty() && left.empty())
    return none;
  if (devices.empty()) {
    return fail(ErrorCode::kNotFound,
                "no device has values of {} at a point, in {}: left out are {}", quantity, unit,
                namesOf(left));
  }
  return std::make_unique<FdsDevicePoints>(std::move(devices), quantity,
                                           left.empty() ? "" : namesOf(left));
}

}  // namespace volute
