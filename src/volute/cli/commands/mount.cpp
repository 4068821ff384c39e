// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/sibling_program.hpp"

namespace volute::cli {
namespace {

/// A program of its own: no other command needs libfuse.
Status runMount(const Arguments& /*arguments*/, Context& context) {
  return becomeSibling("volute-mount", "./dev build builds it where libfuse3-dev is installed", context);
}

}  // namespace

Command mountCommand() {
  return {
      .name = "mount",
      .summary = "Shows a .volute file as a folder of .vdb files",
      .examples = {"volute mount fire.volute /tmp/fire &", "volute mount fire.volute fire --max-memory 1G"},
      .description =
          "The folder has fire_0001.vdb and so on, by the frames' numbers: the bytes that 'volute "
          "extract' would write, made when a program reads them. Blender, Houdini and everything else "
          "that reads OpenVDB plays them without a plug-in; the folder is read-only.\n\n"
          "Frames of one row of blocks (16) are decoded together and kept, and so are the last files, "
          "within --max-memory. How large a file is nobody knows before it was made: 'ls -l' makes "
          "them all, 'ls' none.\n\n"
          "It runs until Ctrl-C, or until 'fusermount3 -u FOLDER'. FUSE must be there (the package "
          "fuse3, and /dev/fuse in containers). Where it was killed and the folder is still mounted, "
          "'fusermount3 -u FOLDER' lets it go.",
      .positionals = {{.name = "FILE", .help = "a .volute file"}, {.name = "FOLDER", .help = "an empty folder"}},
      .run = runMount};
}

}  // namespace volute::cli
