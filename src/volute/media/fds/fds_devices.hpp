// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/fds/smv_index.hpp"
#include "volute/media/sight.hpp"

// What devices of an FDS case read: CHID_devc.csv, and CHID_hrr.csv, which is alike.

namespace volute {

/// Whether a column with this name and unit is wanted.
using WantedCurve = std::function<bool(const std::string& name, const std::string& unit)>;

/// Columns over time, each without the cells that hold no number.
struct FdsCurves {
  std::vector<FactCurve> curves;
  std::vector<std::string> remarks;  ///< cells, columns and lines that were left out
};

/// Of all wanted columns of a table together; they need 16 bytes each.
inline constexpr std::size_t kMaxCurveValues = std::size_t{1} << 26;

/// The wanted columns of the case's tables of that kind ("devc", "hrr"), as the index names them,
/// else CHID_kind.csv. Where FDS was started again and times go back, the later lines count. A name
/// that two columns have is nobody's; of one that two tables have there are two curves. Of a table
/// with more than `most` values the rest is left out. kNotFound where there is no such file.
[[nodiscard]] Result<FdsCurves> readCurves(const SmvIndex& index, std::string_view kind,
                                           const WantedCurve& wanted,
                                           std::size_t most = kMaxCurveValues);

/// One quantity of the air in FDS's words.
struct FdsQuantity {
  std::string_view name;  ///< of FDS, with its species: "OXYGEN VOLUME FRACTION"
  double factor = 1;      ///< of what the criteria mean
};

/// What a device measures, in capitals, with its species, as the input file says, else the index:
/// "OXYGEN VOLUME FRACTION".
[[nodiscard]] std::string measuredBy(const SmvIndex& index, const FdsDevice& device);

/// Whether columns are quantities with a unit. One that names none is taken as it should be, unless
/// its values, or for fractions those of another of the case's devices without a unit, speak
/// against it.
class DeviceUnits {
 public:
  explicit DeviceUnits(const SmvIndex& index) : index_(index) {}

  /// Why it is not: "in 'kg/kg'", "up to 20.9 mol/mol, where a fraction is at most 1: in %?"; empty
  /// where it is.
  [[nodiscard]] std::string misfit(const FactCurve& curve, std::string_view unit);

 private:
  const SmvIndex& index_;
  std::optional<std::string> unnamed_;  // what speaks against fractions without a unit, when asked
};

/// What devices say within 0.3 m of each, of several at one place the largest; null where there are
/// none with columns. A device has the quantity and species that the input file says, else those
/// of the index; its unit is that of its column, and is turned into `unit`. `quantity` is the name
/// for people.
[[nodiscard]] Result<std::unique_ptr<PointField>> fdsDevicePoints(
    const SmvIndex& index, std::span<const FdsQuantity> quantities, std::string_view unit,
    std::string_view quantity);

}  // namespace volute
