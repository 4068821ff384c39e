// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/medium/any_medium.hpp"

struct volute_medium_kind;

namespace volute {

/// An error of a medium of a user's own kind. It is an exception because queries of a batch of rays
/// have no error results.
class OwnMediumFault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Registers a kind of medium that is given by functions of C (include/volute/medium.h), before
/// scenes with it are opened. One of the same name that was registered so is replaced; scenes that
/// are open keep the former. kInvalidArgument if it is not complete, or the name is one of
/// Volute's.
[[nodiscard]] Status registerOwnKind(const volute_medium_kind& kind);

/// Registers the kinds of all plug-ins volute_medium_*.so. What cannot be loaded is among
/// ownKindFaults().
void registerPluginKinds();

/// Sentences about plug-ins of media that could not be loaded, for errors about unknown kinds.
const std::vector<std::string>& ownKindFaults();

}  // namespace volute
