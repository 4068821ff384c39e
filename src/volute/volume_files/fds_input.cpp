// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/fds_input.hpp"

namespace volute {

Result<std::unique_ptr<FdsVolume>> openFdsVolume(const std::string& path, const std::string& source,
                                                 std::optional<Box3> bounds,
                                                 std::optional<int> mesh, Reading& reading) {
  FdsVolume::Options options;
  options.read.source = source;
  options.read.maxMemory = reading.maxMemory;
  options.bounds = bounds;
  options.mesh = mesh;
  VOLUTE_ASSIGN(auto volume, FdsVolume::open(path, options));
  for (const Remark& remark : volume->fdsCase().remarks()) reading.progress.remark(remark);
  reading.progress.remark(fmt::format("{}: extinction from {} ({})", path,
                                      volume->fdsCase().source().name,
                                      volume->fdsCase().source().description));
  return volume;
}

}  // namespace volute
