#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails when a source is not as `./dev format` writes it: `check_format.py ROOT`. Exit status 77 without clang-format-19."""
import pathlib
import shutil
import subprocess
import sys

FOLDERS = ["src", "apps", "bench", "examples", "fuzz", "python", "tests", "include"]


def main(root):
    formatter = shutil.which("clang-format-19")
    if not formatter:
        print("clang-format-19 is not installed: `./dev test` installs it")
        return 77
    files = sorted(path for folder in FOLDERS for kind in ("*.cpp", "*.hpp") for path in (root / folder).rglob(kind))
    if len(files) < 1000:
        print(f"only {len(files)} sources below {root}")
        return 1
    run = subprocess.run([formatter, "--dry-run", *files], capture_output=True, text=True, cwd=root, check=True)
    wrong = sorted({line.split(":")[0] for line in run.stderr.splitlines() if "-Wclang-format-violations" in line})
    for path in wrong:
        print(f"{path}: not as ./dev format writes it")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
