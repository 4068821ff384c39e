// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_devices.hpp"

#include <algorithm>
#include <limits>

#include "volute/fds/text_lines.hpp"

namespace volute {
namespace {

/// A line of comma-separated text; quotes and spaces around its cells are dropped.
std::vector<std::string> cellsOf(std::string_view line) {
  std::vector<std::string> cells;
  std::string cell;
  bool quoted = false;
  const auto end = [&] {
    cells.emplace_back(trimmed(cell));
    cell.clear();
  };
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      end();
    } else if (c != '\r') {
      cell += c;
    }
  }
  end();
  return cells;
}

/// What devices read, near them.
class FdsDevicePoints final : public PointField {
 public:
  struct Device {
    Vec3 position;
    std::vector<double> values;  // one for each time
  };

  FdsDevicePoints(std::vector<double> times, std::vector<Device> devices, double factor,
                  std::string_view quantity)
      : times_(std::move(times)),
        devices_(std::move(devices)),
        factor_(factor),
        quantity_(quantity) {}

  std::string description() const override {
    return fmt::format("{} ({} devices, within {:g} m of each{})", quantity_, devices_.size(),
                       kNear, factor_ == 1 ? "" : "; / 4");
  }

  std::span<const double> times() const override { return times_; }

  Status at(double time, std::span<const Vec3> points, std::span<double> out) override {
    const auto after = std::ranges::upper_bound(times_, time);
    const std::size_t second =
        std::min(static_cast<std::size_t>(after - times_.begin()), times_.size() - 1);
    const std::size_t first = after == times_.begin() || second == 0 ? 0 : second - 1;
    const double length = times_[second] - times_[first];
    const double share = length > 0 ? std::clamp((time - times_[first]) / length, 0.0, 1.0) : 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Device* nearest = nullptr;
      double least = kNear;
      for (const Device& device : devices_) {
        const double distance = (device.position - points[i]).norm();
        if (distance <= least) {
          least = distance;
          nearest = &device;
        }
      }
      out[i] =
          nearest == nullptr
              ? std::numeric_limits<double>::quiet_NaN()
              : factor_ * ((1 - share) * nearest->values[first] + share * nearest->values[second]);
    }
    return {};
  }

 private:
  static constexpr double kNear = 0.3;  // [m]

  std::vector<double> times_;
  std::vector<Device> devices_;
  double factor_;
  std::string quantity_;
};

}  // namespace

Result<std::vector<FactCurve>> readCurves(const std::filesystem::path& path,
                                          const WantedCurve& wanted) {
  VOLUTE_ASSIGN(auto lines, TextLines::open(path));
  VOLUTE_ASSIGN(const auto unitLine, lines.next());
  VOLUTE_ASSIGN(const auto nameLine, lines.next());
  if (!unitLine || !nameLine)
    return fail(ErrorCode::kTruncated, "{}: has no line of names yet", path.string());
  const auto units = cellsOf(*unitLine), names = cellsOf(*nameLine);
  std::vector<FactCurve> curves;
  std::vector<std::size_t> columns;
  for (std::size_t i = 1; i < std::min(units.size(), names.size()); ++i) {
    if (wanted(names[i], units[i])) {
      curves.push_back({names[i], units[i], {}, {}});
      columns.push_back(i);
    }
  }
  constexpr std::size_t kMax = 1000000;
  for (std::size_t row = 0; row < kMax && !curves.empty(); ++row) {
    VOLUTE_ASSIGN(const auto line, lines.next());
    if (!line)
      break;
    const auto cells = cellsOf(*line);
    const auto time = numberOf(cells[0]);
    for (std::size_t c = 0; c < curves.size(); ++c) {
      const auto value =
          columns[c] < cells.size() ? numberOf(cells[columns[c]]) : std::optional<double>();
      if (!time || !value)
        continue;
      curves[c].times.push_back(*time);
      curves[c].values.push_back(*value);
    }
  }
  std::erase_if(curves, [](const FactCurve& curve) { return curve.times.empty(); });
  return curves;
}

std::filesystem::path besideCase(const SmvIndex& index, const char* end) {
  const std::string name = std::filesystem::path(index.chid).filename().string();
  return index.path.parent_path() / ((name.empty() ? index.path.stem().string() : name) + end);
}

Result<std::unique_ptr<PointField>> fdsDevicePoints(const SmvIndex& index, std::string_view fds,
                                                    double factor, std::string_view quantity) {
  std::vector<const FdsDevice*> wanted;
  for (const FdsDevice& device : index.devices) {
    if (device.quantity == fds)
      wanted.push_back(&device);
  }
  std::unique_ptr<PointField> none;
  if (wanted.empty())
    return none;
  auto curves = readCurves(besideCase(index, "_devc.csv"), [&](const auto& name, const auto&) {
    return std::ranges::any_of(wanted, [&](const FdsDevice* one) { return one->label == name; });
  });
  if (!curves) {
    if (curves.error().code == ErrorCode::kNotFound)
      return none;
    return tl::unexpected(curves.error());
  }
  std::vector<double> times;
  std::vector<FdsDevicePoints::Device> devices;
  for (FactCurve& curve : *curves) {
    // Names may be there twice; the first that has it is meant.
    const auto device = std::ranges::find(wanted, curve.name, &FdsDevice::label);
    if (times.empty())
      times = curve.times;
    if (device == wanted.end() || curve.times != times || !std::ranges::is_sorted(times))
      continue;
    devices.push_back({(*device)->position, std::move(curve.values)});
  }
  if (devices.empty())
    return none;
  return std::make_unique<FdsDevicePoints>(std::move(times), std::move(devices), factor, quantity);
}

}  // namespace volute
