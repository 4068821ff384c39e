// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "volute/base/number_type.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {

/// Numbers of any type in memory, of shape (t, z, y, x, c) in any order.
struct NumberArray {
  const std::byte* data = nullptr;          ///< of (0, 0, 0, 0, 0)
  NumberType type{};                        ///< aligned anyhow
  std::array<std::ptrdiff_t, 5> strides{};  ///< from one number to the next on each axis [bytes]
  std::shared_ptr<const void> owner{};      ///< keeps them alive; may be null
};

/// C order: c is the fastest.
std::array<std::ptrdiff_t, 5> denseStrides(const VolumeInfo& info, const NumberType& type);

/// Such numbers as frames, without a copy of them. They must not change while they are read.
class ArraySource final : public LayerwiseSource {
 public:
  /// @param info  validated
  ArraySource(VolumeInfo info, NumberArray array)
      : info_(std::move(info)), array_(std::move(array)) {}

  const VolumeInfo& info() const override { return info_; }

  /// kInvalidData for finite numbers beyond all floats.
  [[nodiscard]] Status readLayers(int index, int first, int end, std::span<float> values) override;

  double rounding() const override { return rounding_; }

  double offset() const override { return offset_; }

  bool mayRound() const override { return array_.type.isRounded(); }

  bool takesOffset() const override { return true; }

  void takeOffset(double offset) override { offset_ = offset, rounding_ = 0; }

 private:
  VolumeInfo info_;
  NumberArray array_;
  double rounding_ = 0, offset_ = 0;
};

}  // namespace volute
