// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// The outputs of one run, no two of which may have one name, however it is spelt and whichever
/// links lead there.
class OutputNames {
 public:
  /// @param name  a file, or a pattern with the number of a frame
  /// @param what  how the output is called: "--stats", "grid 'a'"
  /// kInvalidArgument where another one has the name, or one of a pattern's.
  [[nodiscard]] Status add(const std::string& name, std::string_view what);

 private:
  std::vector<std::pair<std::filesystem::path, std::string>> names_;
};

/// Whether `output` is read as `input`, which may be a file, a pattern or a folder of numbered
/// files, through links too.
[[nodiscard]] bool replaces(const std::string& output, const std::string& input);

/// kInvalidArgument where `output` replaces one of `inputs`, or what one of these names: a scene's
/// maps, a capture's masks, the files of a collection. "-" replaces nothing, "" is no input.
/// @param setting  that the error is about; empty: none
[[nodiscard]] Status checkReplacesNothing(const std::string& output,
                                          const std::vector<std::string>& inputs,
                                          std::string_view setting = {});

/// Whether a file lies in a folder or below, through links too; neither need be there.
[[nodiscard]] bool liesIn(const std::filesystem::path& file, const std::filesystem::path& folder);

/// Whether a name that a file gives may be part of an output's name: no slash, which would lead to
/// another folder, no control character, and neither "." nor "..". Else kInvalidData.
[[nodiscard]] Status checkNamePart(std::string_view name, const std::string& what);

}  // namespace volute
