// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/output_place.hpp"

namespace volute {

Result<std::filesystem::path> outputPlace(const std::filesystem::path& target,
                                          const std::string& name) {
  constexpr int kMaxLinks = 40;
  std::filesystem::path place = target;
  std::error_code error;
  for (int i = 0; std::filesystem::is_symlink(place, error); ++i) {
    const auto next = std::filesystem::read_symlink(place, error);
    if (error || i == kMaxLinks)
      return fail(ErrorCode::kIo, "{}: this symbolic link leads nowhere", name);
    place = place.parent_path() / next;
    if (!place.has_filename())  // "FOLDER/" is FOLDER, which may be a link, too
      place = place.parent_path();
  }
  return place;
}

}  // namespace volute
