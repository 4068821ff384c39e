// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "volute/base/namelist.hpp"
#include "volute/base/result.hpp"

// CHID.fds, the input of FDS that a case's index names: what the outputs do not say again.

namespace volute {

struct SmvIndex;

struct FdsInput {
  /// How soot and CO come from fuel.
  struct Reaction {
    std::string fuel;
    double sootYield = 0;  ///< [kg/kg]
    double coYield = 0;    ///< [kg/kg]
  };

  struct Device {
    std::string quantity;
    std::string species;  ///< SPEC_ID, with the formula that a SPEC line gives instead of its name
    std::string statistic;  ///< the key or statistic by which it is not the value at a point
    bool scaled = false;    ///< by CONVERSION_FACTOR or CONVERSION_ADDEND, with no UNITS stated
  };

  std::filesystem::path path;  ///< empty: there is none
  std::string chid;
  std::optional<double> begin;    ///< [s]; FDS's default is 0
  std::optional<double> ambient;  ///< TMPA [degrees C]; FDS's default is 20
  std::optional<double> visibilityFactor;
  std::optional<double> maximumVisibility;  ///< [m]
  std::optional<double> massExtinction;     ///< of soot [m2/kg]: what the last line states
  std::optional<double> otherExtinction;    ///< what an earlier one states, which differs
  std::vector<Reaction> reactions;
  std::set<std::string> burning;          ///< surfaces with a heat or mass release
  std::map<std::string, Device> devices;  ///< by ID
  /// Of evacuation meshes, by ID: how far their middle is above the floor [m].
  std::map<std::string, double> evacuationOffsets;

  /// With the files that its CATF names. kInvalidData where one of these cannot be read, or a
  /// number that is used is none.
  [[nodiscard]] static Result<FdsInput> read(const std::filesystem::path& path);
};

/// Of a case; without the file one that says nothing.
const FdsInput& inputOf(const SmvIndex& index);

}  // namespace volute
