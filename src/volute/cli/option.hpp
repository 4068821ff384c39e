// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace volute::cli {

/// What the text of an option's value must be; values.hpp says what each becomes.
enum class ValueKind {
  kFlag,     ///< no value
  kText,     ///< anything
  kFile,     ///< a path; shells complete file names
  kOutput,   ///< the same, of what is written: none that is read
  kChoice,   ///< one of Option::choices
  kNumber,   ///< a finite number within the option's limits
  kInteger,  ///< a whole number within the option's limits
  kBytes,    ///< 512M, 2G, 123456
  kFrames,   ///< A:B[:S]
  kRegion,   ///< X0:X1,Y0:Y1,Z0:Z1 in voxels
  kBounds,   ///< X0,Y0,Z0,X1,Y1,Z1 in metres
  kVector,   ///< X,Y,Z
  kPixels,   ///< WxH
};

/// One option: the only source of its parsing, help, completion and manual entry.
struct Option {
  std::string name;  ///< the long name, without dashes
  char letter = 0;   ///< the short name; 0 = none
  ValueKind kind = ValueKind::kFlag;
  std::string_view value = {};  ///< how the help calls the value: "FILE"
  std::string help = {};        ///< what it does, with the unit; no full stop
  std::string initial = {};     ///< the default, as a user would type it
  std::vector<std::string_view> choices = {};
  double least = -std::numeric_limits<double>::infinity();  ///< allowed, inclusive
  double most = std::numeric_limits<double>::infinity();
  bool positive = false;  ///< the number must be greater than zero
  bool below = false;     ///< and less than `most`
  bool fraction = false;  ///< kNumber: 24000/1001 is one too
  /// kOutput: what is written without the option: the input's name with this at its end instead of
  /// its extension, in the current folder, and a number where there is such a file already.
  std::string_view derived = {};
  bool required = false;
  bool several = false;                        ///< may be repeated; texts only
  std::vector<std::string_view> aliases = {};  ///< other names, which the help does not show
  std::string_view beside = {};                ///< the option without which it says nothing
  std::string_view instead = {};  ///< the option that is meant where a choice of that is given
  /// Of files that it is for, see file_kind.hpp; empty: all.
  std::vector<std::string_view> kinds = {};
};

/// What stands without dashes. The last one of a command may take several.
struct Positional {
  std::string_view name;  ///< as the help calls it: "INPUT"
  std::string_view help = {};
  bool several = false;
  bool optional = false;
  bool file = true;  ///< a file's name
};

/// Options of which at most one, or exactly one, may be given.
struct OneOf {
  std::vector<std::string_view> names;
  bool required = false;
};

}  // namespace volute::cli
