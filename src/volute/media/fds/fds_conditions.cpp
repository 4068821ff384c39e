// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_conditions.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "volute/base/parallel.hpp"
#include "volute/fds/fds_case.hpp"
#include "volute/media/fds/fds_devices.hpp"

namespace volute {
namespace {

struct Stored {
  std::string_view name;  ///< in Volute
  std::string_view fds;   ///< what FDS calls it
  double factor = 1;
};

/// Quantities in the order in which they are preferred.
constexpr Stored kStored[] = {
    {"temperature", "TEMPERATURE"},
    {"radiant-flux", "RADIATIVE HEAT FLUX GAS"},
    {"radiant-flux", "INTEGRATED INTENSITY", 0.25},
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

class FdsPoints final : public PointField {
 public:
  FdsPoints(FdsCase fds, double factor, std::string_view quantity)
      : case_(std::move(fds)), factor_(factor), quantity_(quantity) {}

  std::string description() const override {
    return fmt::format("{} ({}{})", quantity_, case_.source().name, factor_ == 1 ? "" : " / 4");
  }

  std::span<const double> times() const override { return case_.times(); }

  Status at(double time, std::span<const Vec3> points, std::span<double> out) override {
    const auto times = case_.times();
    const auto after = std::ranges::upper_bound(times, time);
    const std::size_t first =
        after == times.begin() ? 0 : static_cast<std::size_t>(after - times.begin()) - 1;
    const std::size_t second = std::min(first + 1, times.size() - 1);
    const double length = times[second] - times[first];
    const double share = length > 0 ? std::clamp((time - times[first]) / length, 0.0, 1.0) : 0;
    VOLUTE_TRY(hold(first));
    if (share > 0)
      VOLUTE_TRY(hold(second));
    const FdsField& a = *held(first);
    const FdsField* b = share > 0 ? held(second) : nullptr;
    parallelRanges(points.size(), 256, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const double now = valueAt(a, points[i]);
        out[i] = b == nullptr ? now : (1 - share) * now + share * valueAt(*b, points[i]);
      }
    });
    return {};
  }

 private:
  double valueAt(const FdsField& field, const Vec3& point) const {
    return field.cellAt(point) == FdsCell::kGas ? factor_ * field.extinction(point)
                                                : std::numeric_limits<double>::quiet_NaN();
  }

  const FdsField* held(std::size_t frame) const {
    for (const auto& one : held_) {
      if (one && one->first == frame)
        return &one->second;
    }
    return nullptr;
  }

  /// Reads a frame, unless it is one of the two that were read last.
  Status hold(std::size_t frame) {
    if (held(frame) != nullptr)
      return {};
    VOLUTE_ASSIGN(auto field, case_.field(case_.times()[frame]));
    auto& place =
        !held_[0] || (held_[1] && held_[0]->first < held_[1]->first) ? held_[0] : held_[1];
    place.emplace(frame, std::move(field));
    return {};
  }

  FdsCase case_;
  double factor_;
  std::string quantity_;
  std::array<std::optional<std::pair<std::size_t, FdsField>>, 2> held_;
};

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
                               ? fmt::format("{:.4g} m", most)
                               : fmt::format("{:.3g} to {:.3g} m", least, most);
  return fmt::format("{:.0f} in {} mesh{}, edges {}", count, index.meshes.size(),
                     index.meshes.size() == 1 ? "" : "es", size);
}

}  // namespace

Result<std::unique_ptr<PointField>> fdsConditions(const SmvIndex& index, std::string_view quantity,
                                                  std::uint64_t maxMemory) {
  std::string names;
  for (const Stored& stored : kStored) {
    if (stored.name != quantity)
      continue;
    names += (names.empty() ? "" : " or ") + std::string(stored.fds);
    if (findSources(index, stored.fds).empty())
      continue;
    FdsOptions options;
    options.quantity = stored.fds;
    options.maxMemory = maxMemory;
    VOLUTE_ASSIGN(auto fds, FdsCase::open(index, options));
    return std::make_unique<FdsPoints>(std::move(fds), stored.factor, quantity);
  }
  for (const Stored& stored : kStored) {
    if (stored.name != quantity)
      continue;
    VOLUTE_ASSIGN(auto points, fdsDevicePoints(index, stored.fds, stored.factor, stored.name));
    if (points)
      return points;
  }
  // For a list of such reasons: the case is named above it.
  return fail(ErrorCode::kNotFound, "no slice, PLOT3D file or device has {}",
              names.empty() ? quantity : names);
}

CaseFacts fdsFacts(const SmvIndex& index) {
  CaseFacts facts;
  facts.title = {{"case", index.path.filename().string()}};
  if (!index.title.empty())
    facts.title.emplace_back("title", index.title);
  facts.title.emplace_back("computed by",
                           index.version.empty() ? "FDS, version not stated" : index.version);
  facts.title.emplace_back("cells", cellsText(index));
  facts.title.emplace_back("state", index.ended ? "FDS has ended"
                                                : "FDS has not ended, or was "
                                                  "stopped");
  const auto take = [&](const char* end, std::vector<FactCurve>& curves,
                        const WantedCurve& wanted) {
    auto read = readCurves(besideCase(index, end), wanted);
    if (read) {
      curves = std::move(*read);
    } else if (read.error().code != ErrorCode::kNotFound) {
      facts.remarks.push_back(read.error().message);
    }
  };
  take("_hrr.csv", facts.fire,
       [](const std::string& name, const std::string&) { return name == "HRR"; });
  if (!index.devices.empty()) {
    constexpr std::size_t kMax = 400;
    take("_devc.csv", facts.devices,
         [n = kMax](const auto&, const auto&) mutable { return n > 0 && n-- > 0; });
  }
  return facts;
}

}  // namespace volute
