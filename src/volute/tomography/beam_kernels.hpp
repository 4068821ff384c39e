// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/tomography/ray_kernels.hpp"

// The inner loops of the projector for trilinear volumes, apart from it so that the SIMD code is
// one translation unit. Voxels and pixels are four floats, R G B 0.

namespace volute {

/// Nodes on each side of the square that the rays of a beam reach in a plane.
inline constexpr int kBeamNodes = 4;

inline constexpr int kBeamRays = 4;

/// The four rays of one pixel, which walk together from plane to plane of the lattice across the
/// axis along which they advance most. Each axis is taken in the direction in which they ascend.
/// Between two planes, a slab, they reach kBeamNodes x kBeamNodes nodes of each, from an anchor on.
struct Beam {
  std::int32_t node;       ///< the anchor in the first plane
  std::int32_t stride[3];  ///< in nodes, along the two axes in the plane, +-1 for the first, and to
                           ///< the next plane
  std::int32_t slabs;
  std::int32_t turned;  ///< 1: nodes and strides are of the lattice with x and y exchanged
};

/// One of its rays.
struct BeamRay {
  float place[2];  ///< in the first plane, from the anchor [nodes], 0 or more
  float slope[2];  ///< nodes a slab, 0..1
  float length;    ///< [m] a slab
};

/// Beams as the kernels read them: each field of all beams in a row, so that beams side by side are
/// loaded at once.
struct BeamFields {
  struct Ray {
    std::vector<float> place[2], slope[2], length;
  };

  BeamFields() = default;

  /// @param rays  kBeamRays for each beam.
  BeamFields(std::span<const Beam> beams, std::span<const BeamRay> rays);

  /// Entries behind the last beam, as many as any CPU loads at once.
  static constexpr std::size_t kPadding = 16;

  std::vector<std::int32_t> slabs, node, stride[3];
  Ray ray[kBeamRays];
};

/// Some of them that follow each other.
struct BeamRange {
  const BeamFields& beams;
  std::size_t first, count;
};

/// sums[0..3] of each beam: the mean over its rays of the line integrals through `values`.
void beamForward(const BeamRange& beams, const float* values, float* sums);

/// The transpose: adds each beam's four values, spread along its rays, to `gradient`.
void beamAdjoint(const BeamRange& beams, const float* beamValues, float* gradient);

/// Makes of the sums of `count` beams, `first` counted from the range's own, what is spread along
/// them.
using BeamTurn = void (*)(const void* context, std::size_t first, std::size_t count,
                          const float* sums, float* beamValues);

/// Both in one walk: beamForward through `values`, then `turn`, then beamAdjoint.
/// @param sums  as of beamForward.
void beamThereAndBack(const BeamRange& beams, const float* values, BeamTurn turn,
                      const void* context, float* sums, float* gradient);

/// Appends the weights of each beam to its list in `out`: several for a node that it reaches in two
/// slabs, none of 0.
void beamWeights(const BeamRange& beams, std::vector<NodeWeight>* out);

}  // namespace volute
