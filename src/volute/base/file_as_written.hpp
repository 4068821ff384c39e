// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace volute {

/// The files that a file names. Programs on Windows write backslashes, and do not mind the case of
/// letters: the only file whose name differs in that alone is meant.
class FilesAsWritten {
 public:
  /// `name` from `folder` on, as it stands where there is such a file, or none that could be meant.
  std::filesystem::path find(const std::filesystem::path& folder, const std::string& name);

  /// Names that were found otherwise than they are written.
  std::size_t others() const { return others_; }

  /// "2 names differ from those of the files in ..."; empty without any.
  std::string remark() const;

 private:
  std::map<std::filesystem::path, std::map<std::string, std::vector<std::string>>> folders_;
  std::size_t others_ = 0;
  std::string firstOther_;  ///< "hall.sf for '.\HALL.SF'"
};

}  // namespace volute
