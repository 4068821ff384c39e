# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Fields on tetrahedra and other cells, from arrays."""
import numpy as np

from . import _vtk_values
from ._arrays import reals, seconds, unmasked

#: corners of a cell, and its number in C++
_CELLS = {"tetra": (4, 0), "pyramid": (5, 1), "wedge": (6, 2), "hexahedron": (8, 3)}


class Mesh:
    """Fields on tetrahedra and other cells: what a .vtu file of smoke holds, for Scene(), render(), picture(), Sight() and all else that
    takes such a file: Scene(mesh, quantity="extinction").

    points: shape (n, 3) [m]. cells: numbers of points, shape (m, 4) of tetrahedra, (m, 5) of pyramids, (m, 6) of wedges or (m, 8) of
        hexahedra, corners in VTK's order; or a dict of several, {"tetra": .., "hexahedron": ..} (meshio's cells_dict). In it, "voxel" is
        (m, 8) in VTK's order of voxels, and "polyhedron" a list: of each cell the number of its faces, then of each face the number of its
        corners and they (VTK's face streams).
    fields: {name: values at points}, shape (n,), or (t, n) at several times. cell_fields: the same of cells, (m,) or (t, m), in the order
        of `cells`. times: [s], ascending.
    A vtkUnstructuredGrid in place of all of these: Mesh(grid). Its ghost and blanked cells, surfaces and lines are left out, as of files.
    Points that no cell has are left out.
    Values are copied, in float32."""

    _ghosts = 0  #: cells of a grid that are marked as such

    def __init__(self, points, cells=None, fields=None, *, cell_fields=None, times=None):
        if _vtk_values.is_grid(points):
            if cells is not None or fields is not None or cell_fields is not None:
                raise TypeError("a grid of VTK has its own cells and fields; give it alone")
            points, cells, fields, cell_fields, self._ghosts = _vtk_values.grid(points)
        elif cells is None:
            raise TypeError("cells: expected numbers of points, shape (m, 4), (m, 5), (m, 6) or (m, 8)")
        points = np.array(reals(points, "points")[0], np.float64, order="C")
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise ValueError(f"points: shape {points.shape}; expected (n, 3), finite numbers")
        if not isinstance(cells, dict):
            cells = np.asarray(unmasked(cells, "cells"))
            kind = next((kind for kind, (corners, _) in _CELLS.items() if cells.ndim == 2 and cells.shape[1] == corners), None)
            if kind is None:
                raise ValueError(f"cells: shape {cells.shape}; expected (m, 4), (m, 5), (m, 6) or (m, 8)")
            cells = {kind: cells}
        corners, counts, shapes = [], [], []
        for kind, numbers in cells.items():
            if kind == "polyhedron":
                streams = [np.asarray(unmasked(stream, kind)) for stream in numbers]
                if any(stream.ndim != 1 or stream.dtype.kind not in "iu" for stream in streams):
                    raise ValueError("cells, polyhedron: expected a list of whole numbers for each: faces, then of each its corners")
                corners.extend(stream.astype(np.int64) for stream in streams)
                counts.append(np.array([len(stream) for stream in streams], np.int64))
                shapes.append(np.full(len(streams), 4, np.uint8))
                continue
            if kind == "voxel":  # rows, not rounds
                numbers = np.asarray(unmasked(numbers, kind))
                kind, numbers = "hexahedron", numbers[:, [0, 1, 3, 2, 4, 5, 7, 6]] if numbers.ndim == 2 and numbers.shape[1] == 8 else numbers
            count, code = _CELLS.get(kind, (0, 0))
            numbers = np.asarray(unmasked(numbers, kind))
            if not count:
                raise ValueError(f"cells are of the kind {kind!r}; expected {', '.join(_CELLS)}, voxel or polyhedron")
            if numbers.ndim != 2 or numbers.shape[1] != count or numbers.dtype.kind not in "iu":
                raise ValueError(f"cells, {kind}: shape {numbers.shape} of {numbers.dtype}; expected (m, {count}) whole numbers")
            if numbers.size and not (0 <= numbers.min() and numbers.max() < len(points)):
                raise ValueError(f"cells, {kind}: a corner is {numbers.max() if numbers.min() >= 0 else numbers.min()}; there are {len(points)} points")
            corners.append(numbers.astype(np.int64).ravel())
            counts.append(np.full(len(numbers), count, np.int64))
            shapes.append(np.full(len(numbers), code, np.uint8))
        if not corners:
            raise ValueError("there are no cells")
        self._cells = points, np.concatenate(corners), np.concatenate(([0], np.cumsum(np.concatenate(counts)))), np.concatenate(shapes)
        self.shape = len(points), len(self._cells[3])  #: points, cells
        self.times = np.zeros(1) if times is None else seconds("times", times)
        if not (np.diff(self.times) > 0).all():
            raise ValueError("times: expected ascending ones")
        self._fields = [*self._checked(fields or {}, False), *self._checked(cell_fields or {}, True)]
        if not self._fields:
            raise ValueError("there are no fields; expected fields={name: values at points}, or cell_fields")

    def _checked(self, fields, of_cells):
        """(name, whether of cells, values of each time)"""
        count = self.shape[of_cells]
        for name, values in fields.items():
            values = np.asarray(reals(values, f"field {name!r}")[0])
            if values.shape == (count,) and len(self.times) == 1:
                values = values[np.newaxis]
            if values.shape != (len(self.times), count):
                raise ValueError(f"field {name!r}: shape {values.shape}; expected {(len(self.times), count)}: times and {'cells' if of_cells else 'points'}")
            with np.errstate(over="ignore"):  # told where it is read: not finite
                yield str(name), of_cells, np.array(values, np.float32, order="C")

    def __repr__(self):
        return f"<volute.Mesh: {self.shape[0]} points, {self.shape[1]} cells, {len(self.times)} times>"
