// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

// The shaders of glsl/*.glsl, which are files there and strings in the library.

namespace volute::glsl {

extern const char* const kRay;
extern const char* const kMarch;
extern const char* const kVolume;
extern const char* const kVolumeAtlas;
extern const char* const kVolumeTree;
extern const char* const kFogCells;
extern const char* const kSmoke;
extern const char* const kSplatVertex;
extern const char* const kSplatFragment;
extern const char* const kResolve;
extern const char* const kTetsVertex;
extern const char* const kTetsFragment;
extern const char* const kTetsWallVertex;
extern const char* const kTetsWallFragment;

}  // namespace volute::glsl
