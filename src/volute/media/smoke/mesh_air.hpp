// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/io/mesh_source.hpp"
#include "volute/media/sight.hpp"

namespace volute {

/// Which field of a mesh holds a quantity of the air.
struct MeshAirField {
  std::string quantity;  ///< "temperature", "carbon-monoxide", as SightField::conditions() names it
  std::string field;
  std::string unit;  ///< "K", "C", "mol/mol", "%", "ppm", "kg/kg", "kW/m2", "W/m2"; empty: not said
};

/// How much of a gas there was in all that was read.
struct MeshGasRead {
  MeshAirField named;
  double most = 0;  ///< in its unit

  /// Where all that is read is so little that its unit is in doubt.
  std::optional<Remark> doubt() const;
};

using MeshFieldNames = std::vector<std::vector<std::string>>;

/// "temperature=T:K,oxygen=O2:%": a unit may be left out where the field's is clear. The error says
/// what was expected.
[[nodiscard]] Result<std::vector<MeshAirField>> parseMeshAir(std::string_view text);

/// A quantity of the air at the points of a case, linear in tetrahedra and between stored times:
/// the field that `named` says, else one with a usual name (T, O2, CO2, CO and so on). A
/// temperature without a unit is in K where all of its values are at least 150, else in degrees C;
/// gases are in mol/mol, those of OpenFOAM in kg/kg, which counts as in air of 28.96 g/mol.
/// Dimensions that OpenFOAM states are the quantity's (or none), a temperature in K is not below
/// 150, a flux in them is in W/m2. Of a unit that is said, a temperature or oxygen that no air has
/// is an error. kNotFound where there is none.
/// @param gases  gets gases in a unit that is said
/// @param fields  the case's, at its first time
/// @param later  gives the names of its fields at each time, as far as they are told without
///               reading; asked where the first time lacks the field
[[nodiscard]] Result<std::unique_ptr<PointField>> meshConditions(
    const MeshSource& mesh, std::string_view quantity, std::span<const MeshAirField> named,
    std::span<const MeshFieldSummary> fields, const std::function<const MeshFieldNames&()>& later,
    std::vector<std::shared_ptr<MeshGasRead>>& gases);

/// A scalar field as it is stored, at the points of a case.
[[nodiscard]] Result<std::unique_ptr<PointField>> meshField(const MeshSource& mesh,
                                                            const std::string& field);

}  // namespace volute
