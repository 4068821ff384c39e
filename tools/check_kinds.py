#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails when generic code names a kind of medium: `check_kinds.py SRC_DIR`.

What is above the media (scene, the interface of media, the renderers, the viewer's document, the part of the command line that
shows scenes) works with any kind. Files of a kind have its name in theirs; kinds are registered in files called kinds."""
import pathlib
import re
import sys

GENERIC = ("scene/*", "media/*", "render/*", "gl/gl_renderer.*", "gl/gl_march.*", "gl/gl_part*", "gl/gl_snapshot.*",
           "gl/gl_scene_renderer.*", "gl/scene_shader.*", "viewer/scene_document.*", "viewer/document_snapshot.*", "viewer/view_picture.*",
           "viewer/exact_surfaces.*", "viewer/loader.*", "film/*")
# What is a name of the file format or of the papers, not of a kind: what --stats and pictures' notes call it.
ALLOWED = re.compile(r'Sun|parseSun|FogCanvas|saveFogMap|setFogMap|GlSmokeMethod|gl_smoke(_method)?\.hpp|smokeMethod|'
                     r'options\.smoke|"volute\.smoke"')
KIND = re.compile(r"fds|fog|smoke", re.I)
COMMENT = re.compile(r"//.*")


def faults(source):
    for pattern in GENERIC:
        for file in sorted(source.glob(pattern)):
            if file.suffix not in (".cpp", ".hpp") or file.stem.endswith("_test") or "kinds" in file.stem:
                continue
            for number, line in enumerate(file.read_text().splitlines(), 1):
                if KIND.search(ALLOWED.sub("", COMMENT.sub("", line))):
                    yield f"{file}:{number}: names a kind of medium: {line.strip()}"


if __name__ == "__main__":
    found = list(faults(pathlib.Path(sys.argv[1])))
    print("\n".join(found) or "kinds: ok")
    sys.exit(bool(found))
