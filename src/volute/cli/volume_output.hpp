// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>

#include "volute/cli/context.hpp"
#include "volute/grid/copy_frames.hpp"

namespace volute::cli {

/// checkOutput(), and its folder is watched for half-written files.
[[nodiscard]] Status checkTarget(const std::string& target, bool standardOutput = false);

/// A place for volumes by the target's name, as createSink has it; "-" is a .npy on standard
/// output. A name of no known format is wrong usage.
/// @param voluteToo  a .volute was no wrong choice either; its caller writes it.
[[nodiscard]] Result<std::unique_ptr<FrameSink>> openSink(const std::string& target,
                                                          const VolumeInfo& info,
                                                          bool voluteToo = false);

}  // namespace volute::cli
