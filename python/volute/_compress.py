# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Writing .volute files."""
import builtins
import dataclasses
import logging
import os
import tempfile

import numpy as np

from . import _core
from ._arrays import check_not_finite, checked, corners, five_axes, frame_range, number, utf8, volume, whole
from ._errors import InvalidArgument
from ._progress import Listener
from ._volume import _bytes, Frames, Volume, file_name, open as _open, reads_noted, size_of

_log = logging.getLogger("volute")


@dataclasses.dataclass
class Compressed:
    """The result of a compression."""
    path: str
    raw_bytes: int  #: of the values as float32
    file_bytes: int
    rms: float  #: relative RMS error over all voxels that was reached, measured on what was written
    support_rms: float  #: the same over voxels that are not 0, of their range
    support_share: float  #: of such voxels in all
    max_error: float  #: no value differs more
    value_range: tuple  #: (minimum, maximum) of the original
    seconds: float

    @property
    def ratio(self):
        return self.raw_bytes / self.file_bytes

    def open(self):
        """The file as a lazy array."""
        return _open(self.path)

    def __repr__(self):
        return (f"<{self.path}: {_bytes(self.file_bytes)}, 1/{self.ratio:.4g} of float32, relative RMS error {self.rms:.3g}, "
                f"at most {self.max_error:.3g}; {self.seconds:.2f} s>")


def compress(frames, path, *, quality=None, rms=None, rms_over="support", psnr=None, ratio=None, size=None, max_error=None, bounds=None, times=None,
             frame_numbers=None, name=None, unit=None, basis=None, wavelet="auto", effort=5, fast=False, access=None, provenance="",
             not_finite="refuse", max_memory=4 << 30, progress=None):
    """Compresses a sequence of volumes into the .volute file `path`, which appears only when complete.

    frames: an array of shape (z,y,x), (t,z,y,x) or (t,z,y,x,c), c 1 or 3, of any real numbers in any layout; a volute.Volume, with all
        that its file says of that grid, whose own error is added to what is stated; a volute.fds case; an xarray.DataArray with dimensions t (or time), z, y, x, c (or channel) in any order, whose coordinates are
        times and the centres of voxels; anything with `shape` and `[i]` (dask, zarr, h5py), or an iterator of frames (z,y,x[,c]):
        these are asked for each frame once, and kept in a file without a name beside `path` meanwhile, 4 bytes a value.
        Values become float32, those far from zero differences from a number in their middle. The rounding of float64 and of large integers counts in the errors; a target that it alone misses is
        refused. Masked values of NumPy's masked arrays are voxels that are not there: inactive in the file, 0 where it is read, masked in
        Volume.masked().
    One of:
        quality: "look" (default: pictures look the same as the original's), "draft" (smaller) or "measure" (for numbers)
        rms: relative RMS error at most this, over voxels that are not 0 and of their range (rms_over="support"),
            or over all voxels and of (max - min) of the whole (rms_over="all")
        psnr: over all voxels, at least [dB]; ratio: float32 bytes / file bytes at least; size: at most [bytes];
        max_error: absolute error of every value at most [unit of the values]
    bounds: ((x0, y0, z0), (x1, y1, z1)), the outer voxel faces [m]; default: cubic voxels, the longest side 1 m
    times: when each frame is shown [s], ascending; default: 25 per second from 0
    frame_numbers: number of each frame, ascending, with up to 6 decimals; default: 0, 1, ..
    name, unit: of the values ("density", "1/m"). basis: what values mean between centres of voxels: "box" (constant in voxels), "trilinear"
        (interpolated) or "cubic" (the values are coefficients of B-splines of degree 3 there, which do not run through them but are
        smoother; basis="cubic" of a Scene or Sight interpolates values instead).
        Defaults are taken from `frames` if that is a Volume, an FDS case or a DataArray.
    wavelet: auto, haar, cdf53 or cdf97. effort: 1, the fastest, to 9, the smallest files. fast: effort 2. provenance: a text stored in the file.
    access: what is read most: "frame", single frames, decoded in a quarter of the time, from a file that may be larger; "film", all frames in order.
        Default: what costs next to nothing of both.
    not_finite: "refuse" NaN and infinities; "inactive": as masked values; or "background": as 0.
    progress: a function (stage, done, total), or True for a bar. An exception raised in it, or Ctrl-C, stops the work; no file is left behind.

    The file has the same bytes as from `volute compress`, except for the provenance, on any number of cores."""
    path = file_name(path)
    if not path.endswith(".volute"):
        raise ValueError(f"'{path}' does not end in .volute")
    targets = {key: value for key, value in dict(rms=rms, psnr=psnr, ratio=ratio, size=size, max_error=max_error).items()
               if value is not None}
    if len(targets) > 1:
        raise ValueError(f"{' and '.join(targets)} exclude each other; give one of them")
    words = {"draft": ("look", 4e-3), "look": ("look", 7e-4), "measure": ("rms", 1e-4)}
    if quality is not None and quality not in words:
        raise ValueError(f"quality={quality!r}: expected draft, look or measure")
    if quality is not None and targets:
        raise ValueError(f"quality and {', '.join(targets)} exclude each other; give one of them")
    usual = ("rms", 3e-3) if rms_over == "all" and quality is None else words[quality or "look"]
    target, value = next(iter(targets.items()), usual)
    if rms_over not in ("support", "all"):
        raise ValueError(f"rms_over={rms_over!r}: expected 'support' or 'all'")
    if target == "rms" and rms_over == "all":
        target = "rms_over_all"
    value = number(target, value, " of bytes, as 500_000" if target == "size" else "")
    if not (value > 0 and np.isfinite(value)):
        raise ValueError(f"{target}={value!r}: expected a number above 0")
    if wavelet not in ("auto", "haar", "cdf53", "cdf97"):
        raise ValueError(f"wavelet={wavelet!r}: expected auto, haar, cdf53 or cdf97")
    effort = 2 if fast else whole("effort", effort)
    if not 1 <= effort <= 9:
        raise ValueError(f"effort={effort}: expected 1 to 9")
    if access not in (None, "frame", "film"):
        raise ValueError(f"access={access!r}: expected 'frame' or 'film'")
    check_not_finite(not_finite)
    given = dict(bounds=bounds, times=times, frame_numbers=frame_numbers, name=name, unit=unit, basis=basis)
    if hasattr(frames, "_of_itself") and isinstance(frames.values, Volume):  # a Reconstruction
        frames = frames.values
    if isinstance(frames, Volume):
        return _compress_again(frames, path, (target, value), given, (wavelet, effort, access or ""), utf8("provenance", provenance),
                               size_of("max_memory", max_memory), progress)
    with Listener(progress) as listener, reads_noted(frames) as read:
        source, shape, said, rounding = volume(frames, given, os.path.dirname(path) or ".", not_finite=not_finite)
        _refuse_replacing(path, read)
        if basis == "cubic" and not isinstance(frames, Frames):
            _log.info("%s: the values are kept as coefficients of cubic B-splines, which smooth them", path)
        doubles = isinstance(frames, Frames) and frames.dtype == np.float64 or said.get("doubles", False)
        holes = not_finite == "inactive" or said.get("masked", False)
        report = _core.compress(source, shape, path, target, value, said, rounding, doubles, holes, wavelet, effort, access or "", utf8("provenance", provenance),
                                size_of("max_memory", max_memory), listener)
    return Compressed(path, **report)


def _compress_again(frames, path, target, given, how, provenance, max_memory, progress):
    """compress() of a Volume."""
    _refuse_replacing(path, {frames.path})
    frames._file.info  # says that it is closed
    five_axes(frames.shape)  # says that it is empty
    if frames.damage:
        provenance += "; " * bool(provenance) + frames.damage.replace(frames.path + ": ", "")
    said = checked({key: value for key, value in given.items() if value is not None}, len(frames))
    if frames.max_error > 0:
        _log.info("%s: is compressed itself: '%s' is at most %.3g from what it was made of; the new file states the sums", frames.path, frames.name,
                  frames.max_error)
    with Listener(progress) as listener:
        report = _core.compress_file(frames._file, path, *target, said, *how, provenance, max_memory, listener)
    return Compressed(path, **report)


def _refuse_replacing(path, read):
    for name in read:
        if os.path.exists(path) and os.path.exists(name) and os.path.samefile(path, name):
            raise InvalidArgument(f"{path} is read and would be replaced; give another name")


def resample(source, output, *, voxel_size=None, bounds=None, matrix=None, like=None, frames=None, grids=None, basis="trilinear", rms=1e-3,
             max_memory=4 << 30, progress=None):
    """Writes a volume on other voxels, as `volute resample`: voxels that are turned, sheared, moving or in a frustum come to lie along the axes.

    source: any file of a volume, or a Volume, which is one grid. output: .volute, .npy, or a pattern %04d.vdb or %04d.vti. What is not said is as in the source.
    voxel_size: [m], a number or (x, y, z). bounds: ((x0, y0, z0), (x1, y1, z1)), outer voxel faces [m]. matrix: three rows of four numbers, from
        the index of a new voxel to the world [m]. like: a volume whose first frame's voxels they are. frames: (first, end), numbers of frames, or range(first, end, step).
    grids: names, of a file with several. basis: of the old voxels. rms: relative, of a .volute."""
    def numbers(what, values, shape):
        values = np.asarray(values, float)
        if values.shape != shape or not np.isfinite(values).all():
            raise ValueError(f"{what}: expected {' x '.join(map(str, shape))} numbers")
        return values
    if voxel_size is not None:
        voxel_size = numbers("voxel_size", [voxel_size] * 3 if np.ndim(voxel_size) == 0 else voxel_size, (3,)).tolist()
        if min(voxel_size) <= 0:
            raise ValueError("voxel_size: expected numbers above 0")
    if bounds is not None:
        bounds = corners(bounds)
    if bounds is not None and like is not None:
        raise ValueError("bounds and like exclude each other; give one of them")
    if matrix is not None:
        matrix = numbers("matrix", np.asarray(matrix, float)[:3], (3, 4)).ravel().tolist()
    if basis not in ("box", "trilinear", "cubic"):
        raise ValueError(f"basis={basis!r}: expected box, trilinear or cubic")
    rms = number("rms", rms)
    if not 0 < rms <= 1:
        raise ValueError(f"rms={rms!r}: expected a number above 0, at most 1")
    said = {"voxel_size": voxel_size, "bounds": bounds, "matrix": matrix, "like": "" if like is None else os.fsencode(file_name(like, "like")), "rms": rms,
            "frames": frame_range(frames),
            "grids": grids if isinstance(grids, str) else ",".join(grids or ()), "basis": basis, "partial": False}
    if isinstance(source, Volume):
        said["grids"], said["partial"] = said["grids"] or source.name, source._options["partial"]
    from ._scene_api import _part
    with Listener(progress) as listener:
        _part().resample(os.fsencode(file_name(getattr(source, "path", source), "source")), os.fsencode(file_name(output, "output")), said, size_of("max_memory", max_memory), listener)


def to_bytes(frames, **options):
    """The bytes of a .volute file, with what compress() takes but its path. volute.open() takes them."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "bytes.volute")
        compress(frames, path, **options)
        with builtins.open(path, "rb") as file:
            return file.read()
