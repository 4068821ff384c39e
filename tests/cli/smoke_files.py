# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Meshes with smoke, written as text, and what pictures say about themselves."""
import itertools
import pathlib
import struct

import pictures

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
    """(width, height, {channel: values}, {attribute: text})."""
    picture = pictures.read_exr(path)
    names = "RGB" if picture.channels == 3 else "Y"
    header, _ = pictures.attributes(pathlib.Path(path).read_bytes())
    texts = {name: value.decode("latin1") for name, value in header.items() if name.startswith("volute.")}
    return picture.width, picture.height, {name: picture.values[c::picture.channels] for c, name in enumerate(names)}, texts


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
