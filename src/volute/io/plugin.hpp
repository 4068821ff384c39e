// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/image/view_transform.hpp"
#include "volute/io/array_file.hpp"
#include "volute/io/film.hpp"
#include "volute/io/lattice.hpp"
#include "volute/io/mesh.hpp"
#include "volute/io/still.hpp"
#include "volute/io/surface.hpp"

namespace volute {

/// The parts of this library with heavy dependencies are plug-ins, loaded at the first use: a
/// program that reads no VTK file neither waits for VTK nor carries it. They lie in the
/// folder that the environment's VOLUTE_PLUGIN_FOLDER names, in lib/volute beside the program's
/// bin, or where the library was to be installed when it was configured. An error says when this
/// build has none, or the plug-in that is there is of another one.
[[nodiscard]] Result<const LatticePlugin*> loadVdbPlugin();
[[nodiscard]] Result<const LatticePlugin*> loadVtkPlugin();
[[nodiscard]] Result<const MeshPlugin*> loadVtkMeshPlugin();
[[nodiscard]] Result<const SurfacePlugin*> loadVtkSurfacePlugin();
[[nodiscard]] Result<const SurfacePlugin*> loadGltfPlugin();
[[nodiscard]] Result<const FilmPlugin*> loadFilmPlugin();
[[nodiscard]] Result<const StillPlugin*> loadTiffPlugin();
[[nodiscard]] Result<const ArrayPlugin*> loadArrayPlugin();
[[nodiscard]] Result<const ViewPlugin*> loadViewPlugin();

/// What `function` of another plug-in, lib/volute/NAME.so, returns, of whatever build it is: what
/// it returns must say. `library` is what it needs, for the error.
[[nodiscard]] Result<const void*> loadPlugin(const char* name, const char* function,
                                             const char* library);

/// A plug-in with a kind of medium, volute_medium_NAME.so.
struct MediumPlugin {
  std::string file{};
  const void* kind = nullptr;  ///< what its volute_medium() returns; null: it cannot be loaded
  std::string reason{};        ///< why
};

/// All of these folders' plug-ins with kinds of media, each name once, in the order of names.
std::vector<MediumPlugin> loadMediumPlugins();

}  // namespace volute
