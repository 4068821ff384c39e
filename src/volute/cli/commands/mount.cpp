// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/sibling_program.hpp"

namespace volute::cli {
namespace {

/// A program of its own: no other command needs libfuse.
Status runMount(const Arguments& /*arguments*/, Context& context) {
  return becomeSibling("volute-mount", "./dev build builds it where libfuse3-dev is installed",
                       context);
}

}  // namespace

Command mountCommand() {
  return {
      .name = "mount",
      .summary = "Shows a .volute file as a folder of .vdb files",
      .examples = {"volute mount fire.volute /tmp/fire &",
                   "volute mount fire.volute fire --max-memory 1G"},
      .description =
          "The folder contains fire_0001.vdb and so on, one file per frame, numbered as the .vdb "
          "files were of which the .volute was made, with the same bytes "
          "as from 'volute extract', generated when a program reads them. Blender, Houdini and "
          "other programs that read OpenVDB play them without a plug-in. The folder is "
          "read-only.\n\nThe frames of a row of blocks, up to 16, are decoded together; they and "
          "the most "
          "recent files are kept within --max-memory. The size of a file is known only after it "
          "is generated: 'ls -l' generates them all, 'ls' none.\n\nThe command runs until Ctrl-C, "
          "or until 'fusermount3 -u FOLDER'. It needs FUSE (the package fuse3, and /dev/fuse in "
          "containers). If it was killed and the folder is still mounted, 'fusermount3 -u FOLDER' "
          "unmounts it.",
      .positionals = {{.name = "FILE", .help = "a .volute file"},
                      {.name = "FOLDER", .help = "an empty folder"}},
      .options = {filesRateOption()},
      .run = runMount};
}

}  // namespace volute::cli
