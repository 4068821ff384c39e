#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails when two different types of a program have one name: `check_names.py FOLDER..`.

C++ takes two definitions of `volute::Segment` in two files for the same, whatever is in them, and neither compiler nor
linker says so. Types of anonymous namespaces, and those within classes and functions, may be called as one likes. Tests
are programs of their own, each with the types of one module's tests.
"""
import collections
import pathlib
import re
import sys

NOISE = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*',
                   re.S | re.M)
TOKEN = re.compile(r"[{};]")
NAMESPACE = re.compile(r"(?:inline\s+)?namespace\s+([\w:\s]*)$")
TYPE = re.compile(r"(?:^|\s)(template\s*<.*>\s*)?(?:struct|class|union|enum(?:\s+(?:class|struct))?)\s+"
                  r"(?:\[\[[^\]]*\]\]\s*|alignas\s*\([^)]*\)\s*)*(\w+)\s*(?:final\s*)?(?::[^:].*)?$", re.S)


def types_of(text):
    """The qualified names of the types that are defined at namespace scope, but for anonymous ones."""
    text = NOISE.sub(" ", text)
    scopes = []  # names of namespaces; None: anonymous, or no namespace
    begin = 0
    for token in TOKEN.finditer(text):
        before = text[begin:token.start()].strip()
        begin = token.end()
        if token[0] == "{":
            namespace = NAMESPACE.search(before)
            defined = TYPE.search(before)
            if namespace:
                scopes.append(namespace[1].strip() or None)
            else:
                if defined and None not in scopes and not before.startswith(("template <>", "template<>")):
                    yield "::".join([*scopes, defined[2]])
                scopes.append(None)
        elif token[0] == "}" and scopes:
            scopes.pop()


def doubles(folders):
    found = collections.defaultdict(set)
    for folder in folders:
        for file in sorted(pathlib.Path(folder).rglob("*.[ch]pp")):
            if not file.name.endswith("_test.cpp"):
                for name in types_of(file.read_text()):
                    found[name].add(str(file))
    return {name: files for name, files in found.items() if len(files) > 1}


def main():
    if len(sys.argv) < 2:
        sys.exit("check_names: expected folders of sources")
    found = doubles(sys.argv[1:])
    for name, files in sorted(found.items()):
        print(f"{name} is defined in {' and '.join(sorted(files))}; give one of them another name or namespace")
    if not found:
        print("names: ok")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
