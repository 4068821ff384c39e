// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <span>

namespace volute::detail {

/// What a confined process keeps.
struct Confinement {
  std::span<const std::filesystem::path> readable;  ///< files, and folders with all below them
  int socket = -1;                                  ///< to the process that asks
  int lifeline = -1;                                ///< ends this process with that one
  int shared = -1;                                  ///< memory that it shares with that one
};

/// From here on this process can read what is `readable`, use memory, and answer; nothing else: it
/// cannot write or create files, run programs, make processes or connections, signal others, map
/// code, or get more rights. What is refused is an error for whoever tries (EPERM), not its end.
/// Reading is confined by Landlock where the kernel has it, the rest by a seccomp filter. For
/// processes with one thread. False when the kernel refuses a filter: nobody should read then.
[[nodiscard]] bool confineThisProcess(const Confinement& keep);

/// The same for a process that is about to become a program: it can read and run what lies below
/// `folders`, and use what is open already; it cannot write or create files, nor make connections.
[[nodiscard]] bool confineProgram(std::span<const std::filesystem::path> folders);

/// Whether reading is confined to what is `readable` on this machine.
bool readingIsConfined();

}  // namespace volute::detail
