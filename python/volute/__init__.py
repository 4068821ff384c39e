# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Volute: measure, compress and render fire, smoke and fog, and compute what is visible through them.

    import volute
    v = volute.open("fire.volute")                       # a lazy array (t, z, y, x[, 3])
    v[10, 32], v.times, v.bounds                         # decodes only the blocks needed
    volute.compress(array, "smoke.volute", rms=3e-3)     # array (t, z, y, x[, 3]), or an iterator of frames
    volute.picture(array, emission=2.0)                  # bytes (height, width, 3) of a file, a scene or an array, as the command draws it
    volute.picture(volute.Function(value, (64, 64, 64), bounds=bounds))    # of a function value(x, y, z, t)
    volute.film("smoke.volute", "smoke.mp4")
    volute.render("scene.json", time=0.8)                # linear RGB (height, width, 3), for measurements
    volute.visibility("case.smv", signs, eyes).lost()    # [s] until each sign is lost
    volute.Engine("case.smv", signs).sees(eyes, time)    # asked by a program that moves people, as is .dose(ids, eyes, time)
    volute.reconstruct("capture.json").values            # radiance per metre from pictures
    volute.fds.open("case.smv")                          # extinction [1/m] as a lazy array

Errors are volute.Error, and also Python's own types where one fits (FileNotFoundError, ValueError, ..). Long calls release the
GIL, stop at Ctrl-C, and report to `progress`."""
import os as _os

from . import _core, fds
from ._arrays import Function
from ._compress import Compressed, compress, resample, to_bytes
from ._lines import Lines
from ._mesh import Mesh
from ._errors import (Cancelled, Error, InvalidArgument, InvalidData, IoError, NotFound, TooLarge, Truncated,
                      Unsupported)
from ._volume import Bricks, Frames, Volume, open
from ._scene_api import (Engine, Reconstruction, Scene, Sight, Survey, Trajectories, film, picture, read_image, reconstruct, render, to_srgb,
                         visibility, write_image)
from ._own_media import PIECE, SEGMENT, Member, check_medium, medium, pieces

__version__ = _core.version
__all__ = ["Bricks", "Cancelled", "Compressed", "Engine", "Error", "Frames", "Function", "InvalidArgument", "InvalidData", "IoError", "Lines", "Member", "Mesh", "NotFound", "Reconstruction",
           "Scene", "Sight", "Survey", "TooLarge", "Trajectories", "Truncated", "Unsupported", "Volume", "check_medium", "compress", "fds", "film", "medium", "open",
           "picture", "pieces", "read_image", "reconstruct", "render", "resample", "set_threads", "to_bytes", "to_srgb", "visibility", "write_image"]


def __getattr__(name):
    """Modules for other packages, which are loaded when they are first used: volute.xarray, volute.numcodecs, volute.hdf5, volute.vtk."""
    if name in ("hdf5", "numcodecs", "vtk", "xarray"):
        import importlib
        return importlib.import_module("." + name, __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def set_threads(count=0):
    """Limits the threads of all calls from now on, 0: as many as the machine has; returns how many there were."""
    from ._arrays import whole
    count = whole("count", count)
    if count < 0:
        raise ValueError(f"count={count}: expected 0 or more")
    return _core.set_threads(count)


def _find_plugins():
    """Where the parts with heavy dependencies are: beside the command that belongs to this package."""
    from ._command import find
    program = find()
    if program:
        folder = _os.path.join(_os.path.dirname(_os.path.dirname(_os.path.realpath(program))), "lib", "volute")
        if _os.path.isdir(folder):
            _os.environ.setdefault("VOLUTE_PLUGIN_FOLDER", folder)


_find_plugins()
