# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
""".volute files in xarray.

    import xarray
    data = xarray.open_dataset("smoke.volute", engine="volute")      # an installed package; else engine=volute.xarray.Backend
    data["density"].sel(t=0.4, method="nearest").mean("z")           # decodes only the blocks needed

Each grid of a file is a variable with the dimensions t, z, y, x, and c with three channels; those of a grid that lies elsewhere have
its name (x_velocity). Coordinates are times [s], frame_number, and the centres of voxels [m]; voxels that do not lie along the axes have none, but the
attribute matrices: of each frame three rows of four numbers, from (x, y, z), counted in voxels, to the world. Other attributes are the unit,
the axis that points upwards, and the errors that the file states. volute.compress(data["density"], ..) writes such arrays."""
import os

import numpy as np
from xarray import Dataset, Variable
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

import volute


class _Lazy(BackendArray):
    """A Volume behind xarray's indices."""

    def __init__(self, opened):
        self._volume = opened
        self.shape, self.dtype = opened.shape, opened.dtype

    def __getitem__(self, key):
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER_1VECTOR, self._volume.__getitem__)


def _place(opened):
    """What two grids with the same coordinates have in common."""
    return opened.shape[:4], opened.bounds, tuple(opened.times), None if opened.matrices is None else opened.matrices.tobytes()


def _centres(opened, axis):
    low, high = opened.bounds[0][axis], opened.bounds[1][axis]
    count = opened.shape[3 - axis]
    return low + (np.arange(count) + 0.5) * (high - low) / count


class Backend(BackendEntrypoint):
    """xarray's engine "volute"."""

    description = "Volumes of fire, smoke and fog, compressed with a stated error"
    open_dataset_parameters = ("filename_or_obj", "drop_variables", "partial", "max_memory")

    def open_dataset(self, filename_or_obj, *, drop_variables=None, partial=False, max_memory=4 << 30):
        dropped = [drop_variables] if isinstance(drop_variables, str) else list(drop_variables or [])
        first = volute.open(filename_or_obj, partial=partial, max_memory=max_memory)
        grids = {name: first if name == first.name else first.grid(name) for name, said in first.grids.items()
                 if not said["empty"] and name not in dropped}
        variables, coordinates = {}, {}
        for name, opened in grids.items():
            ending = "" if _place(opened) == _place(first) else "_" + name
            dimensions = tuple(axis + ending for axis in "tzyx") + ("c",) * (opened.ndim == 5)
            attributes = {"max_error": opened.max_error, "relative_rms_error": opened.rms, "value_range": opened.value_range, "basis": opened.basis}
            if opened.unit:
                attributes["units"] = opened.unit
            if opened.up:
                attributes["up"] = opened.up
            if opened.matrices is not None:
                attributes["matrices"] = opened.matrices.ravel()
            variables[name] = Variable(dimensions, indexing.LazilyIndexedArray(_Lazy(opened)), attributes,
                                       {"preferred_chunks": dict(zip(dimensions, opened.chunks))})
            coordinates["t" + ending] = Variable("t" + ending, np.asarray(opened.times), {"units": "s", "axis": "T"})
            coordinates["frame_number" + ending] = Variable("t" + ending, np.asarray(opened.frame_numbers))
            for axis, letter in enumerate("xyz" if opened.matrices is None else ""):
                coordinates[letter + ending] = Variable(letter + ending, _centres(opened, axis), {"units": "m", "axis": letter.upper()})
        dataset = Dataset(variables, coordinates, {"provenance": first.provenance})
        dataset.set_close(lambda: [opened.close() for opened in grids.values()])
        return dataset

    def guess_can_open(self, filename_or_obj):
        try:
            return os.fspath(filename_or_obj).endswith(".volute")
        except TypeError:
            return False
