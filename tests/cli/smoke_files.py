# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Meshes with smoke, written as text, and float pictures read back, by other means than the program's."""
import array
import itertools
import pathlib
import struct
import zlib

SIX = ((0, 1, 3, 7), (0, 1, 5, 7), (0, 2, 3, 7), (0, 2, 6, 7), (0, 4, 5, 7), (0, 4, 6, 7))


def box(low, high, cells):
    """A box cut into tets, six to a cell: (points, tets)."""
    counts = [n + 1 for n in cells]
    points = [tuple(low[a] + (high[a] - low[a]) * at[a] / cells[a] for a in range(3))
              for z, y, x in itertools.product(*(range(n) for n in reversed(counts))) for at in ((x, y, z),)]

    def index(x, y, z):
        return (z * counts[1] + y) * counts[0] + x

    tets = []
    for z, y, x in itertools.product(range(cells[2]), range(cells[1]), range(cells[0])):
        corner = [index(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2)) for k in range(8)]
        tets += [tuple(corner[k] for k in six) for six in SIX]
    return points, tets


def write_vtu(path, mesh, fields):
    """fields: {"name": values at points}."""
    points, tets = mesh

    def numbers(values):
        return " ".join(repr(float(v)) if isinstance(v, float) else str(v) for v in values)

    data = "".join(f'<DataArray type="Float32" Name="{name}" format="ascii">{numbers(values)}</DataArray>'
                   for name, values in fields.items())
    pathlib.Path(path).write_text(
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64"><UnstructuredGrid>'
        f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(tets)}"><PointData>{data}</PointData><Points>'
        '<DataArray type="Float64" NumberOfComponents="3" format="ascii">'
        f'{numbers(itertools.chain.from_iterable(points))}</DataArray></Points><Cells>'
        '<DataArray type="Int64" Name="connectivity" format="ascii">'
        f'{numbers(itertools.chain.from_iterable(tets))}</DataArray><DataArray type="Int64" Name="offsets" format="ascii">'
        f'{numbers(range(4, 4 * len(tets) + 1, 4))}</DataArray><DataArray type="UInt8" Name="types" format="ascii">'
        f'{numbers([10] * len(tets))}</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>')


def write_pvd(path, files):
    """files: {time: name}."""
    sets = "".join(f'<DataSet timestep="{time}" file="{name}"/>' for time, name in files.items())
    pathlib.Path(path).write_text(f'<VTKFile type="Collection" version="0.1"><Collection>{sets}</Collection></VTKFile>')


def read_exr(path):
    """(width, height, {channel: values}, {attribute: text}) of a scan-line file of float32, ZIP, or none."""
    data = pathlib.Path(path).read_bytes()
    at = 8
    names, texts, box_, compression = [], {}, None, 0
    while data[at]:
        name, rest = data[at:].split(b"\0", 1)
        kind = rest.split(b"\0", 1)[0]
        at += len(name) + len(kind) + 2
        (size,) = struct.unpack_from("<i", data, at)
        value = data[at + 4:at + 4 + size]
        at += 4 + size
        if kind == b"chlist":
            while value[0]:
                channel, value = value.split(b"\0", 1)
                names.append(channel.decode())
                value = value[16:]
        elif kind == b"box2i" and name == b"dataWindow":
            box_ = struct.unpack("<4i", value)
        elif kind == b"compression":
            compression = value[0]
        elif kind == b"string":
            texts[name.decode()] = value.decode()
    width, height = box_[2] + 1, box_[3] + 1
    lines = {0: 1, 2: 1, 3: 16}[compression]
    chunks = (height + lines - 1) // lines
    offsets = struct.unpack_from(f"<{chunks}Q", data, at + 1)
    rows = []
    for chunk, offset in enumerate(offsets):
        count = min(lines, height - chunk * lines)
        (size,) = struct.unpack_from("<i", data, offset + 4)
        block = data[offset + 8:offset + 8 + size]
        whole = 4 * width * len(names) * count
        if size < whole:
            block = unzip(block)
        for row in range(count):
            values = array.array("f", block[4 * width * len(names) * row:4 * width * len(names) * (row + 1)])
            rows.append([values[c * width:(c + 1) * width] for c in range(len(names))])
    return width, height, {name: [v for row in rows for v in row[c]] for c, name in enumerate(names)}, texts


def unzip(block):
    """OpenEXR's: deflated differences of interleaved halves."""
    raw = bytearray(zlib.decompress(block))
    for i in range(1, len(raw)):
        raw[i] = (raw[i - 1] + raw[i] - 128) & 255
    half = (len(raw) + 1) // 2
    out = bytearray(len(raw))
    out[0::2], out[1::2] = raw[:half], raw[half:]
    return bytes(out)


def png_texts(path):
    """The tEXt chunks of a .png."""
    data, at, texts = pathlib.Path(path).read_bytes(), 8, {}
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"tEXt":
            name, text = data[at + 8:at + 8 + size].split(b"\0", 1)
            texts[name.decode("latin1")] = text.decode("latin1")
        at += 12 + size
    return texts
