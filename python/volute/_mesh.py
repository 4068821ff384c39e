# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Fields on tetrahedra and other cells, from arrays."""
import logging
import os
import shutil
import sys
import tempfile
import weakref

import numpy as np

from . import _vtk_values
from ._arrays import number, reals, unmasked
from ._volume import _bytes

_log = logging.getLogger("volute")
#: corners of a cell, and its number in VTK
_CELLS = {"tetra": (4, 10), "pyramid": (5, 14), "wedge": (6, 13), "hexahedron": (8, 12)}


class Mesh:
    """Fields on tetrahedra, pyramids, wedges and hexahedra: what a .vtu file of smoke holds, for Scene(), render(), picture(), Sight() and
    all else that takes such a file: Scene(mesh, quantity="extinction").

    points: shape (n, 3) [m]. cells: numbers of points, shape (m, 4) of tetrahedra, (m, 5) of pyramids, (m, 6) of wedges or (m, 8) of
        hexahedra, corners in VTK's order; or a dict of several, {"tetra": .., "hexahedron": ..} (meshio's cells_dict).
    fields: {name: values at points}, shape (n,), or (t, n) at several times. cell_fields: the same of cells, (m,) or (t, m), in the order
        of `cells`. times: [s], ascending.
    A vtkUnstructuredGrid in place of all of these: Mesh(grid).
    Values are copied, into files of the folder for temporary files that live as long as this."""

    def __init__(self, points, cells=None, fields=None, *, cell_fields=None, times=None):
        if _vtk_values.is_grid(points):
            if cells is not None or fields is not None or cell_fields is not None:
                raise TypeError("a grid of VTK has its own cells and fields; give it alone")
            points, cells, fields, cell_fields = _vtk_values.grid(points)
        elif cells is None:
            raise TypeError("cells: expected numbers of points, shape (m, 4), (m, 5), (m, 6) or (m, 8)")
        points = np.ascontiguousarray(reals(points, "points")[0], np.float64)
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise ValueError(f"points: shape {points.shape}; expected (n, 3), finite numbers")
        if not isinstance(cells, dict):
            cells = np.asarray(unmasked(cells, "cells"))
            kind = next((kind for kind, (corners, _) in _CELLS.items() if cells.ndim == 2 and cells.shape[1] == corners), None)
            if kind is None:
                raise ValueError(f"cells: shape {cells.shape}; expected (m, 4), (m, 5), (m, 6) or (m, 8)")
            cells = {kind: cells}
        corners, offsets, types = [], [], []
        for kind, numbers in cells.items():
            count, code = _CELLS.get(kind, (0, 0))
            numbers = np.asarray(unmasked(numbers, kind))
            if not count:
                raise ValueError(f"cells are of the kind {kind!r}; expected {', '.join(_CELLS)}")
            if numbers.ndim != 2 or numbers.shape[1] != count or numbers.dtype.kind not in "iu":
                raise ValueError(f"cells, {kind}: shape {numbers.shape} of {numbers.dtype}; expected (m, {count}) whole numbers")
            if numbers.size and not (0 <= numbers.min() and numbers.max() < len(points)):
                raise ValueError(f"cells, {kind}: a corner is {numbers.max() if numbers.min() >= 0 else numbers.min()}; there are {len(points)} points")
            corners.append(numbers.astype(np.int64).ravel())
            offsets.append(np.full(len(numbers), count, np.int64))
            types.append(np.full(len(numbers), code, np.uint8))
        mesh = (("Cells", "connectivity", np.concatenate(corners)), ("Cells", "offsets", np.cumsum(np.concatenate(offsets))),
                ("Cells", "types", np.concatenate(types)))
        self.shape = len(points), len(mesh[2][2])  #: points, cells
        self.times = np.zeros(1) if times is None else np.array([number("times", time) for time in np.atleast_1d(unmasked(times, "times"))])
        if not (np.diff(self.times) > 0).all():
            raise ValueError("times: expected ascending ones")
        values = [*self._fields("PointData", fields or {}, self.shape[0]), *self._fields("CellData", cell_fields or {}, self.shape[1])]
        if not values:
            raise ValueError("there are no fields; expected fields={name: values at points}, or cell_fields")
        self._make_folder()
        names = [f"mesh_{i:04d}.vtu" for i in range(len(self.times))]
        for i, name in enumerate(names):
            self._write(name, [(place, field, all_of[i]) for place, field, all_of in values] + [("Points", "Points", points), *mesh])
        #: the file
        self.path = os.path.join(self._folder, names[0])
        if len(names) > 1:
            self.path = os.path.join(self._folder, "mesh.pvd")
            with open(self.path, "w") as file:
                sets = "".join(f'<DataSet timestep="{time!r}" file="{name}"/>\n' for time, name in zip(self.times.tolist(), names))
                file.write(f'<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1"><Collection>\n{sets}</Collection></VTKFile>\n')
        _log.info("the mesh is kept in %s, %s", self._folder,
                  _bytes(sum(os.path.getsize(os.path.join(self._folder, name)) for name in names)))

    def _make_folder(self):
        self._folder = tempfile.mkdtemp(prefix="volute-mesh-")
        weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)

    def __getstate__(self):
        files = {}
        for name in os.listdir(self._folder):
            with open(os.path.join(self._folder, name), "rb") as file:
                files[name] = file.read()
        return {"shape": self.shape, "times": self.times, "path": os.path.basename(self.path), "files": files}

    def __setstate__(self, state):
        self.shape, self.times = state["shape"], state["times"]
        self._make_folder()
        for name, data in state["files"].items():
            with open(os.path.join(self._folder, name), "wb") as file:
                file.write(data)
        self.path = os.path.join(self._folder, state["path"])

    def _fields(self, place, fields, count):
        for name, values in fields.items():
            values = np.asarray(reals(values, f"field {name!r}")[0])
            if values.shape == (count,) and len(self.times) == 1:
                values = values[np.newaxis]
            if values.shape != (len(self.times), count):
                what = "points" if place == "PointData" else "cells"
                raise ValueError(f"field {name!r}: shape {values.shape}; expected {(len(self.times), count)}: times and {what}")
            yield place, str(name), values.astype(np.float32 if values.dtype == np.float32 else np.float64)

    def _write(self, name, arrays):
        """VTK's XML with the numbers appended as they are."""
        codes = {"float32": "Float32", "float64": "Float64", "int64": "Int64", "uint8": "UInt8"}
        components = ' NumberOfComponents="3"'
        text, begin, at = {}, [], 0
        for place, field, values in arrays:
            escaped = field.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
            text[place] = text.get(place, "") + (f'<DataArray type="{codes[values.dtype.name]}" Name="{escaped}" format="appended" offset="{at}"'
                                                 f'{components if place == "Points" else ""}/>\n')
            begin.append(np.uint64(values.nbytes).tobytes())
            at += 8 + values.nbytes
        parts = "".join(f"<{place}>\n{text[place]}</{place}>\n" for place in ("PointData", "CellData", "Points", "Cells") if place in text)
        with open(os.path.join(self._folder, name), "wb") as file:
            file.write(f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="{sys.byteorder.capitalize()}Endian" '
                       f'header_type="UInt64">\n<UnstructuredGrid><Piece NumberOfPoints="{self.shape[0]}" NumberOfCells="{self.shape[1]}">\n'
                       f'{parts}</Piece></UnstructuredGrid>\n<AppendedData encoding="raw">\n_'.encode())
            for size, (_, _, values) in zip(begin, arrays):
                file.write(size)
                file.write(np.ascontiguousarray(values))
            file.write(b"\n</AppendedData></VTKFile>\n")

    def __repr__(self):
        return f"<volute.Mesh: {self.shape[0]} points, {self.shape[1]} cells, {len(self.times)} times>"
