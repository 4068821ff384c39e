#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails where sources or pages use a word that this project has another one for: `check_language.py [ROOT]`.

One thing has one name, and that is the field's. Only what a program can tell is looked for; `moment`, say, is a good word where
integrals of x^n are meant, so that it is looked for where times are spoken of."""
import pathlib
import re
import subprocess
import sys

SUFFIXES = {".cpp", ".hpp", ".h", ".glsl", ".py", ".md", ".txt", ".in"}
EVERYWHERE = r"."
# OpenFOAM calls the folders of a decomposed case processor0, ...
# OpenColorIO what computes colours.
NOT_OF_OPENFOAM = r"(?!src/volute/io/(foam_files|mesh_cases_test|ocio_plugin)\.cpp|docs/meshes\.md)"
# Where a time is the only thing that the word could mean.
OF_TIMES = r"(src/volute/(cli|film|scene|render|report|image|synth|capture|fds|visibility|media/fds|cluster|capi)|bench|apps|tools|docs|README|python|examples)"

# Pages, which people read from the beginning.
PAGES = r"(docs/|README|CHANGELOG|SECURITY|CONTRIBUTING)"

# (what, where, instead)
RULES = [
    (r"(?<![-\w])[Pp]rocessors?(?![a-z])|[a-z]Processors?(?![a-z])", NOT_OF_OPENFOAM, "CPU"),
    (r"\b[Ww]ish(es)?(?![a-z])|[a-z]Wish(es)?(?![a-z])", EVERYWHERE, "request"),
    (r"\b[Mm]oments?\b|[a-z]Moment|\bMOMENTS?\b", OF_TIMES, "time, frame (a stored one) or snapshot (the scene at a time)"),
    (r"\btakeWords\b|\bobjection\b", EVERYWHERE, "parse, error"),
    (r"\bletOthersBeforeWorkers\b", EVERYWHERE, "lowerWorkerPriority"),
    (r"\bkMost(?![a-z])|\bkLeast(?!Squares|[a-z])", EVERYWHERE, "kMax, kMin"),
    (r"\bGlNature\b", EVERYWHERE, "GlMediumTraits"),
    (r"\bwho hears of\b", EVERYWHERE, "receives progress of"),
    (r"\brays that begin nowhere\b", EVERYWHERE, "parallel rays without a near plane"),
    (r"\bby exact integrals where others step\b", EVERYWHERE, "by exact line integrals instead of ray marching"),
    (r"\b(is|are) of no known\b", EVERYWHERE, "has an unknown ..., is not a known ..."),
    (r"'\{\}' are no\b", EVERYWHERE, "'{}' is not a ..."),
    (r"\bsays nothing without\b", EVERYWHERE, "has no effect without"),
    (r"\bthe least first\b", EVERYWHERE, "the minimum first"),
    (r"\bwhich ones? of (a )?files? with several\b", EVERYWHERE, "grid or field of a file with several"),
    (r"\bsays itself what\b", EVERYWHERE, "declares what"),
    (r"\bdoll'?s'? houses?\b", PAGES, "a cutaway"),
    (r"\b[Mm]ade-up\b", PAGES, "synthetic"),
    (r"\bof strangers\b|\bstranger's\b", PAGES, "untrusted"),
    (r"\bgo(es)? on (from|where)\b", PAGES, "continues from"),
    (r"\bin the place of\b", PAGES, "instead of"),
]
# This file and its test name what they look for.
EXEMPT = re.compile(r"tools/check_language(_test)?\.py$")


def faults_in(name, text):
    """Sentences about the lines of a file of this name."""
    if EXEMPT.search(name):
        return
    for pattern, where, instead in RULES:
        if not re.match(where, name):
            continue
        for number, line in enumerate(text.splitlines(), 1):
            if found := re.search(pattern, line):
                yield f"{name}:{number}: '{found[0]}' is called {instead} here: {line.strip()[:100]}"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    listed = subprocess.run(["git", "-C", root, "ls-files"], capture_output=True, text=True)
    names = listed.stdout.split("\n") if listed.returncode == 0 else [
        path.relative_to(root).as_posix() for folder in ("src", "bench", "apps", "tools", "docs", "python", "examples", "include", "fuzz")
        for path in sorted((root / folder).rglob("*"))]
    found = [fault for name in names if pathlib.Path(name).suffix in SUFFIXES and (root / name).is_file()
             for fault in faults_in(name, (root / name).read_text(errors="replace"))]
    print("\n".join(found) or "language: ok")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
