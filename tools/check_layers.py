#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails when a module includes one that it may not: `check_layers.py SRC_DIR LAYERS_FILE`.

SRC_DIR holds one folder per module; a folder in a module's may be a module of its own. LAYERS_FILE has lines `module: allowed allowed ...`: what a module
may include directly. The lists together must have no cycle.
"""
import pathlib
import re
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*["<]volute/([^">]+)/[^/">]+[">]', re.M)


def read_rules(path):
    rules = {}
    for line in path.read_text().splitlines():
        module, colon, allowed = line.split("#")[0].partition(":")
        if colon:
            rules[module.strip()] = allowed.split()
    return rules


def find_cycle(rules):
    """A list of modules that leads back to its first one, or None."""
    finished = set()

    def visit(module, path):
        if module in path:
            return path[path.index(module):] + [module]
        if module in finished:
            return None
        for dependency in rules.get(module, ()):
            cycle = visit(dependency, path + [module])
            if cycle:
                return cycle
        finished.add(module)
        return None

    return next(filter(None, (visit(module, []) for module in rules)), None)


def module_of(folder, rules):
    """The module that a folder, named from SRC_DIR, is of: the innermost one."""
    while folder and folder not in rules:
        folder, slash, _ = folder.rpartition("/")
        if not slash:
            break
    return folder


def check(source, layers):
    rules = read_rules(layers)
    cycle = find_cycle(rules)
    if cycle:
        yield f"{layers}: cycle {' -> '.join(cycle)}"
    for module, allowed in rules.items():
        for name in allowed:
            if name not in rules:
                yield f"{layers}: {module} may include {name}, which has no line of its own"
    for file in sorted(source.rglob("*.[ch]pp")):
        module = module_of(file.relative_to(source).parent.as_posix(), rules)
        if module not in rules:
            yield f"{file}: module '{module}' is not in {layers}"
            continue
        for match in INCLUDE.finditer(file.read_text()):
            included = module_of(match[1], rules)
            if included != module and included not in rules[module]:
                yield f"{file}: {module} may not include {included}"


if __name__ == "__main__":
    errors = list(check(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])))
    print("\n".join(errors) or "layers: ok")
    sys.exit(bool(errors))
