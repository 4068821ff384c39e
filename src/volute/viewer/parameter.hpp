// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

namespace volute {

/// Something about a document that a person may change and that its scene file keeps.
struct Parameter {
  enum class Kind {
    kNumber,
    kInteger,
    kFlag,       ///< 0 or 1
    kChoice,     ///< its place in `choices`
    kColor,      ///< linear RGB
    kPoint,      ///< x, y, z [m]
    kDirection,  ///< x, y, z, of any length
  };

  std::string group;  ///< what it is a part of: "smoke: hall.pvd"
  std::string name;   ///< "Km"
  std::string path;   ///< its place in the scene file: "/media/0/mass_extinction"
  Kind kind = Kind::kNumber;
  std::vector<double> value{};  ///< one number, or three
  double least = 0, most = 1;
  bool logarithmic = false;  ///< how a slider goes from least to most
  std::string unit{};
  std::vector<std::string> choices{};
  std::string help{};
};

}  // namespace volute
