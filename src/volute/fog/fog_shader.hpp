// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volute/fog/fog_medium.hpp"

namespace volute {

/// A fog as functions for shaders of OpenGL 4.5 core and OpenGL ES 3.0, without #version. Degree,
/// levels, map size and profile are constants in it; glsl/*.glsl say what it offers and its
/// uniforms.
struct FogShader {
  std::string walk;   ///< fogOpticalDepth(); transmittances within 2e-5 of the reference
  std::string polar;  ///< fogPolarOpticalDepth(), to follow `walk`; empty where no table serves
  /// The texture fogMap, R32F, shape (height, width), first row first as glTexImage2D takes it.
  /// Level L has cells(L) + degree texels a side from row firstRow(L) on; coefficient (i, j) is at
  /// column i + degree, row firstRow + j + degree; zeros around.
  int width = 0, height = 0;
  std::vector<float> texels;   ///< [1/m]
  Vec3 corner = Vec3::Zero();  ///< uniform fogCorner [m]
  double cell = 1;             ///< uniform fogCell [m]
  double mu = 1;               ///< uniform fogMu
};

/// kUnsupported for fog with a top or with levels chosen by FogDetail::cellAngle.
[[nodiscard]] Result<FogShader> fogShader(const FogMedium& fog);

/// The same of any fog, for shaders that go from cell to cell by themselves: the functions of a
/// cell in `walk` hold, fogOpticalDepth() does only where fogShader() gives it. No `polar`.
FogShader fogCells(const FogMedium& fog);

}  // namespace volute
