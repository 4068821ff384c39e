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
    kPoint,      ///< two or three numbers that are drawn: x, y, z [m], angles, a knot
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
  std::string section{};      ///< of the group, with a heading of its own; empty: none
  double step = 0.02;         ///< of a kPoint, for each pixel that the mouse goes
  bool entry = false;         ///< of a list: SceneEdit::kDuplicate works on its path
  bool removable = false;     ///< likewise SceneEdit::kRemove
  std::string doubt{};        ///< why the value may be wrong
  std::vector<int> offers{};  ///< choices that would be plausible then
  /// Of the first point of a transfer function: how often values occur, from least to most.
  std::vector<double> counts{};
};

}  // namespace volute
