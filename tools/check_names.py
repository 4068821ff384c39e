#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails when two different types of a program have one name, or two sources that are compiled together one private name:
`check_names.py FOLDER..`.

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


PRIVATE = re.compile(r"^namespace \{\n(.*?)^\}  // namespace$", re.S | re.M)
CONSTANT = re.compile(r"^(?:inline |static )?(?:constexpr|const)\b[^\n=({]*?\b(k[A-Z]\w*)(?:\[[^\]]*\])*(?: =|[{(])", re.M)
FUNCTION = re.compile(r"^(?!return|if|for|while|struct|class|else)[A-Za-z][\w:<>,&* \[\]]*?[ &*]\b(\w+)\(([^()]*)\)", re.M)
ENUMERATORS = re.compile(r"^enum (?!class |struct )(?:\w+ )?(?:: [\w:]+ )?\{(.*?)\};", re.S | re.M)
CLASS = re.compile(r"^(?:struct|class|enum class|enum) (\w+)", re.M)


def clashes(folders):
    """{name: files}: names of anonymous namespaces that sources of one folder share, which are compiled together."""
    found = collections.defaultdict(set)
    for folder in folders:
        for path in pathlib.Path(folder).rglob("*.cpp"):
            text = path.read_text(errors="replace")
            if "hwy/foreach_target.h" in text or path.name.startswith(OTHER_PROGRAMS) or LLVM_FUZZER in text:
                continue
            place = (path.parent, path.name.endswith("_test.cpp"))
            for part in PRIVATE.findall(text):
                part = re.sub(r"//[^\n]*", "", part)
                enumerators = re.findall(r"\bk[A-Z]\w*", " ".join(re.sub(r"=[^,}]*", "", one) for one in ENUMERATORS.findall(part)))
                for name in CONSTANT.findall(part) + CLASS.findall(part) + enumerators:
                    found[(place, name)].add(str(path))
                for name, parameters in FUNCTION.findall(part):
                    types = re.sub(r"\s*\b\w+\s*(=[^,]*)?(?=,|$)", "", " ".join(parameters.split()))
                    found[(place, f"{name}({types})")].add(str(path))
    return {name: files for (_, name), files in found.items() if len(files) > 1}


# Programs and plug-ins beside a module's own sources, and fuzz targets, which are a program each.
LLVM_FUZZER = "LLVMFuzzerTestOneInput"
OTHER_PROGRAMS = ("viewer_soak", "viewer_playback", "embree_scene", "gltf_plugin", "volute_fan", "paper_figures", "main")


def main():
    if len(sys.argv) < 2:
        sys.exit("check_names: expected folders of sources")
    found = doubles(sys.argv[1:])
    for name, files in sorted(found.items()):
        print(f"{name} is defined in {' and '.join(sorted(files))}; give one of them another name or namespace")
    shared = clashes(sys.argv[1:])
    for name, files in sorted(shared.items()):
        print(f"{name} is in the anonymous namespaces of {' and '.join(sorted(files))}, which are compiled together; rename one")
    if not found and not shared:
        print("names: ok")
    return 1 if found or shared else 0


if __name__ == "__main__":
    sys.exit(main())
