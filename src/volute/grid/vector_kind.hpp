// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string_view>

#include "volute/math/vec.hpp"

namespace volute {

struct GridMetadata;

/// The kind of a grid's vectors: how they change when the grid is moved, turned or scaled, and in
/// which space they are. The words are OpenVDB's ("vector_type", "is_local_space").
struct VectorKind {
  enum class Type : char {
    kUnstated,               ///< taken as kContravariantRelative, as programs leave it out
    kInvariant,              ///< colours: they do not change
    kCovariant,              ///< gradients: by the inverse transpose
    kCovariantNormalize,     ///< normals: the same, of length 1
    kContravariantRelative,  ///< velocities: by the matrix without its offset
    kContravariantAbsolute,  ///< positions
  };

  Type type = Type::kUnstated;
  bool local = false;  ///< along the grid's own axes, in voxels; else they are of the world

  bool operator==(const VectorKind&) const = default;
};

/// Frames of three channels whose source states the kind of their vectors.
class VectorFrames {
 public:
  virtual ~VectorFrames() = default;

  virtual VectorKind vectors() const = 0;
};

VectorKind vectorKindOf(std::span<const GridMetadata> metadata);

/// "covariant normalize"; empty: kUnstated.
std::string_view vectorTypeName(VectorKind::Type type);

/// What such vectors are multiplied by when space is; of kCovariantNormalize before they get their
/// length back.
Mat3 vectorTurn(VectorKind::Type type, const Mat3& linear);

}  // namespace volute
