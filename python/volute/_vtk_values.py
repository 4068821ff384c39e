# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Images and grids of VTK (and of PyVista, which derives from it) as values."""
import numpy as np

#: VTK's numbers of cells that a Mesh has
_KINDS = {10: ("tetra", 4), 14: ("pyramid", 5), 13: ("wedge", 6), 12: ("hexahedron", 8), 11: ("voxel", 8)}
_POLYHEDRON, _QUAD = 42, 9  # up to which cells have no volume
_GHOSTS = "vtkGhostType"


def is_image(given):
    return hasattr(given, "IsA") and given.IsA("vtkImageData")


def is_grid(given):
    return hasattr(given, "IsA") and given.IsA("vtkUnstructuredGrid")


def _numpy(array):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    return vtk_to_numpy(array)


def _fields(attributes):
    """{name: array} of numbers, but for what VTK marks as ghosts."""
    arrays = [attributes.GetArray(i) for i in range(attributes.GetNumberOfArrays())]
    return {array.GetName() or "density": array for array in arrays
            if array is not None and not (array.GetName() or "").startswith("vtkGhost")}


def _chosen(image, name):
    """(array, whether of cells) that is meant: by its name, else the active scalars, else the only one."""
    sides = ((image.GetPointData(), False), (image.GetCellData(), True))
    fields = {key: (array, cells) for attributes, cells in sides for key, array in _fields(attributes).items()}
    if name is not None and name in fields:
        return fields[name]
    for attributes, cells in sides:
        if name is None and attributes.GetScalars() is not None:
            return attributes.GetScalars(), cells
    if len(fields) == 1 and name is None:
        return next(iter(fields.values()))
    what = f"no array {name!r}" if name is not None else "no active scalars"
    raise ValueError(f"the image has {what}, but {', '.join(map(repr, fields)) or 'no arrays at all'}; say name=")


def image(given, name):
    """(array (z, y, x[, c]), what it says) of a vtkImageData: without a copy, unless some are blanked, which are
    0. Values at points are those of voxels around them."""
    array, cells = _chosen(given, name)
    direction = given.GetDirectionMatrix()
    if any(direction.GetElement(i, j) != (i == j) for i in range(3) for j in range(3)):
        raise ValueError("the image is turned (its direction matrix); write it as .vti, or take the matrix away and give it as transform=")
    extent = given.GetExtent()
    sides = [extent[2 * axis + 1] - extent[2 * axis] + (not cells) for axis in range(3)]
    values = _numpy(array)
    ghosts = (given.GetCellData() if cells else given.GetPointData()).GetArray(_GHOSTS)
    hidden = (_numpy(ghosts) & (32 if cells else 2)) != 0 if ghosts else np.zeros(0, bool)
    if hidden.any():
        values = values.copy()
        values[hidden] = 0
    values = values.reshape(*sides[::-1], *values.shape[1:])
    half = 0 if cells else 0.5
    origin, spacing = given.GetOrigin(), given.GetSpacing()
    corners = [[origin[axis] + spacing[axis] * (extent[2 * axis + side] + (half if side else -half)) for axis in range(3)] for side in (0, 1)]
    return values, {"name": array.GetName() or "density", "bounds": corners}


def grid(given):
    """(points, cells, fields, cell_fields, ghosts) of a vtkUnstructuredGrid, as Mesh() takes them."""
    from vtkmodules.vtkCommonCore import vtkIdList
    ghosts = 0
    if given.GetCellData().GetArray(_GHOSTS):
        whole, given = given, given.NewInstance()
        given.ShallowCopy(whole)
        given.RemoveGhostCells()
        ghosts = whole.GetNumberOfCells() - given.GetNumberOfCells()
    types = _numpy(given.GetCellTypesArray()) if given.GetNumberOfCells() else np.zeros(0, np.uint8)
    known = sorted([*_KINDS, _POLYHEDRON])
    unknown = sorted(kind for kind in set(types.tolist()) - set(known) if kind > _QUAD)
    if unknown:
        raise ValueError(f"the grid has cells of VTK's types {unknown}; expected tetrahedra, pyramids, wedges, hexahedra, voxels and "
                         f"polyhedra ({', '.join(map(str, known))})")
    offsets, corners = _numpy(given.GetCells().GetOffsetsArray()), _numpy(given.GetCells().GetConnectivityArray())
    cells, order = {}, []
    for code, (kind, count) in _KINDS.items():
        of_kind = np.flatnonzero(types == code)
        if len(of_kind):
            cells[kind] = corners[offsets[of_kind][:, np.newaxis] + np.arange(count)]
            order.append(of_kind)
    of_kind = np.flatnonzero(types == _POLYHEDRON)
    if len(of_kind):
        ids, cells["polyhedron"] = vtkIdList(), []
        for cell in of_kind.tolist():
            given.GetFaceStream(cell, ids)
            cells["polyhedron"].append(np.array([ids.GetId(i) for i in range(ids.GetNumberOfIds())], np.int64))
        order.append(of_kind)
    order = np.concatenate(order) if order else np.zeros(0, int)

    def scalars(attributes):
        return {name: _numpy(array) for name, array in _fields(attributes).items() if array.GetNumberOfComponents() == 1}
    return (_numpy(given.GetPoints().GetData()), cells, scalars(given.GetPointData()),
            {name: values[order] for name, values in scalars(given.GetCellData()).items()}, ghosts)
