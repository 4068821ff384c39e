#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Public headers compile alone, without a warning: `headers_alone_test.py ROOT [--all] [--jobs N]`.

By g++ and clang++ (of names that Debian gives them, those that are found), as C++20 and C++23. <volute/volute.hpp> by each of these;
every header of its own, which costs seconds, by one of them in turn, or by each with --all."""
import concurrent.futures
import pathlib
import shutil
import subprocess
import sys

COMPILERS = ["g++", "clang++-19"]  # older clangs lack what the headers use (C++20's ranges)
STANDARDS = ["c++20", "c++23"]
WARNINGS = ["-Wall", "-Wextra", "-Werror"]


def public_headers(root):
    """Those that users may name: the first part of the list."""
    part = (root / "docs/public_headers.txt").read_text().split("\n# What these include")[0]
    return [line for line in part.split("\n") if line.startswith("volute/")]


def includes(root):
    flags = [f"-I{root / 'src'}", f"-I{root / 'include'}"]
    found = subprocess.run(["pkg-config", "--cflags", "eigen3"], capture_output=True, text=True)
    return flags + [flag.replace("-I", "-isystem", 1) for flag in found.stdout.split()]


def compile_alone(header, compiler, standard, flags):
    """What the compiler says of a file that includes the header, twice, and nothing else; empty: nothing."""
    text = f"#include <{header}>\n#include <{header}>\n"
    done = subprocess.run([compiler, f"-std={standard}", *WARNINGS, *flags, "-fsyntax-only", "-x", "c++", "-"], input=text,
                          capture_output=True, text=True)
    return "" if done.returncode == 0 and not done.stderr else done.stderr or f"exit status {done.returncode}"


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    jobs = int(sys.argv[sys.argv.index("--jobs") + 1]) if "--jobs" in sys.argv else 2
    ways = [(compiler, standard) for compiler in COMPILERS if shutil.which(compiler) for standard in STANDARDS]
    if not ways:
        print("neither g++ nor clang++-19 is here")
        return 77
    flags = includes(root)
    broken = compile_alone("volute/no_such_header.hpp", *ways[0], flags)
    assert "no_such_header" in broken, "a header that is missing went unseen"
    work = [("volute/volute.hpp", *way) for way in ways]
    for i, header in enumerate(public_headers(root)):
        work += [(header, *way) for way in (ways if "--all" in sys.argv else [ways[i % len(ways)]])]
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for one, said in zip(work, pool.map(lambda one: compile_alone(*one, flags), work)):
            if said:
                failed += 1
                print(f"{one[0]} does not compile alone by {one[1]} -std={one[2]}:\n{said[:2000]}")
    print(f"{len(work) - failed} of {len(work)} headers compiled, by {', '.join(' '.join(way) for way in ways)}")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
