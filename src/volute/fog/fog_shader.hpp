// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <string>
#include <vector>

#include "volute/fog/fog_medium.hpp"

namespace volute {

/// A fog as functions for shaders of OpenGL 4.5 core and OpenGL ES 3.0, without #version;
/// glsl/*.glsl say what it offers and its uniforms.
struct FogShader {
  /// Degree, and how many levels, zones and points there are: fogs with the same have the same text
  /// where their values are uniforms.
  std::string structure;
  std::string walk;   ///< fogOpticalDepth(); transmittances within 2e-5 of the reference
  std::string polar;  ///< fogPolarOpticalDepth(), to follow `walk`; empty where no table serves
  /// The texture fogMap, R32F, shape (height, width), first row first as glTexImage2D takes it.
  /// Level L has cells(L) + degree texels a side from row firstRow(L) on; coefficient (i, j) is at
  /// column i + degree, row firstRow + j + degree; zeros around.
  int width = 0, height = 0;
  std::vector<float> texels;   ///< [1/m], as fogTexels() has them; only from fogShader()
  Vec3 corner = Vec3::Zero();  ///< uniform fogCorner [m]
  double cell = 1;             ///< uniform fogCell [m]
  double mu = 1;               ///< uniform fogMu

  // What is constant in the text of fogShader() and uniform in that of fogCells().
  std::array<int, 4> mapCells{};                  ///< fogMapCells: first and last cells of the map
  std::vector<std::array<int, 4>> levels;         ///< fogLevels: cells, first row, 0
  std::vector<std::array<float, 2>> zoneHeights;  ///< fogZoneHeights: bottom and top [m]
  std::vector<std::array<float, 4>>
      zones;  ///< fogZones: value, slope [1/m], decay [1/m], reference
};

/// To be given away: degree, levels, map size and profile are constants in the text. kUnsupported
/// for fog with a top or with levels chosen by FogDetail::cellAngle.
[[nodiscard]] Result<FogShader> fogShader(const FogMedium& fog);

/// To be used again and again: what may change from picture to picture is uniform. Of any fog, for
/// shaders that go from cell to cell by themselves: the functions of a cell in `walk` hold,
/// fogOpticalDepth() does only where fogShader() gives it. Without texels.
FogShader fogCells(const FogMedium& fog);

/// FogShader::texels; they depend on nothing but the fog's levels().
std::vector<float> fogTexels(const FogMedium& fog);

}  // namespace volute
