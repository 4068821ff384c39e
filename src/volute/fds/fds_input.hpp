// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"

// CHID.fds, the input of FDS that a case's index names: what the outputs do not say again.

namespace volute {

struct SmvIndex;

/// "&GROUP KEY=value, ... /" of Fortran.
struct FdsNamelist {
  std::string group;  ///< in capitals
  int line = 0;       ///< from 1, where it begins
  /// By key in capitals, without indices: strings without quotes, repetitions written out.
  std::map<std::string, std::vector<std::string>> values;

  /// The first value of a key; empty without one.
  std::string text(const std::string& key) const;
  std::optional<double> number(const std::string& key) const;
};

/// All groups with one of these names, in order. What is between groups, after a slash, or after an
/// exclamation mark is comment; a group that the file's end or the next one cuts off has what
/// stands there.
std::vector<FdsNamelist> fdsNamelists(std::string_view text,
                                      const std::vector<std::string_view>& groups);

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

/// Names of Fortran are the same in either case: this one's in capitals.
std::string capitals(std::string_view text);

/// Of a case; without the file one that says nothing.
const FdsInput& inputOf(const SmvIndex& index);

}  // namespace volute
