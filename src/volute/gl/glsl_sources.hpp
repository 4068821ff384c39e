// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

// The shaders of glsl/*.glsl, which are files there and strings in the library.

namespace volute::glsl {

extern const char* const kRay;
extern const char* const kMarch;
extern const char* const kVolume;
extern const char* const kVolumeTable;
extern const char* const kVolumeAtlas;
extern const char* const kVolumeShaded;
extern const char* const kVolumeTree;
extern const char* const kFogCells;
extern const char* const kFds;
extern const char* const kSmoke;
extern const char* const kResolve;
extern const char* const kTriangles;
extern const char* const kSurfacesHit;
extern const char* const kSurfacesShadow;
extern const char* const kSurfacesLight;
extern const char* const kLamp;
extern const char* const kSigns;
extern const char* const kSignsDeferred;
extern const char* const kBillboard;
extern const char* const kSheet;
extern const char* const kFogSun;
extern const char* const kLightField;
extern const char* const kLightAgain;
extern const char* const kFogShade;
extern const char* const kFogPolarTable;
extern const char* const kFogPicture;
extern const char* const kTetsVertex;
extern const char* const kTetsFragment;
extern const char* const kTetsWallVertex;
extern const char* const kTetsWallFragment;
extern const char* const kScreen;
extern const char* const kSurfaceVertex;
extern const char* const kSurfaceFragment;
extern const char* const kSurfaceKnown;

}  // namespace volute::glsl
