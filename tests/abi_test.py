#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Programs that were linked go on to work: `abi_test.py ROOT BUILD [--update]`.

docs/abi/volute_c.abi is what abidw (Debian's abigail-tools) reads of libvolute_c.so: the functions and types of volute.h, which stay.
docs/abi/volute-core.list lists the functions of libvolute-core.so, which may change with its SOVERSION. Both say what programs can be
linked with today; --update writes them anew, for the commit that adds to them."""
import pathlib
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77


def functions(library):
    """Names of the functions that a library defines itself; inline ones, which a compiler may leave out, are not among them."""
    lines = subprocess.run(["nm", "-DC", "--defined-only", library], check=True, capture_output=True, text=True).stdout.splitlines()
    return sorted({line[19:].split("@@")[0] for line in lines if line[17] == "T"})


def dump(root, library, to):
    subprocess.run(["abidw", "--exported-interfaces-only", "--drop-private-types", "--no-show-locs", "--no-comp-dir-path", "--no-corpus-path",
                    "--headers-dir", root / "include/volute", "--out-file", to, library], check=True)


def check_c(root, library, kept):
    with tempfile.TemporaryDirectory() as folder:
        now = pathlib.Path(folder) / "now.abi"
        dump(root, library, now)
        broken = subprocess.run(["abidiff", "--no-added-syms", kept, now], capture_output=True, text=True)
        if broken.returncode != 0:
            print(broken.stdout + broken.stderr)
            print(f"{library.name} breaks programs that were linked with what {kept.name} lists: volute.h only grows")
            return False
        if subprocess.run(["abidiff", kept, now], capture_output=True).returncode != 0:
            print(f"{library.name} has more than {kept.name} lists: tests/abi_test.py ROOT BUILD --update")
            return False
    return True


def check_core(library, kept):
    before, after = set(kept.read_text().splitlines()), set(functions(library))
    for name in sorted(before - after):
        print(f"{library.name} no longer has {name}: with the next release, VOLUTE_SOVERSION of cmake/VoluteShared.cmake goes up")
    for name in sorted(after - before):
        print(f"{library.name} has {name}, which {kept.name} does not list")
    if before != after:
        print("meant so? tests/abi_test.py ROOT BUILD --update")
    return before == after


def main():
    root, build = map(pathlib.Path, sys.argv[1:3])
    if not shutil.which("abidw"):
        print("abidw is not installed (Debian: abigail-tools)")
        return SKIPPED
    c, core = build / "src/volute/capi/libvolute_c.so", build / "libvolute-core.so"
    kept_c, kept_core = root / "docs/abi/volute_c.abi", root / "docs/abi/volute-core.list"
    if "--update" in sys.argv:
        dump(root, c, kept_c)
        kept_core.write_text("\n".join(functions(core)) + "\n")
        return 0
    checks = [check_c(root, c, kept_c), check_core(core, kept_core)]
    if all(checks):
        print("abi: ok")
    return int(not all(checks))


if __name__ == "__main__":
    sys.exit(main())
