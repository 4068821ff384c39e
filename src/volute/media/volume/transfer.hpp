// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "volute/grid/brick_slice.hpp"
#include "volute/image/colormap.hpp"
#include "volute/media/field_sliders.hpp"

namespace volute {

/// A transfer function: a value is seen as its colour of a perceptual map, and is as dense as the
/// points say. What is opaque looks as the map does.
struct Transfer {
  ColorMap map = ColorMap::kViridis;
  double least = 0, most = 1;  ///< the values with the first and the last colour
  /// Value and extinction [1/m], by ascending values; linear in between, constant beyond.
  std::vector<std::array<double, 2>> points{{0, 0}, {1, 1}};

  bool operator==(const Transfer&) const = default;

  double extinctionOf(double value) const;
  Rgb colorOf(double value) const;  ///< linear
};

const FieldTable& transferFields();

/// How often values occur in a frame, where something is stored.
struct ValueCounts {
  double least = 0, most = 0;
  std::vector<double> counts;  ///< from least to most, in equal steps

  static ValueCounts of(const BrickSlice& slice);
};

/// The value that a transfer function is of: that of a scalar, or a vector's length.
float scalarAt(const float* values, int channels, int stride);

/// Whether it is used, and its controls. Null: it is not.
void addTransfer(ParameterGroup& group, const Transfer* transfer, const ValueCounts& values);

/// Sets "transfer/map", "transfer/range/0" or "transfer/points/1" of a volume. False: it is none of
/// them.
/// @param size  of what is seen [m], for one that is new
bool setTransfer(nlohmann::ordered_json& volume, const std::string& key, const std::string& choice,
                 const std::vector<double>& value, const ValueCounts& values, double size);

/// One more point, or one less; nothing where the key names none.
[[nodiscard]] Result<std::optional<std::string>> editTransfer(nlohmann::ordered_json& volume,
                                                              const std::string& key, bool more);

}  // namespace volute
