#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""What a shared library shows: `exported_symbols.py --nm NM --headers FILE.. --archives FILE.. -o FILE`.

Writes a linker's version script with the symbols of the archives whose outermost name (volute::VoluteReader of one of its members)
is declared in one of the headers, and hides all others. Inline functions stay where they are compiled; members of templates are
shown where a header says that the library has them (`extern template class`)."""
import argparse
import pathlib
import re
import subprocess
import sys

NOISE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*', re.S | re.M)
NAMESPACE = re.compile(r"(?:inline\s+)?namespace\s+([\w:\s]*)$")
TYPE = re.compile(r"\b(?:struct|class|union|enum(?:\s+(?:class|struct))?)\s+(?:\[\[[^\]]*\]\]\s*)*(\w+)")
CALLED = re.compile(r"(\w+)\s*\(")
INSTANTIATED = re.compile(r"\bextern\s+template\s+(?:class|struct)\s+(\w+)")
VARIABLE = re.compile(r"\bextern\b.*\b(\w+)(?:\[[^\]]*\])*$", re.S)
PREFIX = re.compile(r"^(?:vtable for |VTT for |typeinfo name for |typeinfo for |guard variable for |(?:non-)?virtual thunk to )+")


def declared(text):
    """Qualified names of types, functions and variables that stand at namespace scope."""
    names = set()
    scopes, begin = [], 0  # names of namespaces; None: anything else
    text = NOISE.sub(" ", text)
    for token in re.finditer(r"[{};]", text):
        before = text[begin:token.start()].strip()
        begin = token.end()
        if all(scopes) and before:
            space = NAMESPACE.search(before)
            if token[0] == "{" and space:
                scopes.append(re.sub(r"\s", "", space[1]) or None)
                continue
            plain = re.sub(r"\[\[[^\]]*\]\]", " ", before)
            found = TYPE.findall(plain.split("(")[0]) + CALLED.findall(plain) + VARIABLE.findall(plain)
            names.update("::".join(scopes + [name]) for name in found)
        if token[0] == "{":
            scopes.append(None)
        elif token[0] == "}" and scopes:
            scopes.pop()
    return names


def qualified(symbol):
    """The name in a demangled symbol, in its parts: ["volute", "Scene", "open"]; [] where it is none of a function or a table."""
    symbol = PREFIX.sub("", symbol)
    if "{lambda" in symbol or "(anonymous namespace)" in symbol:
        return []
    parts, part, depth = [], "", 0
    for i, sign in enumerate(symbol):
        if sign in "<(" and not part.endswith("operator"):
            if sign == "(" and depth == 0:
                break
            depth += 1
        elif sign in ">)" and not part.endswith(("operator", "operator-", "operator=")):
            depth -= 1
        elif depth == 0 and sign == " " and "operator" not in part:
            parts, part = [], ""  # that was a return type
        elif depth == 0 and sign == ":" and symbol[i - 1:i] == ":":
            parts.append(part.rstrip(":"))
            part = ""
        elif depth == 0:
            part += sign
    return parts + [re.sub(r"\[abi:\w+\]", "", part)]


def is_declared(symbol, names):
    parts = qualified(symbol)
    return any("::".join(parts[:count]) in names for count in range(2, len(parts) + 1))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--nm", default="nm")
    parser.add_argument("--headers", nargs="+", type=pathlib.Path, required=True)
    parser.add_argument("--archives", nargs="+", required=True)
    parser.add_argument("--version", default="VOLUTE_0")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    texts = [header.read_text() for header in arguments.headers]
    names = set().union(*map(declared, texts))
    instantiated = {name for text in texts for name in INSTANTIATED.findall(text)}
    listed = subprocess.run([arguments.nm, "--defined-only", "--extern-only", "--no-sort", *arguments.archives], stdout=subprocess.PIPE, check=True,
                            text=True).stdout
    defined = re.findall(r"^[0-9a-f]+ ([TDBRVW]) (_Z\S+)$", listed, re.M)
    weak = {symbol for kind, symbol in defined if kind == "W"}
    mangled = sorted({symbol for kind, symbol in defined})
    plain = subprocess.run(["c++filt"], input="\n".join(mangled), stdout=subprocess.PIPE, check=True, text=True).stdout.splitlines()
    shown = [symbol for symbol, name in zip(mangled, plain)
             if is_declared(name, names) and (symbol not in weak or instantiated & set(qualified(name)[:-1]))]
    if not shown:
        sys.exit("exported_symbols.py: the headers declare nothing of what the archives hold")
    lines = "".join(f"    {symbol};\n" for symbol in shown)
    arguments.output.write_text(f"{arguments.version} {{\n  global:\n{lines}  local: *;\n}};\n")


if __name__ == "__main__":
    main()
