#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails when what is installed of the headers is not docs/public_headers.txt: `check_headers.py ROOT [--update]`.

Public are the headers that include/volute/volute.hpp names, OpenGL's renderer, what joins processes, the way to
Eigen's types, and the fields of kinds of media; with them goes what they
include. A header that users have not seen before is a line of a commit (`--update` writes it), not something that an `#include`
brought along. Pages for users name no other headers."""
import pathlib
import re
import sys

BESIDES = ["volute/gl/gl_scene_renderer.hpp", "volute/cluster/cluster.hpp", "volute/math/eigen.hpp", "volute/math/rotation.hpp",
           "volute/media/field_members.hpp"]  # as cmake/VoluteInstall.cmake has it
INCLUDE = re.compile(r'^#include "(volute/[^"]+)"', re.M)


def headers(root):
    """Those that are named, and all that they include, both sorted."""
    named = INCLUDE.findall((root / "include/volute/volute.hpp").read_text()) + BESIDES
    found, waiting = set(), list(named)
    while waiting:
        header = waiting.pop()
        if header not in found:
            found.add(header)
            waiting += INCLUDE.findall((root / "src" / header).read_text())
    return sorted(named), sorted(found - set(named))


def page(root):
    named, parts = headers(root)
    return "\n".join(["# What is installed of the headers; tools/check_headers.py --update writes this list.", "",
                      f"# Public ({len(named)}): in <volute/volute.hpp>, the renderer of OpenGL, teams of processes, Eigen's types, fields of kinds of media.", *named, "",
                      f"# What these include ({len(parts)}): may change without a word.", *parts, ""])


def main():
    root = pathlib.Path(sys.argv[1])
    listed = root / "docs/public_headers.txt"
    now = page(root)
    if "--update" in sys.argv:
        listed.write_text(now)
        return 0
    before, after = (set(line for line in text.split("\n") if line.startswith("volute/"))
                     for text in (listed.read_text() if listed.exists() else "", now))
    for header in sorted(after - before):
        print(f"{header} would be installed and is not in docs/public_headers.txt: is it for users? Then "
              "tools/check_headers.py . --update; else do not include it in a public header")
    for header in sorted(before - after):
        print(f"{header} is in docs/public_headers.txt and would not be installed; tools/check_headers.py . --update")
    missing = {(path, header) for path in sorted(root.glob("docs/*.md")) + sorted(root.glob("docs/tutorials/*.md")) + [root / "README.md"]
               for header in re.findall(r"(?<!src/)\bvolute/[a-z0-9_/]+\.hpp", path.read_text()) if header != "volute/volute.hpp" and header not in after}
    for path, header in sorted(missing):
        print(f"{path.relative_to(root)} names {header}, which is not installed: make it public (volute.hpp, or BESIDES here), or do not name it")
    if before == after and not missing:
        print("headers: ok")
    return int(before != after or bool(missing))


if __name__ == "__main__":
    sys.exit(main())
