// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/hdf5_filters.hpp"

#include <H5PLextern.h>
#include <dlfcn.h>
#include <hdf5.h>

#include <filesystem>
#include <string>
#include <vector>

namespace volute {
namespace {

/// Beside the library that this is in.
std::filesystem::path ownFolder() {
  Dl_info here{};
  if (::dladdr(reinterpret_cast<const void*>(&loadHdf5Filters), &here) == 0 || !here.dli_fname)
    return {};
  return std::filesystem::path(here.dli_fname).parent_path() / "hdf5";
}

std::vector<std::filesystem::path> folders() {
  std::vector<std::filesystem::path> all;
  unsigned wanted = 0, count = 0;  // the environment may forget all of them
  H5PLget_loading_state(&wanted);
  if ((wanted & H5PL_FILTER_PLUGIN) != 0)
    H5PLsize(&count);
  for (unsigned i = 0; i < count; ++i) {
    const ssize_t length = H5PLget(i, nullptr, 0);
    std::string path(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
    if (!path.empty() && H5PLget(i, path.data(), path.size() + 1) == length)
      all.emplace_back(path);
  }
  all.push_back(ownFolder());
  return all;
}

/// What is no filter is left.
void loadFilter(const std::filesystem::path& file) {
  void* library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library)
    return;
  const auto type = reinterpret_cast<H5PL_type_t (*)()>(::dlsym(library, "H5PLget_plugin_type"));
  const auto info = reinterpret_cast<const void* (*)()>(::dlsym(library, "H5PLget_plugin_info"));
  if (type && info && type() == H5PL_TYPE_FILTER)
    H5Zregister(info());
}

}  // namespace

void loadHdf5Filters() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  for (const auto& folder : folders()) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with("lib") && name.find(".so") != std::string::npos)
        loadFilter(entry.path());
    }
  }
}

}  // namespace volute
