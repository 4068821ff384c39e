// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/plugin.hpp"

#include <dlfcn.h>
#include <link.h>
#include <pthread.h>
#include <sys/mman.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string_view>
#include <system_error>

#include "volute/io/plugin_interface.hpp"

namespace volute {
namespace {

/// For programs that lie elsewhere than Volute; empty: not said.
std::filesystem::path namedFolder() {
  const char* folder = std::getenv("VOLUTE_PLUGIN_FOLDER");
  return folder ? folder : "";
}

/// The Debian package of a plug-in: volute-vdb has volute_io_vdb.so.
std::string packageOf(std::string_view name) {
  constexpr std::string_view kReader = "volute_io_", kOther = "volute_";
  if (name == "volute_io_gltf" || name == "volute_io_tiff" || name == "volute_io_ocio")
    return "volute";
  name.remove_prefix((name.starts_with(kReader) ? kReader : kOther).size());
  return fmt::format("volute-{}", name);
}

std::filesystem::path folderBesideProgram() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error)  // without /proc it is not known where that is: not "lib/volute", of wherever we are
    return {};
  return program.parent_path().parent_path() / "lib" / "volute";
}

/// In the order in which they are looked into; some may be empty.
std::array<std::filesystem::path, 3> pluginFolders() {
  return {namedFolder(), folderBesideProgram(), VOLUTE_PLUGIN_FOLDER};
}

/// Whether a loaded plug-in is made of the headers that this program is made of.
bool ofThisBuild(void* library) {
  void* symbol = ::dlsym(library, "volutePluginInterface");
  return symbol &&
         std::string_view(reinterpret_cast<const char* (*)()>(symbol)()) == kPluginInterface;
}

/// Whether a library ends where it says: the loader maps one that was cut off, and using it is a
/// bus error.
bool isCutOff(const std::filesystem::path& file) {
  ElfW(Ehdr) header{};
  std::ifstream stream(file, std::ios::binary);
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  // The table of sections comes last.
  return error || !stream.read(reinterpret_cast<char*>(&header), sizeof header) ||
         header.e_shoff > size ||
         std::uintmax_t{header.e_shnum} * header.e_shentsize > size - header.e_shoff;
}

/// `function` of the plug-in lib`name`.so, called; null with `reason` when it cannot be loaded.
const void* loadFrom(const std::filesystem::path& file, const char* function, bool checked,
                     std::string& reason) {
  if (isCutOff(file)) {
    reason = file.string() + " is cut off; install it again";
    return nullptr;
  }
  void* library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* symbol = library ? ::dlsym(library, function) : nullptr;
  if (!symbol) {
    reason = ::dlerror();
    return nullptr;
  }
  if (checked && !ofThisBuild(library)) {
    reason = file.string() +
             " was built with another Volute than this program; install or build both together";
    return nullptr;
  }
  return reinterpret_cast<const void* (*)()>(symbol)();
}

Result<const void*> findPlugin(const char* name, const char* function, const char* library,
                               bool checked) {
  std::string reason;
  for (const auto& folder : pluginFolders()) {
    if (folder.empty())
      continue;
    const auto file = folder / (std::string(name) + ".so");
    std::error_code error;
    if (!std::filesystem::exists(file, error))
      continue;
    if (const void* plugin = loadFrom(file, function, checked, reason))
      return plugin;
  }
  if (reason.empty())
    reason = fmt::format(
        "no {}.so in {}, which VOLUTE_PLUGIN_FOLDER can name; it is in the package {}", name,
        (namedFolder().empty() ? folderBesideProgram() : namedFolder()).string(), packageOf(name));
  return fail(ErrorCode::kUnsupported, "the part of Volute that uses {} cannot be loaded: {}",
              library, reason);
}

template <class Plugin>
Result<const Plugin*> load(bool built, const char* name, const char* function, const char* library,
                           const char* option) {
  if (!built) {
    return fail(ErrorCode::kUnsupported, "this build has no {} ({}=OFF); build Volute with it",
                library, option);
  }
  VOLUTE_ASSIGN(const void* plugin, findPlugin(name, function, library, true));
  return static_cast<const Plugin*>(plugin);
}

/// Whether OpenVDB fits into this process. A library that it loads starts four threads at once, and
/// where it gets too few, or too little address space, it aborts or waits for ever: that is tried
/// before.
Status roomForVdb() {
  constexpr std::size_t kLibraries = std::size_t{72} << 20;
  // Plain ones, which take no memory of their own.
  std::array<pthread_t, 4> threads{};
  std::size_t made = 0;
  while (made < threads.size() &&
         ::pthread_create(
             &threads[made], nullptr, [](void*) -> void* { return nullptr; }, nullptr) == 0)
    ++made;
  void* const space =
      ::mmap(nullptr, kLibraries, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  const bool fits = space != MAP_FAILED && ::munmap(space, kLibraries) == 0;
  for (std::size_t i = 0; i < made; ++i) ::pthread_join(threads[i], nullptr);
  if (fits && made == threads.size())
    return {};
  return fail(ErrorCode::kTooLarge,
              "OpenVDB cannot be loaded: it needs {} MiB of address space and four threads; "
              "raise the limits of this shell (ulimit -v, ulimit -u)",
              kLibraries >> 20);
}

}  // namespace

Result<const void*> loadPlugin(const char* name, const char* function, const char* library) {
  return findPlugin(name, function, library, false);
}

std::vector<MediumPlugin> loadMediumPlugins() {
  constexpr std::string_view kPrefix = "volute_medium_";
  std::map<std::string, std::filesystem::path> found;
  for (const auto& folder : pluginFolders()) {
    std::error_code error;
    if (folder.empty())
      continue;
    for (std::filesystem::directory_iterator file(folder, error), end; !error && file != end;
         file.increment(error)) {
      const std::string name = file->path().filename().string();
      if (name.starts_with(kPrefix) && name.ends_with(".so"))
        found.emplace(name, file->path());
    }
  }
  std::vector<MediumPlugin> plugins;
  for (const auto& [name, file] : found) {
    MediumPlugin& plugin = plugins.emplace_back();
    plugin.file = file.string();
    plugin.kind = loadFrom(file, "volute_medium", false, plugin.reason);
    if (!plugin.kind && plugin.reason.empty())
      plugin.reason = plugin.file + ": volute_medium() returned NULL";
  }
  return plugins;
}

Result<const LatticePlugin*> loadVdbPlugin() {
  if (VOLUTE_HAS_VDB) {
    static const Status room = roomForVdb();  // a process that is forked from this one has it
    VOLUTE_TRY(room);
  }
  return load<LatticePlugin>(VOLUTE_HAS_VDB, "volute_io_vdb", "voluteVdbPlugin", "OpenVDB",
                             "VOLUTE_WITH_VDB");
}

Result<const LatticePlugin*> loadVtkPlugin() {
  return load<LatticePlugin>(VOLUTE_HAS_VTK, "volute_io_vtk", "voluteVtkPlugin", "VTK",
                             "VOLUTE_WITH_VTK");
}

Result<const MeshPlugin*> loadVtkMeshPlugin() {
  return load<MeshPlugin>(VOLUTE_HAS_VTK, "volute_io_vtk", "voluteVtkMeshPlugin", "VTK",
                          "VOLUTE_WITH_VTK");
}

Result<const SurfacePlugin*> loadVtkSurfacePlugin() {
  return load<SurfacePlugin>(VOLUTE_HAS_VTK, "volute_io_vtk", "voluteVtkSurfacePlugin", "VTK",
                             "VOLUTE_WITH_VTK");
}

Result<const SurfacePlugin*> loadGltfPlugin() {
  return load<SurfacePlugin>(VOLUTE_HAS_GLTF, "volute_io_gltf", "voluteGltfPlugin", "tinygltf",
                             "VOLUTE_WITH_GLTF");
}

Result<const FilmPlugin*> loadFilmPlugin() {
  return load<FilmPlugin>(VOLUTE_HAS_VIDEO, "volute_io_video", "voluteFilmPlugin", "libav",
                          "VOLUTE_WITH_VIDEO");
}

Result<const StillPlugin*> loadTiffPlugin() {
  return load<StillPlugin>(VOLUTE_HAS_TIFF, "volute_io_tiff", "voluteTiffPlugin", "libtiff",
                           "VOLUTE_WITH_TIFF");
}

Result<const ArrayPlugin*> loadArrayPlugin() {
  return load<ArrayPlugin>(VOLUTE_HAS_GDAL, "volute_io_gdal", "voluteArrayPlugin", "GDAL",
                           "VOLUTE_WITH_GDAL");
}

Result<const ViewPlugin*> loadViewPlugin() {
  return load<ViewPlugin>(VOLUTE_HAS_OCIO, "volute_io_ocio", "voluteViewPlugin", "OpenColorIO",
                          "VOLUTE_WITH_OCIO");
}

}  // namespace volute
