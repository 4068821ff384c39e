// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/vector_kind.hpp"

#include <algorithm>
#include <array>

#include "volute/grid/grid_description.hpp"

namespace volute {
namespace {

constexpr std::array<std::string_view, 6> kVectorTypes{"",
                                                       "invariant",
                                                       "covariant",
                                                       "covariant normalize",
                                                       "contravariant relative",
                                                       "contravariant absolute"};

}  // namespace

VectorKind vectorKindOf(std::span<const GridMetadata> metadata) {
  VectorKind kind;
  for (const GridMetadata& entry : metadata) {
    if (entry.name == "vector_type") {
      const auto found = std::ranges::find(kVectorTypes, std::string_view(entry.value));
      if (found != kVectorTypes.end())
        kind.type = static_cast<VectorKind::Type>(found - kVectorTypes.begin());
    }
    if (entry.name == "is_local_space" && entry.value.size() == 1)
      kind.local = entry.value[0] != 0;
  }
  return kind;
}

std::string_view vectorTypeName(VectorKind::Type type) {
  return kVectorTypes[static_cast<std::size_t>(type)];
}

Mat3 vectorTurn(VectorKind::Type type, const Mat3& linear) {
  using enum VectorKind::Type;
  switch (type) {
    case kInvariant:
      return Mat3::Identity();
    case kCovariant:
    case kCovariantNormalize:
      return linear.inverse().transpose();
    case kUnstated:
    case kContravariantRelative:
    case kContravariantAbsolute:
      break;
  }
  return linear;
}

}  // namespace volute
