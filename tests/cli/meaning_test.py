# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Inputs that stay well-formed and mean something else. Each change of each format either keeps the meaning, and then the result is
the same, or there is a sentence: an error, or a remark that the unchanged file does not get. What no reader can know is listed, with
the reason. `python3 tests/cli/meaning_test.py --table` tells each verdict and then a table of them, which goes between the marks BEGIN
and END of docs/robustness.md where that page has them; words after it choose formats."""
import concurrent.futures
import itertools
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zlib

import meaning_formats
import support
from meaning_formats import EYES, FIT, FOG, MESH, SCENE, VIEWS, VOLUME, Format

NETCDF = 9.969209968386869e36
FIGURES = "exposure|degrees between lines|support_|seconds"  # in remarks that every run makes: not told about the file
MUTATIONS = ["unit", "order", "fill", "duplicate", "missing", "scale", "sign", "time", "axis", "case", "locale", "encoding", "length", "name"]
PAGE = pathlib.Path(__file__).parents[2] / "docs/robustness.md"
BEGIN, END = "<!-- tests/cli/meaning_test.py writes this table -->\n", "<!-- end of the table -->\n"

# --- changes: family -> function of (bytes, hints) that yields (mutation, label, changed bytes, whether the meaning is kept, or None: the file says
# something else, and the result is that) ---


def encodings(data, byte_order_mark=True):
    text = data.decode()
    if byte_order_mark:
        yield "encoding", "byte order mark", b"\xef\xbb\xbf" + data, True
    yield "encoding", "UTF-16", text.encode("utf-16"), True
    yield "encoding", "line ends of Windows", text.replace("\n", "\r\n").encode(), True


def of_json(data, hints):
    """hints: at (path of the object that is changed), number (a member that is one, or has some), needed, positive, time, text."""
    def changed(change):
        root = json.loads(data)
        target = root
        for step in hints.get("at", ()):
            target = target[step]
        return json.dumps(change(target) or root).encode()

    def put(key, value, old=None):
        def change(target):
            if old:
                del target[old]
            target[key] = value
        return changed(change)

    def reordered(value):
        if isinstance(value, dict):
            return {key: reordered(one) for key, one in reversed(value.items())}
        return [reordered(one) for one in value] if isinstance(value, list) else value

    root = json.loads(data)
    target = root
    for step in hints.get("at", ()):
        target = target[step]
    key = hints["number"]
    value = target[key]
    first = value[0] if isinstance(value, list) else value
    within = (lambda new: [new] + value[1:]) if isinstance(value, list) else (lambda new: new)
    yield "order", "members reversed", json.dumps(reordered(root)).encode(), True
    for label, new in (("cm after the name", key + "_cm"), ("[cm] after the name", key + " [cm]")):
        yield "unit", label, put(new, value, key), False
    yield "unit", "a unit in the value", put(key, within(f"{first} m")), False
    for label, new in (("null", None), ("NaN", float("nan")), ("Infinity", float("inf")), ("of netCDF", NETCDF)):
        yield "fill", label, put(key, within(new)), False
    yield "duplicate", "the member twice", put("@", value).replace(b'"@"', json.dumps(key).encode()), False
    if "needed" in hints:
        yield "missing", "without " + hints["needed"], changed(lambda t: t.pop(hints["needed"]) and None), False
    yield "scale", "mm", put(key, [1000 * x for x in value] if isinstance(value, list) else 1000 * value), False
    if hints.get("positive"):
        yield "sign", "negative", put(key, [-x for x in value] if isinstance(value, list) else -value), False
    if "time" in hints:
        yield "time", "a time as text", put(hints["time"], "10 s"), False
        yield "time", "milliseconds in the name", put(hints["time"] + "_ms", 10), False
    if isinstance(value, list):
        yield "axis", "the other way round", put(key, value[::-1]), False
        yield "length", "one too few", put(key, value[:-1]), False
        yield "length", "one too many", put(key, value + [1]), False
    yield "case", "the name in capitals", put(key.upper(), value, key), False
    yield "locale", "a decimal comma", put(key, within(str(float(first)).replace(".", ","))), False
    yield from encodings(json.dumps(root, indent=1).encode())
    yield "name", "another member", put("no_such_member", 1), False
    if "text" in hints:
        yield "name", "control characters", put(hints["text"], "a\x1b[31m\x07"), None
        yield "name", "300 letters", put(hints["text"], "x" * 300), None


def of_csv(data, hints):
    """hints: length, time: columns of a length and of a time; needed."""
    rows = [line.split(",") for line in data.decode().split()]
    names, cells = rows[0], rows[1:]

    def table(names, cells, comma=","):
        return "".join(comma.join(row) + "\n" for row in [names] + cells).encode()

    def column(name, new_name, change):
        at = names.index(name)
        return table([new_name if i == at else n for i, n in enumerate(names)],
                     [[change(cell) if i == at else cell for i, cell in enumerate(row)] for row in cells])

    length = hints.get("length", "x")
    for label, new in (("[cm]", f"{length} [cm]"), ("/mm", f"{length}/mm"), ("(ft)", f"{length} (ft)")):
        factor = {"[cm]": 100, "/mm": 1000, "(ft)": 1 / 0.3048}[label]
        yield "unit", label, column(length, new, lambda cell: repr(float(cell) * factor)), True
    yield "unit", "[furlong]", column(length, f"{length} [furlong]", str), False
    yield "order", "columns reversed", table(names[::-1], [row[::-1] for row in cells]), True
    for label, new in (("nan", "nan"), ("empty", ""), ("of netCDF", str(NETCDF)), ("***", "***"), ("1.0-101 of Fortran", "1.0-101")):
        yield "fill", label, table(names, [[new if n == length else c for n, c in zip(names, cells[0])]] + cells[1:]), None if "-" in new else False
    yield "duplicate", "the column twice", table(names + [length], [row + ["0.5"] for row in cells]), False
    needed = hints.get("needed", "y")
    at = names.index(needed)
    yield "missing", "without " + needed, table(names[:at] + names[at + 1:], [row[:at] + row[at + 1:] for row in cells]), False
    yield "scale", "mm", column(length, length, lambda cell: repr(1000 * float(cell))), False
    if "positive" in hints:
        yield "sign", "negative", column(hints["positive"], hints["positive"], lambda cell: "-" + cell), False
    if "time" in hints:
        yield "time", "[min]", column(hints["time"], hints["time"] + " [min]", lambda cell: repr(float(cell) / 60)), True
        yield "time", "[ms]", column(hints["time"], hints["time"] + " [ms]", lambda cell: repr(1000 * float(cell))), True
        yield "time", "[fortnight]", column(hints["time"], hints["time"] + " [fortnight]", str), False
        yield "time", "going back", table(names, cells[::-1]), True
    yield "axis", "two names exchanged", table([{"x": "y", "y": "x", "x0": "y0", "y0": "x0"}.get(n, n) for n in names], cells), False
    yield "case", "names in capitals", table([n.upper() for n in names], cells), True
    yield "locale", "semicolons and decimal commas", table(names, cells, ";").replace(b".", b","), True
    if b"." in data:
        yield "locale", "decimal commas alone", data.replace(b".", b","), False
    yield from encodings(data)
    yield "length", "a cell too few", table(names, [cells[0][:-1]] + cells[1:]), False
    yield "length", "a cell too many", table(names, [cells[0] + ["1"]] + cells[1:]), False
    yield "name", "an unknown column", table(names + ["colour"], [row + ["1"] for row in cells]), False
    yield "name", "a near name", column(length, length + length[-1], str), False


def of_text(data, hints):
    """hints: for each mutation (label, old, new, kept); `old` is a regular expression, `new` its replacement or a function."""
    text = data.decode()
    for mutation, changes in hints.items():
        for label, old, new, kept in changes:
            changed, count = re.subn(old, new, text, flags=re.S)
            assert count and changed != text, (mutation, label, old)
            yield mutation, label, changed.encode(), kept
    yield from encodings(data, byte_order_mark=hints.get("mark", True))


def of_bytes(data, hints):
    for mutation, changes in hints.items():
        for label, change, kept in changes:
            changed = change(data)
            assert changed != data, (mutation, label)
            yield mutation, label, changed, kept


FAMILIES = {"json": of_json, "csv": of_csv, "text": of_text, "bytes": of_bytes}


def npy(old, new):
    """A change of the header that keeps its length."""
    return lambda data: data.replace(old.encode(), new.encode().ljust(len(old)), 1)


def chunk(kind, body):
    piece = len(body).to_bytes(4, "big") + kind + body
    return lambda data: data[:33] + piece + zlib.crc32(piece[4:]).to_bytes(4, "big") + data[33:]


def fortran(data):
    cells = [data[128 + 4 * i:132 + 4 * i] for i in range(360)]
    place = lambda t, z, y, x: cells[((t * 4 + z) * 5 + y) * 6 + x]
    body = b"".join(place(t, z, y, x) for x in range(6) for y in range(5) for z in range(4) for t in range(3))
    return npy("'fortran_order': False", "'fortran_order': True")(data[:128]) + body


def big_endian(data):
    return npy("<f4", ">f4")(data[:128]) + b"".join(data[i:i + 4][::-1] for i in range(128, len(data), 4))


def swap(old, new):
    return lambda data: data.replace(old, new)


VTU = {
    "unit": [("a unit in the field's name", 'Name="smoke"', 'Name="smoke [mg/m3]"', False)],
    "fill": [("nan", r'(Name="smoke"[^>]*>)\S+', r"\1nan", False), ("-9999", r'(Name="smoke"[^>]*>)\S+', r"\g<1>-9999", False),
             ("of netCDF", r'(Name="smoke"[^>]*>)\S+', rf"\g<1>{NETCDF}", False)],
    "duplicate": [("the field twice", r'(<DataArray type="Float32" Name="smoke".*?</DataArray>)', lambda m: m[1] + m[1].replace("0.", "7."), False)],
    "missing": [("the field", r'<DataArray type="Float32" Name="smoke".*?</DataArray>', "", False)],
    "sign": [("negative", r'(Name="smoke"[^>]*>)(\S+)', r"\1-\2", False)],
    "case": [("the field in capitals", 'Name="smoke"', 'Name="SMOKE"', False), ("the grid's kind", "UnstructuredGrid", "unstructuredgrid", False)],
    "locale": [("decimal commas", r"(\d)\.(\d)", r"\1,\2", False)],
    "length": [("a value too few", r'(Name="smoke"[^>]*>)\S+ ', r"\1", False), ("a value too many", r'(Name="smoke"[^>]*>)', r"\g<1>1 ", False)],
    "order": [("field after the points", r"(<PointData.*?</PointData>)\n(<Points>.*?</Points>)", r"\2\n\1", True)],
    "name": [("no name", 'Name="smoke"', 'Name=""', False)],
}
PVD = {
    "unit": [("a unit in a time", 'timestep="10"', 'timestep="10 s"', False)],
    "order": [("files reversed", r"(<DataSet[^\n]*\n)(<DataSet[^\n]*\n)(<DataSet[^\n]*\n)", r"\3\2\1", True)],
    "fill": [("a time of nan", 'timestep="10"', 'timestep="nan"', False), ("a time of netCDF", 'timestep="20"', f'timestep="{NETCDF}"', False)],
    "duplicate": [("a time twice", 'timestep="10"', 'timestep="0"', False), ("a file twice", 'file="r1', 'file="r2', False)],
    "missing": [("a time", 'timestep="10" ', "", False), ("a file", 'file="r1', 'file="r9', False)],
    "time": [("another order than the files", 'timestep="20"', 'timestep="5"', None)],
    "case": [("a file in capitals", "r1.vtu", "R1.VTU", True)],
    "locale": [("a decimal comma", 'timestep="10"', 'timestep="10,0"', False)],
    "name": [("backslashes", 'file="r1', r'file=".\\r1', True), ("by another folder", 'file="r1', 'file="../base/r1', True)],
}
VTI = {
    "unit": [("a unit in the array's name", 'Name="density"', 'Name="density [g]"', False)],
    "order": [("field data last", r"(<FieldData>.*?</FieldData>)\n(<Piece.*?</Piece>)", r"\2\n\1", True)],
    "fill": [("nan", r'(Name="density"[^>]*>)\S+', r"\1nan", False), ("of netCDF", r'(Name="density"[^>]*>)\S+', rf"\g<1>{NETCDF}", False)],
    "duplicate": [("the array twice", r'(<DataArray type="Float32".*?</DataArray>)', r"\1\1", False), ("the piece twice", r"(<Piece.*?</Piece>)", r"\1\1", False)],
    "missing": [("the array", r'<DataArray type="Float32".*?</DataArray>', "", False)],
    "scale": [("a spacing of 0", 'Spacing="0.5', 'Spacing="0', False), ("another spacing than the first frame's", 'Spacing="0.5 0.5 0.5"', 'Spacing="500 500 500"', False)],
    "sign": [("a negative spacing", 'Spacing="0.5', 'Spacing="-0.5', False)],
    "time": [("none", r"<FieldData>.*?</FieldData>\n", "", False), ("going back", r'(format="ascii">)2(<)', r"\g<1>9\2", False)],
    "axis": [("a direction", 'Spacing=', 'Direction="0 1 0 1 0 0 0 0 1" Spacing=', False)],
    "case": [("the array in capitals", 'Name="density"', 'Name="DENSITY"', False)],
    "locale": [("decimal commas", r"(\d)\.(\d)", r"\1,\2", False)],
    "length": [("a value too few", r'(Name="density"[^>]*>)\S+ ', r"\1", False), ("a smaller piece", 'Piece Extent="0 4', 'Piece Extent="0 3', False)],
    "name": [("no name", 'Name="density"', 'Name=""', False)],
}
SMV = {
    "unit": [("extinction in 1/cm", "\n 1/m", "\n 1/cm", False)],
    "order": [("slices before the grid", r"(GRID.*?VENT\n 0 0\n)(.*?)(INPF)", r"\2\1\3", False)],
    "fill": [("stars", r"(PDIM\n )0.00000", r"\1*******", False), ("nan", r"(PDIM\n )0.00000", r"\1nan", False)],
    "duplicate": [("the grid twice", r"(GRID.*?VENT\n 0 0\n)", r"\1\1", False), ("the slice twice", r"(SLCC.*?1/m\n)", r"\1\1", True)],
    "missing": [("the planes of z", r"TRNZ.*?\n\n", "", False), ("the slice's file", "hall_1_1.sf", "hall_9.sf", False)],
    "scale": [("a box in mm", r"PDIM\n 0.00000 8.00000", "PDIM\n 0.00000 8000.0", False)],
    "sign": [("a box the other way", r"PDIM\n 0.00000 8.00000", "PDIM\n 8.00000 0.00000", False)],
    "axis": [("cells exchanged", "8 4 3 0", "4 8 3 0", False)],
    "case": [("the file in capitals", "hall_1_1.sf", "HALL_1_1.SF", True)],
    "locale": [("decimal commas", r"(\d)\.(\d)", r"\1,\2", False)],
    "length": [("a plane too few", r"\n 8 8.00000", "", False)],
    "name": [("backslashes", " hall_1_1.sf", r" .\\hall_1_1.sf", True)],
}
DEVC = {
    "unit": [("K", "s,C", "s,K", None), ("F", "s,C", "s,F", None), ("no unit", "s,C", "s,", True), ("furlongs", "s,C", "s,furlong", False)],
    "order": [("columns reversed", r"(.*?),(.*?)\n(.*?),(.*?)\n(.*?),(.*?)\n(.*?),(.*?)\n(.*?),(.*?)\n", r"\2,\1\n\4,\3\n\6,\5\n\8,\7\n\10,\9\n", True)],
    "fill": [("NaN", "10,50", "10,NaN", False), ("stars", "10,50", "10,*****", False), ("below absolute zero", "10,50", "10,-999", False), ("a Fortran exponent", "10,50", "10,5.0+001", True)],
    "duplicate": [("the device twice", r'"T1"\n0,20\n10,50\n20,90', '"T1","T1"\n0,20,1\n10,50,1\n20,90,1', False)],
    "missing": [("the time", '"Time"', '"Tim"', False), ("the rows", "0,20.*", "", False)],
    "time": [("going back", "20,90", "5,90", False), ("minutes", "s,C", "min,C", None), ("fortnights", "s,C", "fortnight,C", False)],
    "case": [("names in capitals", '"Time","T1"', '"TIME","t1"', True)],
    "locale": [("semicolons and commas", r"s,C\n(.*),(.*)\n0,20\n10,50\n20,90", r"s;C\n\1;\2\n0;20\n10;50,0\n20;90,0", True)],
    "length": [("a cell too few", "10,50", "10", False), ("a cell too many", "10,50", "10,50,5", False), ("the end of the last line", "0\n$", "", False)],
    "name": [("another device", '"T1"', '"T2"', False)],
}
FOAM = {
    "unit": [("kg/m3", r"\[0 -1 0", "[1 -3 0", False), ("no dimensions", r"dimensions[^;]*;\n", "", False)],
    "scale": [("a reference level", "internalField", "referenceLevel 5;\ninternalField", False)],
    "fill": [("nan", r"1\(0", "1(nan", False), ("stars", r"1\([^)]*", "1(***", False)],
    "duplicate": [("the field twice", r"(internalField[^;]*;)", lambda m: m[1] + "\n" + m[1].replace("(0", "(7"), None)],  # the last one counts, as in OpenFOAM
    "missing": [("the field", r"internalField[^;]*;\n", "", False)],
    "sign": [("negative", r"1\(0", "1(-0", False)],
    "case": [("a key", "internalField", "internalfield", False)],
    "locale": [("a decimal comma", r"(\d)\.(\d+)\)", r"\1,\2)", False)],
    "length": [("two of one", r"1\(", "2(", False), ("more than it says", r"1\((\S+)\)", r"1(\1 \1)", False)],
    "name": [("another class", "volScalarField", "volVectorField", False)],
}
CASE = {
    "unit": [("a unit in a time", "0 10 20", "0 s 10 s 20 s", False)],
    "order": [("time before the variables", r"(VARIABLE.*?)\n(TIME.*)", r"\2\n\1", True)],
    "fill": [("a time of nan", "0 10 20", "0 nan 20", False), ("stars", "0 10 20", "0 ** 20", False)],
    "duplicate": [("the variable twice", r"(scalar per node[^\n]*\n)", r"\1\1", True), ("a time twice", "0 10 20", "0 10 10", False)],
    "missing": [("the files' numbers", r"filename start number: 0\n", "", False), ("the geometry", r"model: e.geo\n", "", False)],
    "time": [("going back", "0 10 20", "0 20 10", False)],
    "case": [("a file in capitals", "e.geo", "E.GEO", True)],
    "locale": [("decimal commas", "0 10 20", "0 10,0 20,0", False)],
    "length": [("a time too few", "0 10 20", "0 10", False)],
    "name": [("backslashes", "model: e.geo", r"model: .\\e.geo", True)],
}
OBJ = {
    "unit": [("a comment that says mm", "mtllib", "# File units = millimeters\nmtllib", False)],
    "order": [("material after the face", r"(usemtl red\n)(f [^\n]*\n)", r"\2\1", None)],
    "fill": [("nan", "v 0 3 0", "v nan 3 0", False), ("inf", "v 0 3 0", "v inf 3 0", False)],
    "duplicate": [("a corner twice", "f 1 2", "f 1 1 2", True)],
    "missing": [("the faces", "f [^\n]*\n", "", False), ("a vertex", "v 0 3 3\n", "", False)],
    "sign": [("corners from the end", "f 1 2 3 4 5 6", "f -6 -5 -4 -3 -2 -1", True)],
    "case": [("capitals", "v 0 3 0", "V 0 3 0", False)],
    "locale": [("decimal commas", "v 0 3 0", "v 0,0 3,0 0,0", False)],
    "scale": [("a curve", "usemtl red", "curv 0 1 1 2 3\nusemtl red", False)],
    "length": [("two coordinates", "v 0 3 0", "v 0 3", False), ("a word more", "v 0 3 0", "v 0 3 0 junk", False),
               ("a face of two", "f 1 2 3 4 5 6", "f 1 2", False)],
    "name": [("an unknown statement", "usemtl red", "usemtll red", False), ("by another folder", "mtllib wall", "mtllib ../base/wall", True)],
}
MTL = {
    "order": [("a colour before its material", r"(newmtl red\n)(Kd [^\n]*\n)", r"\2\1", False)],
    "missing": [("the colour", r"Kd [^\n]*\n", "Ka 0 0 0\n", False)],
    "unit": [("a picture for a colour", "Kd 0.8 0.2 0.1", "map_Kd red.png", False), ("a dissolve", "Kd", "d 0.2\nKd", False)],
    "fill": [("nan", "Kd 0.8", "Kd nan", False)],
    "duplicate": [("a colour twice", "Kd 0.8 0.2 0.1\n", "Kd 0.8 0.2 0.1\nKd 0 0 1\n", False), ("the material twice", "(newmtl.*)", r"\1newmtl red\nKd 0 0 1\n", False)],
    "sign": [("negative", "Kd 0.8", "Kd -0.8", False)],
    "scale": [("bytes", "Kd 0.8 0.2 0.1", "Kd 204 51 25", False)],
    "case": [("capitals", "Kd", "KD", True)],
    "locale": [("decimal commas", r"0\.", "0,", False)],
    "length": [("two shares", "Kd 0.8 0.2 0.1", "Kd 0.8 0.2", False), ("four shares", "Kd 0.8 0.2 0.1", "Kd 0.8 0.2 0.1 0.5", False)],
    "name": [("a near name", "Kd", "Kdd", False), ("another material", "newmtl red", "newmtl Red", False), ("none", "newmtl red", "newmtl blue", False)],
}
COLMAP_CAMERAS = {
    "order": [("lines reversed", r"(# cameras\n)(.*?\n)(.*?\n)(.*?\n)(.*?\n)(.*?\n)", r"\1\6\5\4\3\2", True)],
    "fill": [("nan", r"(1 PINHOLE \d+ \d+) \S+", r"\1 nan", False)],
    "duplicate": [("a camera twice", r"(1 PINHOLE[^\n]*\n)", lambda m: m[1] + m[1].replace(" 42 ", " 99 "), False)],
    "missing": [("a camera", r"1 PINHOLE[^\n]*\n", "", False)],
    "sign": [("a negative focal length", r"(1 PINHOLE \d+ \d+) ", r"\1 -", False)],
    "scale": [("a picture of no size", r"1 PINHOLE \d+", "1 PINHOLE 0", False), ("a focal length in mm", r"(1 PINHOLE \d+ \d+) \S+ \S+", r"\1 3.5 3.5", False)],
    "case": [("the model in small letters", "1 PINHOLE", "1 pinhole", False)],
    "locale": [("decimal commas", r"(\d)\.(\d)", r"\1,\2", False)],
    "length": [("a parameter too few", r"(1 PINHOLE[^\n]*) \S+\n", r"\1\n", False), ("one too many", r"(1 PINHOLE[^\n]*)\n", r"\1 0\n", False)],
    "name": [("another model", "1 PINHOLE", "1 PINHOLES", False)],
}
COLMAP_IMAGES = {
    "order": [("images reversed", r"(# images\n)(.*?\n\n)(.*?\n\n)(.*?\n\n)(.*?\n\n)(.*?\n\n)", r"\1\6\5\4\3\2", True)],
    "fill": [("nan", r"(\n1) \S+", r"\1 nan", False)],
    "duplicate": [("an image twice", r"(\n1 [^\n]*\n)", r"\1\1", True)],
    "missing": [("the camera's number", r"(\n1 [^\n]*) 1 (\S+\n)", r"\1 \2", False), ("the empty lines", r"\n\n", "\n", True)],
    "scale": [("no unit quaternion", r"(\n1) \S+ \S+ \S+ \S+", r"\1 9 9 9 9", False), ("a quaternion of 0", r"(\n1) \S+ \S+ \S+ \S+", r"\1 0 0 0 0", False)],
    "locale": [("decimal commas", r"(\d)\.(\d)", r"\1,\2", False)],
    "length": [("a number too few", r"(\n1) \S+", r"\1", False)],
    "name": [("another camera", r"(\n1 [^\n]*) 1 (\S+\n)", r"\1 77 \2", False)],
}
YAML = {
    "unit": [("integers that are none", "dt: d", "dt: i", False), ("a member that says mm", r"---\n", "---\nunits: mm\n", False)],
    "order": [("matrices reversed", r"(%YAML:1.0\n---\n)(K_north.*?)(K_c1.*)", r"\1\3\2", True)],
    "fill": [("nan", r"(R_north.*?data: \[) \S+,", r"\1 .nan,", False)],
    "duplicate": [("a matrix twice", r"(R_north.*?\n)(T_north)", r"\1\1\2", False)],
    "missing": [("R", r"R_north.*?(T_north)", r"\1", False)],
    "scale": [("R in degrees", r"(R_north.*?data: \[)[^]]*", r"\1 0, 90, 0, 90, 0, 0, 0, 0, 90", False)],
    "sign": [("a mirror", r"(R_north.*?data: \[) (-?)", lambda m: m[1] + (" " if m[2] else " -"), False)],
    "case": [("a name in capitals", "R_north", "R_NORTH", False)],
    "locale": [("decimal commas", r"(\d)\.(\d)", r"\1,\2", False)],
    "length": [("a value too few", r"(R_north.*?data: \[) \S+,", r"\1", False), ("rows that do not fit", r"(R_north.*?rows:) 3", r"\1 4", False)],
    "name": [("another member", r"---\n", "---\ncolour: 7\n", True)],
}
FDS = {
    "unit": [("a unit in a value", "T_END=20.", "T_END='20 min'", True)],
    "fill": [("stars", "T_END=20.", "T_END=****", True)],
    "case": [("small letters", "&MISC|&MESH", "&mesh", True)],
    "name": [("an unknown group", "&TAIL", "&XYZW A=1 /\n&TAIL", True)],
    "order": [("groups reversed", r"(&HEAD[^\n]*\n)(&MESH[^\n]*\n)", r"\2\1", True)],
    "scale": [("another factor", "&TIME", "&MISC VISIBILITY_FACTOR=8 /\n&TIME", True)],
}
SIGNS = {
    "unit": [("a unit for all", '{"signs"', '{"unit": "cm", "signs"', False)],
    "fill": [("beyond double", "7[.]9", "1e999", False)],
    "duplicate": [("the list twice", '{"signs"', '{"signs": [], "signs"', False)],
    "missing": [("the list", '{"signs": ', "", False)],
    "case": [("the name in capitals", "signs", "Signs", False)],
    "length": [("no sign", r'\[{.*}\]', "[]", False)],
    "name": [("another member", '{"signs"', '{"sign": [], "signs"', False)],
    "order": [("more behind a NUL", r"$", '\0{"signs": []}', False)],
}
SCALES = {  # FDS's input where it says what stored values mean
    "unit": [("a unit in a value", "R=8.", "R='8 m'", False)],
    "order": [("= on a line of its own", "R=8.", "R ! of signs\n  =\n  8.", True), ("keys exchanged", "TMPA=20., (V[^ ]*) ", r"\1, TMPA=20. ", True)],
    "fill": [("stars", "R=8.", "R=****", False)],
    "duplicate": [("an earlier value", "VIS", "VISIBILITY_FACTOR=3., VIS", True), ("an earlier group", "&MISC", "&MISC VISIBILITY_FACTOR=3. /\n&MISC", True)],
    "missing": [("the factor", ", V[^ ]*", "", False), ("the file that CATF names", "&TAIL", "&CATF OTHER_FILES='more.fds' /\n&TAIL", False)],
    "scale": [("another factor", "R=8.", "R=3.", False), ("a device's difference to its first value", "XYZ", "RELATIVE=T, XYZ", None)],
    "sign": [("negative", "R=8.", "R=-8.", False)],
    "case": [("small letters", "&MISC TMPA=20., VISIBILITY_FACTOR", "&misc tmpa=20., visibility_factor", True)],
    "locale": [("an exponent with D", "R=8.", "R=.8D1", True)],
    "name": [("another CHID", "CHID='hall'", "CHID='room'", False), ("in a comment", "&MISC", "!&MISC", False)],
}
NPY = {
    "order": [("Fortran's order", fortran, True), ("big-endian", big_endian, True)],
    "fill": [("nan", lambda d: d[:-4] + b"\0\0\xc0\x7f", False), ("inf", lambda d: d[:-4] + b"\0\0\x80\x7f", False),
             ("of netCDF", lambda d: d[:-4] + b"\0\0\xf0\x7c", False), ("-9999", lambda d: d[:-4] + b"\0\x3c\x1c\xc6", False)],
    "duplicate": [("the shape twice", lambda d: d[:8] + b"\x76\0" + d[10:128].replace(b"}", b"'shape': (3, 4, 5, 6)}", 1)[:118] + d[128:], False)],
    "missing": [("the shape", npy("'shape': (3, 4, 5, 6)", ""), False)],
    "axis": [("axes exchanged", npy("(3, 4, 5, 6)", "(3, 6, 5, 4)"), False), ("two axes", npy("(3, 4, 5, 6)", "(18, 20)"), False)],
    "case": [("False in small letters", npy("False", "false"), False)],
    "length": [("a value too few", lambda d: d[:-4], False), ("a value too many", lambda d: d + d[-4:], False)],
    "name": [("complex", npy("'<f4'", "'<c8'"), False), ("text", npy("'<f4'", "'<U1'"), False)],
}
def nc(**said):
    return lambda data: meaning_formats.netcdf(**said)


def scaled(factor, axes="x"):
    return {axis: [factor * (0.25 + 0.5 * i) for i in range(6)][:dict(z=4, y=5, x=6).get(axis, 3)] for axis in axes}


ABOVE = {"z": [1.75 - 0.5 * i for i in range(4)]}
NC = {
    "unit": [("places in cm", nc(units=dict(x="cm", y="cm", z="cm"), places=scaled(100, "xyz")), True),
             ("in furlongs", nc(units=dict(x="furlong")), False), ("times in minutes", nc(units=dict(t="minutes since 2020-01-01"),
              places={"t": [0.0, 2 / 60, 4 / 60]}), True), ("times of fortnights", nc(units=dict(t="fortnights")), False),
             ("degrees", nc(units=dict(x="degrees_east", y="degrees_north")), False),
             ("places in nothing", nc(units=dict(x="", y="", z="")), False), ("times in nothing", nc(units=dict(t="")), False),
             ("places in feet", nc(units=dict(x="ft", y="feet", z="ft"), places=scaled(1 / 0.3048, "xyz")), True),
             ("places in percent", nc(units=dict(x="percent")), False), ("numbers in percent", nc(units=dict(s="%")), None),
             ("Units of cm in capitals", lambda data: nc(units=dict(x="cm", y="cm", z="cm"), places=scaled(100, "xyz"))(data).replace(b"units", b"Units"), True)],
    "order": [("x first", nc(order="xyzt"), True), ("time last", nc(order="zyxt"), True), ("z from above", nc(places=ABOVE), None)],
    "fill": [("of netCDF", nc(change=lambda v: [NETCDF] + v[1:]), False), ("_FillValue", nc(change=lambda v: [-9999] + v[1:], extra=[("_FillValue", ("f", [-9999.0]))]), False),
             ("missing_value", nc(change=lambda v: [-9999] + v[1:], extra=[("missing_value", ("f", [-9999.0]))]), False),
             ("two missing values", nc(change=lambda v: [-8888, -9999] + v[2:], extra=[("missing_value", ("f", [-9999.0, -8888.0]))]), False),
             ("beyond valid_range", nc(change=lambda v: [500.0] + v[1:], extra=[("valid_range", ("f", [0.0, 10.0]))]), False),
             ("beyond valid_max", nc(change=lambda v: [500.0] + v[1:], extra=[("valid_max", ("f", [10.0]))]), False),
             ("nan", nc(change=lambda v: [float("nan")] + v[1:]), False)],
    "duplicate": [("another array", nc(more=["other"]), False), ("an axis twice", nc(names=dict(y="X")), False)],
    "missing": [("the coordinate x", nc(left_out="x"), None), ("the times", nc(left_out="t"), None), ("names of axes", nc(names=dict(z="a", y="b", x="c")), False)],
    "scale": [("packed", nc(kind="h", change=lambda v: [round(1000 * one) for one in v], extra=[("scale_factor", ("d", [0.001]))]), True),
              ("packed with an offset", nc(kind="h", change=lambda v: [round(1000 * one) - 700 for one in v],
               extra=[("scale_factor", ("d", [0.001])), ("add_offset", ("d", [0.7]))]), True),
              ("places in mm that do not say so", nc(places=scaled(1000, "xyz")), False), ("a factor of 0", nc(extra=[("scale_factor", ("d", [0.0]))]), False),
              ("SCALE_FACTOR in capitals", nc(kind="h", change=lambda v: [round(1000 * one) for one in v], extra=[("SCALE_FACTOR", ("d", [0.001]))]), True),
              ("a factor of text", nc(extra=[("scale_factor", ("c", "0.001"))]), False),
              ("two factors", nc(extra=[("scale_factor", ("d", [0.001, 0.002]))]), False)],
    "sign": [("unsigned", nc(kind="h", change=lambda v: [round(50000 * one) - 65536 * (one > 0.65535) for one in v],
             extra=[("scale_factor", ("d", [2e-5])), ("_Unsigned", ("c", "true"))]), True)],
    "time": [("going back", nc(places={"t": [0.0, 4.0, 2.0]}), False), ("a time twice", nc(places={"t": [0.0, 2.0, 2.0]}), False)],
    "axis": [("uneven places", nc(places={"x": [0.25, 0.75, 1.25, 1.75, 2.25, 9.0]}), False), ("places of 0", nc(places={"x": [0.0] * 6}), False)],
    "case": [("names in capitals", nc(names=dict(t="TIME", z="Z", y="Y", x="X")), True), ("Height for z", nc(names=dict(z="Height")), True)],
    "length": [("cut off", lambda d: d[:-9], False), ("bytes behind", lambda d: d + b"more", True)],
    "name": [("another name of the array", nc(names=dict(s="rauch")), True), ("300 letters", nc(names=dict(s="s" * 300)), None)],
}
PNG = {
    "unit": [("linear by gAMA", chunk(b"gAMA", (100000).to_bytes(4, "big")), None), ("a curve of video by cICP", chunk(b"cICP", bytes([9, 16, 0, 1])), False)],
    "fill": [("a transparent colour", chunk(b"tRNS", bytes([0, 50, 0, 50, 0, 50])), None)],
    "duplicate": [("gAMA twice", lambda d: chunk(b"gAMA", (100000).to_bytes(4, "big"))(chunk(b"gAMA", (45455).to_bytes(4, "big"))(d)), False)],
    "missing": [("the data", lambda d: d.replace(b"IDAT", b"idAT"), False)],
    "length": [("cut off", lambda d: d[:-20], False), ("bytes behind", lambda d: d + b"more", True)],
    "name": [("an unknown critical chunk", chunk(b"VLTE", b"x"), False)],
}
EXR = {
    "fill": [("nan", lambda d: d[:-4] + b"\0\0\xc0\x7f", False)],
    "missing": [("a channel's name", swap(b"G\0\2\0", b"H\0\2\0"), False)],
    "case": [("channels in small letters", swap(b"R\0\2\0", b"r\0\2\0"), False)],
    "length": [("a line too few", lambda d: d[:-150], False)],
    "scale": [("an aspect of 0", swap(b"float\0\4\0\0\0\0\0\x80\x3f", b"float\0\4\0\0\0\0\0\0\0"), False),
              ("an aspect of 2", swap(b"float\0\4\0\0\0\0\0\x80\x3f", b"float\0\4\0\0\0\0\0\0\x40"), False)],
    "axis": [("lines from below", swap(b"lineOrder\0lineOrder\0\1\0\0\0\0", b"lineOrder\0lineOrder\0\1\0\0\0\1"), True)],
}


def data_window(data):
    """The depths of the right half alone: what is left of it has none."""
    at = data.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
    return data[:at] + (6).to_bytes(4, "little") + data[at + 4:]


DEPTH = {
    "unit": [("0 to 1", lambda d: d[:-400] + bytes(400), False)],
    "fill": [("nan", lambda d: d[:-4] + b"\0\0\xc0\x7f", False)],
    "sign": [("negative", lambda d: d[:-1] + bytes([d[-1] | 0x80]), False)],
    "missing": [("the channel's name", swap(b"Z\0\2\0", b"Q\0\2\0"), False)],
    "case": [("a small letter", swap(b"Z\0\2\0", b"z\0\2\0"), False)],
    "length": [("a line too few", lambda d: d[:-56], False)],
}
VOLUTE = {
    "fill": [("a changed byte", lambda d: d[:-40] + bytes([d[-40] ^ 1]) + d[-39:], False)],
    "length": [("cut off", lambda d: d[:-9], False), ("bytes behind", lambda d: d + b"more", False)],
    "name": [("another version", lambda d: d[:10] + bytes([99]) + d[11:], False)],
}
VDB = {"fill": [("a changed byte", lambda d: d[:-400] + bytes([d[-400] ^ 1]) + d[-399:], False)],
       "length": [("cut off", lambda d: d[:-9], False)],
       "name": [("another grid's name", lambda d: d.replace(b"density", b"Density"), False), ]}
SLICE = {
    "unit": [("1/cm in the file", swap(b"1/m ", b"1/cm"), False)],
    "fill": [("nan", lambda d: d[:-8] + b"\0\0\xc0\x7f" + d[-4:], False), ("-1", lambda d: d[:-8] + b"\0\0\x80\xbf" + d[-4:], False)],
    "time": [("going back", lambda d: d.replace(b"\0\0\x20\x41", b"\0\0\xc8\x42", 1), False)],
    "length": [("cut off", lambda d: d[:-9], False), ("more cells", lambda d: d.replace(b"\x08\0\0\0\0\0\0\0\x04", b"\x09\0\0\0\0\0\0\0\x04", 1), False)],
    "name": [("another quantity", swap(b"SOOT EXTINCTION", b"SOOT DENSITY   "), False)],
}

SIGN = {"at": ("signs", 0), "number": "position", "needed": "position", "text": "name"}
def gltf(old, new):
    return lambda data: data.replace(old.encode(), new.encode(), 1)


GLTF = [("unit", "a version of its own", gltf('"version": "2.0"', '"version": "1.0"'), False),
        ("missing", "a number of its place", gltf("[1.0, 0.5, -2.0]", "[1.0, 0.5]"), False),
        ("duplicate", "a matrix beside its place", gltf('"mesh": 0,', '"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1],'), False),
        ("length", "instances", gltf('"mesh": 0,', '"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}},'), False)]

FORMATS = [
    Format("signs.json: the list", "text", "room", "signs.json", EYES.format("hall.smv"), "out/sight.csv", SIGNS),
    Format("signs.json", "json", "room", "signs.json", EYES.format("hall.smv"), "out/sight.csv", SIGN),
    Format("criteria.json", "json", "room", "criteria.json", EYES.format("hall.smv") + " --criteria criteria.json", "out/tenability.csv",
           {"at": ("criteria", 0), "number": "limit", "needed": "kind", "positive": True, "text": "name"}),
    Format("study.json", "json", "room", "study.json", "sweep study.json -o out", "out/study.csv",
           {"at": ("options",), "number": "step", "needed": "signs", "positive": True}),
    Format("eyes.csv", "csv", "room", "eyes.csv", EYES.format("hall.smv"), "out/sight.csv"),
    Format("route.csv", "csv", "room", "route.csv", EYES.replace("--eyes eyes.csv", "--route route.csv --speed 1").format("hall.smv"), "out/sight.csv"),
    Format("trajectories", "csv", "room", "walk.csv", EYES.replace("--eyes eyes.csv", "--trajectories walk.csv --height 1.7").format("hall.smv"), "out/sight.csv",
           {"time": "time", "positive": "time"}),
    Format("required times", "csv", "room", "rset.csv", EYES.replace("--eyes eyes.csv", "--rset rset.csv --height 1.5 --step 2 --maps aset").format("hall.smv"),
           "out/maps.csv", {"time": "rset", "positive": "rset"}),
    Format("FDS index .smv", "text", "room", "hall.smv", EYES.format("hall.smv"), "out/sight.csv", SMV),
    Format("FDS slice .sf", "bytes", "room", "hall_1_1.sf", EYES.format("hall.smv"), "out/sight.csv", SLICE),
    Format("FDS devices", "text", "room", "hall_devc.csv", EYES.format("hall.smv") + " --criteria criteria.json", "out/tenability.csv", DEVC),
    Format("FDS input: scales", "text", "air", "hall.fds", EYES.format("hall.smv"), "out/tenability.csv", SCALES),
    Format("FDS input .fds", "text", "room", "hall.fds", EYES.format("hall.smv"), "out/sight.csv", FDS),
    Format(".vtu", "text", "mesh", "r1.vtu", MESH.format("room.pvd"), "out/sight.csv", VTU),
    Format(".pvd of meshes", "text", "mesh", "room.pvd", MESH.format("room.pvd"), "out/sight.csv", PVD),
    Format("OpenFOAM field", "text", "mesh", "10/K", MESH.format("c.foam"), "out/sight.csv", FOAM),
    Format("EnSight .case", "text", "mesh", "e.case", MESH.format("e.case"), "out/sight.csv", CASE),
    Format(".vti", "text", "volumes", "v_0001.vti", VOLUME.format("v_%04d.vti"), "out.npy", VTI),
    Format(".pvd of volumes", "text", "volumes", "v.pvd", VOLUME.format("v.pvd"), "out.npy",
           {key: [(l, o.replace('"10"', '"2"').replace('"20"', '"4"').replace("r1", "v_0001"), n.replace('"10"', '"2"').replace('"5"', '"1"')
                   .replace("r1", "v_0001").replace("r9", "v_9").replace("R1.VTU", "V_0001.VTI").replace("10", "2"), k)
                  for l, o, n, k in ((l, o.replace("r1.vtu", "v_0001.vti"), n, k) for l, o, n, k in changes)] for key, changes in PVD.items()}),
    Format(".npy", "bytes", "volumes", "a.npy", VOLUME.format("a.npy"), "out.npy", NPY),
    Format(".npz", "bytes", "volumes", "a.npz", VOLUME.format("a.npz"), "out.npy", {"length": [("cut off", lambda d: d[:-9], False)],
           "fill": [("a changed byte", lambda d: d[:201] + bytes([d[201] ^ 64]) + d[202:], False)]}),
    Format("netCDF array", "bytes", "volumes", "a.nc", VOLUME.format("a.nc"), "out.npy", NC),
    Format(".volute", "bytes", "volumes", "a.volute", "extract a.volute -o out.npy", "out.npy", VOLUTE),
    Format(".vdb in a series", "bytes", "volumes", "d_0001.vdb", VOLUME.format("d_%04d.vdb"), "out.npy", VDB),
    Format("scene: camera", "json", "scene", "all.json", SCENE, "out.png", {"at": ("camera",), "number": "eye", "needed": "target"}),
    Format("scene: camera.fov", "json", "scene", "all.json", SCENE, "out.png", {"at": ("camera",), "number": "fov", "needed": "fov", "positive": True},
           [("unit", "radians", lambda d: d.replace(b'"fov": 50', b'"fov": 0.873'), False)]),
    Format("scene: background", "json", "scene", "all.json", SCENE, "out.png", {"number": "background", "needed": "format", "positive": True}),
    Format("scene: geometry", "json", "scene", "all.json", SCENE, "out.png", {"number": "background", "needed": "format"}),
    Format("scene: light", "json", "scene", "all.json", SCENE, "out.png", {"at": ("lights", 0), "number": "direction", "needed": "direction"}),
    Format("scene: radiance", "json", "scene", "all.json", SCENE, "out.png", {"at": ("lights", 0), "number": "radiance", "needed": "kind", "positive": True}),
    Format("scene: volume", "json", "scene", "all.json", SCENE, "out.png",
           {"at": ("media", 0), "number": "extinction", "needed": "file", "positive": True, "time": "time", "text": "file"}),
    Format("scene: fog", "json", "scene", "all.json", SCENE, "out.png",
           {"at": ("media", 1), "number": "cell", "needed": "map", "positive": True, "time": "time"}),
    Format("scene: fog profile", "json", "scene", "all.json", SCENE, "out.png", {"at": ("media", 1, "profile"), "number": "top", "needed": "kind"}),
    Format("scene: smoke", "json", "scene", "all.json", SCENE, "out.png",
           {"at": ("media", 2), "number": "albedo", "needed": "case", "positive": True, "text": "field"}),
    Format("scene: sign", "json", "scene", "all.json", SCENE, "out.png", {"at": ("signs", 0), "number": "size", "needed": "position", "positive": True, "text": "name"}),
    Format(".obj", "text", "scene", "wall.obj", SCENE, "out.png", OBJ),
    Format(".gltf: a node", "json", "scene", "wall.gltf", "render gltf.json -o out.png", "out.png", {"at": ("nodes", 0), "number": "translation"}, GLTF),
    Format(".gltf: a material", "json", "scene", "wall.gltf", "render gltf.json -o out.png", "out.png",
           {"at": ("materials", 0, "pbrMetallicRoughness"), "number": "baseColorFactor", "positive": True}),
    Format(".mtl", "text", "scene", "wall.mtl", SCENE, "out.png", MTL),
    Format("capture.json", "json", "capture", "capture.json", FIT, "out.npy",
           {"number": "frames_per_second", "needed": "cameras", "positive": True, "time": "frames_per_second"}),
    Format("capture.json: volume", "json", "capture", "capture.json", FIT, "out.npy", {"at": ("volume",), "number": "min", "needed": "max"}),
    Format("capture.json: camera", "json", "capture", "capture.json", FIT, "out.npy",
           {"at": ("cameras", 1), "number": "t", "needed": "K", "time": "start_time", "text": "name"}),
    Format("transforms.json", "json", "capture", "transforms.json", VIEWS.format("transforms.json"), "out",
           {"at": ("frames", 1), "number": "fl_x", "needed": "transform_matrix", "positive": True, "time": "time"}),
    Format("COLMAP cameras", "text", "capture", "colmap/cameras.txt", VIEWS.format("colmap"), "out", COLMAP_CAMERAS),
    Format("COLMAP images", "text", "capture", "colmap/images.txt", VIEWS.format("colmap"), "out", COLMAP_IMAGES),
    Format("OpenCV's YAML", "text", "capture", "cameras.yml", VIEWS.format("cameras.yml"), "out", YAML),
    Format("lines of sight", "csv", "lines", "lines.csv", "reconstruct lines.csv -o out.npy --bounds=0,0,0,2,2,2 --resolution 4,4,4", "out.npy",
           {"length": "x0", "needed": "y1", "time": "time", "positive": "transmittance"}),
    Format(".png", "bytes", "stills", "a.png", "compare a.png b.png --json", "", PNG),
    Format(".exr", "bytes", "stills", "a.exr", "compare a.exr b.exr --json", "", EXR),
    Format("depth .exr", "bytes", "stills", "depth.exr", FOG, "out.exr", DEPTH),
    Format("camera.json", "json", "stills", "camera.json", FOG, "out.exr", {"number": "eye", "needed": "target"}),
]

# What no reader can know, and why: (format or family or *, mutation, label or *).
NUMBERS = "a number is what it says, and nothing else contradicts it"
UNKNOWABLE = {
    ("csv", "axis", "*"): "columns are what their names say",
    ("json", "axis", "*"): NUMBERS,
    (".npy", "axis", "*"): "axes have no names; a square array looks the same either way",
    (".npy", "fill", "-9999"): "-9999 may be a value; the range is printed",
    ("criteria.json", "scale", "*"): "the limit is printed with the verdict",
    ("criteria.json", "fill", "*"): "the limit is printed with the verdict",
    ("scene: light", "scale", "*"): "a direction has no length",
    ("netCDF array", "scale", "places in mm that do not say so"): NUMBERS,
    (".vti", "scale", "another spacing than the first frame's"): "each frame may have a lattice of its own",
    (".vti", "axis", "a direction"): "each frame may have a lattice of its own",
    ("json", "scale", "*"): NUMBERS,
    ("lines of sight", "scale", "*"): "lines may begin and end anywhere around the volume",
    ("capture.json", "fill", "null"): "null is a member that is not stated",
    ("lines of sight", "time", "going back"): "the order of lines decides which are held out, and so the smoothness that is chosen",
    (".vtu", "length", "a value too many"): "VTK's readers take as many numbers as they expect",
    **{(f".gltf: a {part}", *change): "a number is what it says, and nothing else contradicts it"
       for part, change in (("node", ("scale", "mm")), ("node", ("axis", "the other way round")), ("material", ("axis", "the other way round")))},
    **{(f".gltf: a {part}", "name", "another member"): "what a file has beyond its format is for other programs" for part in ("node", "material")},
}


def result_of(folder, form):
    """(exit code, message, what came out)."""
    message = ""
    for command in form.command.split(" ; "):
        done = subprocess.run([support.PROGRAM, *command.split()], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              stdin=subprocess.DEVNULL, timeout=120 * support.SLOWER)
        message += done.stderr.decode(errors="replace")
        if done.returncode != 0:
            break
    written = folder / form.result
    if not form.result:
        data = done.stdout
    elif written.is_dir():
        data = b"".join(file.read_bytes() for file in sorted(written.iterdir()))
    else:
        data = written.read_bytes() if written.is_file() else b""
    if form.result.endswith(".png"):  # its pixels: its notes have names of files
        data = b"".join(data[at + 4:at + 4 + int.from_bytes(data[at - 4:at], "big")] for at in (m.start() for m in re.finditer(b"IDAT", data)))
    if not form.result and done.returncode == 0:
        said = json.loads(done.stdout)
        message += "".join(f"volute: {remark['sentence']}\n" for remark in said.pop("remarks", []))
        for key in ("file", "bytes", "bytes_a", "bytes_b", "pictures"):
            said.pop(key, None)
        data = json.dumps(said, sort_keys=True).encode()
    if form.result.endswith(".npy") and " info " in form.command and done.returncode == 0:
        said = json.loads(done.stdout)
        data += json.dumps({key: said.get(key) for key in ("bounds", "times", "frame_numbers", "grids", "size")}, sort_keys=True).encode()
    return done.returncode, message, data


def near(a, b):
    """The same text, but for the last digits of numbers; or the same numbers of a .npy, nearly."""
    if a == b:
        return True
    if a.startswith(b"\x93NUMPY"):
        ends = [data.index(b"\n") + 1 for data in (a, b)]
        rest = [data.rfind(b"{") if data.rfind(b"{") > end else len(data) for data, end in zip((a, b), ends)]
        if a[:ends[0]] != b[:ends[1]] or not near(a[rest[0]:], b[rest[1]:]) or rest[0] - ends[0] != rest[1] - ends[1]:
            return False
        values = [memoryview(data[end:to]).cast("f") for data, end, to in zip((a, b), ends, rest)]
        return all(abs(x - y) <= 2e-4 * max(1, abs(x)) for x, y in zip(*values))
    number = re.compile(rb"-?\d+\.?\d*(?:e[-+]?\d+)?")
    if number.sub(b"#", a) != number.sub(b"#", b):
        return False
    return all(abs(float(x) - float(y)) <= 1e-4 * max(1, abs(float(x))) for x, y in zip(number.findall(a), number.findall(b)))


class Machine:
    def __init__(self, folder):
        self.folder = folder
        self.bases = {}
        self.right = {}

    def base(self, name):
        if name not in self.bases:
            (self.folder / name).mkdir()
            meaning_formats.BASES[name](self.folder / name)
            self.bases[name] = self.folder / name
        return self.bases[name]

    def run(self, form):
        """[(mutation, label, verdict)]: same, right, refused, told, or a sentence of what was silent."""
        base = self.base(form.base)
        key = (form.base, form.command)
        if key not in self.right:
            with tempfile.TemporaryDirectory(dir=self.folder) as name:
                work = pathlib.Path(name) / "base"
                shutil.copytree(base, work)
                self.right[key] = result_of(work, form)
        code, right_message, right = self.right[key]
        if "this build has no" in right_message:
            return None
        assert code == 0 and right, (form.name, code, right_message)
        data = (base / form.file).read_bytes()
        verdicts = []
        own = ((mutation, label, change(data), kept) for mutation, label, change, kept in form.more)
        for mutation, label, changed, kept in itertools.chain(FAMILIES[form.family](data, form.hints), own):
            with tempfile.TemporaryDirectory(dir=self.folder) as name:
                work = pathlib.Path(name) / "base"
                shutil.copytree(base, work)
                (work / form.file).write_bytes(changed)
                code, message, got = result_of(work, form)
            new = {line for line in set(message.splitlines()) - set(right_message.splitlines()) if not re.search(FIGURES, line)}
            sentence = all(line.startswith(("volute", " ", "See", "  ")) for line in new if line)
            if code not in (0, 1, 2) or not sentence or "not enough memory" in message:
                verdict = f"exit code {code}: {message.strip()[-300:]}"
            elif code != 0:
                verdict = "refused"
            elif new:
                verdict = "told"
            elif kept is None:  # the file says something else, and so must the result: text that nothing obeys
                clean = form.result.endswith((".png", ".npy", ".exr", "out")) or not re.search(rb"[\0-\x08\x0b\x0c\x0e-\x1f]", got)
                verdict = "right" if clean else "control characters"
            elif near(right, got):
                verdict = "same" if kept else "same although it says something else"
            else:
                verdict = "another result, silently"
            verdicts.append((mutation, label, verdict, message.strip()[:200]))
        return verdicts


def reason(form, mutation, label):
    for key in ((form.name, mutation, label), (form.name, mutation, "*"), (form.family, mutation, label), (form.family, mutation, "*")):
        if key in UNKNOWABLE:
            return UNKNOWABLE[key]
    return None


def run_all(names=(), tell=lambda line: None):
    """{format: [(mutation, label, verdict, message)]}."""
    with tempfile.TemporaryDirectory() as folder:
        machine = Machine(pathlib.Path(folder))
        forms = [form for form in FORMATS if not names or form.name in names]
        for form in forms:
            machine.base(form.base)
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            found = {}
            for form, verdicts in zip(forms, pool.map(machine.run, forms)):
                found[form.name] = verdicts
                for mutation, label, verdict, message in verdicts or []:
                    line = message.replace("\n", " ")
                    tell(f"{form.name:22} {mutation:9} {label:32} {verdict:10} {line}")
            return found


def table(verdicts):
    signs = {"same": "=", "right": "=", "refused": "r", "told": "t"}
    reasons = {}
    lines = ["| | " + " | ".join(MUTATIONS) + " |\n", "| --- " * (len(MUTATIONS) + 1) + "|\n"]
    for form in FORMATS:
        cells = []
        for mutation in MUTATIONS:
            marks = []
            for one, label, verdict, _ in verdicts[form.name]:
                if one != mutation:
                    continue
                why = reason(form, mutation, label) if verdict not in signs else None
                if why:
                    marks.append(str(reasons.setdefault(why, len(reasons) + 1)))
                else:
                    marks.append(signs.get(verdict, "!"))
            cells.append("".join(sorted(set(marks), key=marks.index)))
        lines.append(f"| {form.name} | " + " | ".join(cells) + " |\n")
    return "".join(lines) + "\n" + "".join(f"{number}. {why}\n" for why, number in reasons.items())


class Meaning(unittest.TestCase):
    maxDiff = None

    def test_nothing_is_silent(self):
        verdicts = {name: found for name, found in run_all().items() if found is not None}
        silent = [f"{form.name}, {mutation}, {label}: {verdict}" for form in FORMATS for mutation, label, verdict, _ in verdicts.get(form.name, [])
                  if verdict not in ("same", "right", "refused", "told") and not reason(form, mutation, label)]
        self.assertEqual(silent, [])
        if len(verdicts) < len(FORMATS):
            return  # a build without some readers
        page = PAGE.read_text(encoding="utf-8")
        if BEGIN in page:
            self.assertEqual(page[page.index(BEGIN) + len(BEGIN):page.index(END)], table(verdicts),
                             "docs/robustness.md has another table: python3 tests/cli/meaning_test.py --table writes it")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--table"]:
        found = run_all(sys.argv[2:], print)
        if not sys.argv[2:]:
            page = PAGE.read_text(encoding="utf-8")
            if BEGIN not in page:
                sys.exit(table(found))
            PAGE.write_text(page[:page.index(BEGIN) + len(BEGIN)] + table(found) + page[page.index(END):], encoding="utf-8")
    else:
        support.main()
