#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails when a string of the library names an option of the command: `check_strings.py src/volute`.

What a user can change is a Hint beside the sentence (src/volute/base/hint.hpp), which the command words as an option, Python
as an argument and the viewer as a control.
"""
import pathlib
import re
import sys

LITERAL = re.compile(r'"((?:\\.|[^"\\\n])*)"')
OPTION = re.compile(r"(?<![\w-])--[a-z]")
# Options of other programs, and tables from which the command makes its help.
ALLOWED = {"report/pdf.cpp", "viewer/file_dialog.cpp", "viewer/viewer_playback.cpp", "visibility/plan_underlay.cpp",
           "scene/scene_tables.cpp", "media/volume/volume_fields.hpp", "media/volume/volume_fields.cpp"}


def strings(text):
    """(line, literal) of the C++ text, but for comments."""
    for number, line in enumerate(text.split("\n"), 1):
        code = re.sub(r"^\s*//.*", "", line)
        for literal in LITERAL.findall(code):
            yield number, literal


def main():
    root = pathlib.Path(sys.argv[1])
    bad = 0
    for file in sorted(root.rglob("*.[ch]pp")):
        name = str(file.relative_to(root))
        if name.startswith("cli/") or name in ALLOWED or name.endswith("_test.cpp"):
            continue
        for number, literal in strings(file.read_text()):
            code = re.sub(r"\s//.*", "", literal)
            if OPTION.search(code):
                print(f"{file}:{number}: the library names an option of the command in \"{literal}\"; say it as a Hint")
                bad += 1
    print("strings: ok" if not bad else f"strings: {bad}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
