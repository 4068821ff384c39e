// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// A field at a place.
struct ProbedField {
  std::string name;
  std::vector<double> values;  ///< one, or those of a vector; as they are stored
  std::string unit{};          ///< that the files state; empty: none
};

/// What the fields of a medium's files are at places, whether they are shown or not. Keeps what it
/// reads for the next place at the same time. For one thread, that of its medium.
class FieldProbe {
 public:
  virtual ~FieldProbe() = default;

  /// At a time of the scene [s]. What is not known there is left out.
  [[nodiscard]] virtual Result<std::vector<ProbedField>> at(double time, const Vec3& place) = 0;
};

/// A medium that has one. Media are asked whether they are such, by dynamic_cast.
class ProbedMedium {
 public:
  virtual ~ProbedMedium() = default;
  virtual std::unique_ptr<FieldProbe> fieldProbe() const = 0;
};

}  // namespace volute
