# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""What callers give: numbers, and volumes as arrays of any kind."""
import datetime
import decimal
import logging
import numbers
import os
import tempfile

import numpy as np

from . import _core, _vtk_values
from ._errors import InvalidArgument, IoError, TooLarge, about
from ._volume import Frames, _bytes

_log = logging.getLogger("volute")
_METRES = {"m": 1, "metre": 1, "metres": 1, "meter": 1, "meters": 1, "km": 1e3, "cm": 1e-2, "mm": 1e-3}
_SECONDS = {"s": 1, "sec": 1, "second": 1, "seconds": 1, "ms": 1e-3, "min": 60, "minutes": 60, "h": 3600, "hours": 3600}
#: names of dimensions, in the order of an array's axes
_AXES = {"t": ("t", "time"), "z": ("z", "height", "altitude"), "y": ("y",), "x": ("x",), "c": ("c", "channel", "rgb", "component")}


def number(what, value, hint=""):
    """A real number, of Python, NumPy or what NumPy takes for one."""
    return float(_scalar(what, value, f"a number{hint}"))


def _scalar(what, value, expected):
    """A number of Python's. What it is decides its dtype: also an array without axes may be a truth value, a text or a time."""
    try:
        array = np.asanyarray(value)
    except (TypeError, ValueError):
        array = np.empty(2)
    if not array.ndim:
        one = plain_numbers(unmasked(array, what))
        if one.dtype.kind in "iuf":
            return one.item() if one.dtype != np.longdouble else float(one)
        if one.dtype.kind == "O" and not isinstance(one.item(), (str, bytes, bool, np.generic)) and hasattr(one.item(), "__float__"):
            try:
                return float(one.item())
            except (TypeError, ValueError, OverflowError):
                pass
    raise TypeError(f"{what}={value!r}: expected {expected}")


def plain_numbers(values):
    """The array; one of objects that are all numbers, as pandas gives, with a dtype of numbers."""
    if values.dtype.kind != "O":
        return values

    def among(*kinds):
        return all(isinstance(one, kinds) and not isinstance(one, (bool, np.bool_, np.timedelta64)) for one in values.flat)
    try:
        if among(numbers.Integral):
            return values.astype(np.int64)
        return values.astype(float) if among(numbers.Real, decimal.Decimal) else values
    except OverflowError:
        try:
            return values.astype(float)
        except OverflowError:
            return values


def utf8(what, text):
    """A text that a file can hold."""
    try:
        str(text).encode()
    except UnicodeEncodeError:
        raise ValueError(f"{what}={text!r}: expected a text that UTF-8 can hold") from None
    return str(text)


def whole(what, value):
    """A whole number, of Python, NumPy or what NumPy takes for one."""
    found = _scalar(what, value, "a whole number")
    if not np.isfinite(found) or found != int(found):
        raise TypeError(f"{what}={value!r}: expected a whole number")
    return int(found)


def wholes(what, values):
    """Whole numbers, shape (n,)."""
    given, values = values, plain_numbers(np.atleast_1d(unmasked(values, what)))
    if values.ndim != 1 or values.dtype.kind not in "iuf" or not (values == np.round(values)).all():
        raise TypeError(f"{what}={np.asarray(given).tolist()}: expected whole numbers")
    if values.size and not (-1 << 63 <= values.min() and np.isfinite(values).all() and int(values.max()) < 1 << 63):
        raise ValueError(f"{what}: {max(values, key=abs)} is beyond 64 bits; expected numbers up to {(1 << 63) - 1}")
    return values.astype(np.int64)


def frame_range(frames):
    """(first, end, step) of frames that are asked for by their numbers; None stays, and is an open end. Lists of more numbers are refused:
    they may be meant as a range with a step, or as frames."""
    if frames is None:
        return None
    try:
        if isinstance(frames, (range, slice)):
            asked = [frames.start, frames.stop, 1 if frames.step is None else frames.step]
        else:
            asked = [*frames, 1] if np.shape(frames) == (2,) else [0, 0, 0]
        first, end, step = (None if one is None else whole("frames", one) for one in asked)
    except (TypeError, ValueError):
        first, end, step = 0, 0, 0
    from_last = isinstance(frames, slice) and min(first or 0, end or 0) < 0
    if from_last or step < 1 or None not in (first, end) and first >= end:
        raise ValueError(f"frames={frames!r}: expected numbers of frames as (first, end) with first < end, or range(first, end, step) with a step above 0")
    if any(one is not None and abs(one) >= 10**9 for one in (first, end, step)):
        raise ValueError(f"frames={frames!r}: expected numbers of frames below {10**9}")
    return first, end, step


def corners(bounds, region=False):
    """((x0, y0, z0), (x1, y1, z1)) as lists; None stays. region: of something larger, which may be flat, or go on without end."""
    if bounds is None:
        return None
    try:
        values = np.asanyarray(bounds)
    except ValueError:  # ragged
        values = np.empty(0)
    values = plain_numbers(unmasked(values, "bounds"))
    if values.shape != (2, 3) or values.dtype.kind not in "iuf":
        raise ValueError(f"bounds={bounds!r}: expected numbers in the order ((x0, y0, z0), (x1, y1, z1)), two corners")
    low, high = values = values.astype(float)
    if region:
        if not (low <= high).all():
            raise InvalidArgument(f"bounds={values.tolist()}: expected the first corner at or below the second on every axis")
        return values.tolist()
    if not (np.isfinite(values).all() and (low < high).all()):
        raise InvalidArgument(f"bounds={values.tolist()}: expected finite corners, the first below the second on every axis")
    return values.tolist()


def seconds(what, values):
    """Times [s], shape (n,), of numbers or of time differences."""
    values = plain_numbers(np.atleast_1d(unmasked(values, what)))
    if values.dtype.kind == "O" and all(isinstance(one, datetime.timedelta) for one in values.flat):
        values = values.astype("m8[us]")
    kind, unit = values.dtype.kind, np.datetime_data(values.dtype)[0] if values.dtype.kind in "mM" else ""
    if kind == "M":
        raise TypeError(f"{what}: dates ({values.dtype}); expected seconds, or differences of dates: {what} - {what}[0]")
    if values.ndim != 1 or kind not in "iufm" or unit in ("generic", "Y", "M"):
        raise TypeError(f"{what}: values of type {values.dtype}, shape {values.shape}; expected a list of numbers of seconds")
    if kind == "m":
        if np.isnat(values).any():
            raise ValueError(f"{what}: {int(np.isnat(values).sum())} of {len(values)} are no times (NaT)")
        return values / np.timedelta64(1, "s")
    return values.astype(float)


def _decimals(what, values):
    """Of numbers of frames, as files' names have them."""
    values = plain_numbers(np.atleast_1d(unmasked(values, what)))
    if values.dtype.kind != "f" or not np.isfinite(values).all():
        return 0
    places = next((places for places in range(7) if np.allclose(values * 10.0 ** places, np.round(values * 10.0 ** places), 0, 1e-6)), None)
    if places is None:
        raise ValueError(f"{what}={values.tolist()}: expected numbers of at most 6 decimals")
    return places


def _frame_numbers(what, values, decimals=0):
    """Numbers as whole ones of 32 bits, shape (n,): 1.25 of two decimals is 125."""
    if decimals:
        values = np.round(np.asarray(values, float) * 10.0 ** decimals)
    values = wholes(what, values)
    if ((values < -1 << 31) | (values >= 1 << 31)).any():
        raise ValueError(f"{what}: {max(values.tolist(), key=abs)} is beyond 32 bits; expected numbers up to {(1 << 31) - 1}")
    return values


def unmasked(values, what):
    """The values as an array. Masked ones have no meaning here, and what is stored in their place must not become data."""
    values = np.asanyarray(values)
    if isinstance(values, np.ma.MaskedArray):
        masked = int(np.ma.count_masked(values))
        if masked:
            raise ValueError(f"{what}: {masked} of {values.size} values are masked, which means nothing here; fill them with a value that "
                             "stands for them first: array.filled(0)")
    return np.asarray(values)


def _apart(values):
    """(array, its mask) of an array; None: nothing is masked."""
    values = np.asanyarray(values)
    masked = isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values)
    return (np.asarray(values.data), np.ma.getmaskarray(values)) if masked else (np.asarray(values), None)


def _refuse_parts(mask, what):
    """A voxel is there with all of its channels, or not. mask: shape (.., z, y, x, c)"""
    parts = sum(int((voxels.any(axis=-1) != voxels.all(axis=-1)).sum()) for voxels in mask)
    if parts:
        raise ValueError(f"{what}: {parts} voxels are masked in some of their channels alone; a voxel is there or is not: mask all of its channels, or "
                         "fill them first: array.filled(0)")


class _Shown(np.ndarray):
    """Frames of an array for scenes. fresh(): those of now, of one that is masked, or has values that are not finite; None: they are its own."""
    fresh = None


class _Masked:
    """The frames of a masked array (t, z, y, x, c) as floating-point numbers, NaN where they are masked."""

    def __init__(self, array, mask, refuses):
        self._array, self._mask, self._refuses = array, mask, refuses
        self.kind = np.float64 if array.dtype.itemsize >= 4 and array.dtype != np.float32 else np.float32

    def __call__(self, index):
        mask = self._mask[index]
        values, _ = reals(np.where(mask, 0, self._array[index]))
        if self._refuses and not np.isfinite(values).all():
            raise ValueError(_not_finite(index))
        return np.where(mask, np.nan, values).astype(self.kind, copy=False)


def _not_finite(index):
    return f"frame {index} has values that are not finite and not masked; mask them, too: np.ma.masked_invalid(array)"


def reals(values, what="the array"):
    """(array, rounding): the values as real numbers of up to 64 bits, and how far these are at most from them."""
    values = unmasked(values, what)
    if values.dtype.kind not in "fiub":
        hint = {"c": "; take their magnitude (abs) or real part", "O": "; convert them: array.astype(float)", "V": "; take one of the fields"}
        raise TypeError(f"{what}: values of type {values.dtype}; expected real numbers{hint.get(values.dtype.kind, '')}")
    if values.dtype.itemsize <= 8:
        return values, 0.0
    doubles = values.astype(np.float64)
    finite = np.isfinite(doubles)
    return doubles, float(np.max(np.abs(values - doubles)[finite], initial=0))


def five_axes(shape):
    """(t, z, y, x, c) of what an array has: (z,y,x), (t,z,y,x) or (t,z,y,x,c)."""
    shape = tuple(int(n) for n in shape)
    if len(shape) == 3:
        shape = (1,) + shape
    if len(shape) == 4:
        shape += (1,)
    if len(shape) != 5 or shape[4] not in (1, 3) or 0 in shape:
        raise ValueError(f"the array has shape {tuple(shape)}; expected (z, y, x), (t, z, y, x) or (t, z, y, x, c) with 1 or 3 channels, "
                         "none of them empty")
    if max(shape) >= 1 << 31:
        raise TooLarge(f"the array has shape {tuple(shape)}, which is beyond what a volume can hold")
    return shape


def _coordinate(array, dimension):
    """(numbers, unit) of a dimension's coordinate; None: it has none."""
    if dimension not in array.coords:
        return None
    coordinate = array.coords[dimension]
    return np.asarray(getattr(coordinate, "values", coordinate)), getattr(coordinate, "attrs", {}).get("units", "")


def _edges(dimension, places, unit):
    """The outer faces of voxels with these centres [m], and how far they are apart; None: unknown."""
    if places.dtype.kind not in "fiu" or places.ndim != 1:
        raise ValueError(f"coordinate '{dimension}' is of type {places.dtype}; expected numbers in metres, or give bounds")
    if unit and unit not in _METRES:
        raise ValueError(f"coordinate '{dimension}' is in '{unit}'; expected metres, or give bounds")
    places = places.astype(float) * _METRES.get(unit, 1)
    if len(places) == 1:
        return places[0], places[0], None
    steps = np.diff(places)
    step = (places[-1] - places[0]) / (len(places) - 1)
    rounding = 1e-3 * abs(step) + 1e-6 * np.abs(places).max()
    if not np.all(np.abs(steps - step) <= rounding) or step == 0:
        raise ValueError(f"coordinate '{dimension}' is not evenly spaced ({np.abs(steps).min():.4g} to {np.abs(steps).max():.4g} m apart); "
                         "interpolate the array to even voxels, or give bounds")
    low, high = sorted((places[0], places[-1]))
    return low, high, abs(step)


def _bounds(array, names):
    edges = {}
    for axis in "xyz":
        coordinate = _coordinate(array, names[axis])
        if coordinate is not None:
            edges[axis] = _edges(names[axis], *coordinate)
    if not edges:
        return None
    missing = [names[axis] for axis in "xyz" if axis not in edges]
    if missing:
        raise ValueError(f"there are coordinates, but none of {' and '.join(missing)}; add them, or give bounds")
    steps = [step for _, _, step in edges.values() if step]
    halves = [(edges[axis][2] or min(steps, default=1.0)) / 2 for axis in "xyz"]
    digits = 12 - int(np.floor(np.log10(min(halves))))  # those beyond are of sums
    return [[round(float(edges[axis][side] + sign * half), digits) for axis, half in zip("xyz", halves)] for side, sign in ((0, -1), (1, 1))]


def _times(array, names, ending):
    """[s] of each frame; None: unknown."""
    name = names.get("t") or next((name for name in array.coords if str(name).lower() in _AXES["t"] or str(name) == "t" + ending), None)
    coordinate = _coordinate(array, name) if name is not None else None
    if coordinate is None:
        return None
    times, unit = np.atleast_1d(coordinate[0]), coordinate[1]
    if times.dtype.kind == "M":
        times = times - times[0]
    if times.dtype.kind == "m":
        return times / np.timedelta64(1, "s")
    scale = _SECONDS.get(str(unit).split(" since ")[0], 0 if unit else 1)
    if times.dtype.kind not in "fiu" or not scale:
        raise ValueError(f"coordinate '{name}' is of type {times.dtype}{' in ' + repr(unit) if unit else ''}; expected seconds, or give times")
    return times * float(scale)


def _ending(array):
    """What the names of its dimensions have behind the axes, as volute.xarray gives them: "_velocity" of x_velocity; "" where they have nothing."""
    endings = {str(dimension)[1:] for dimension in array.dims if str(dimension).lower() not in _AXES["c"]}
    return endings.pop() if len(endings) == 1 and all(str(dimension)[:1] in _AXES for dimension in array.dims) else ""


def _axis_of(array, dimension, ending):
    """By its name, or by what CF calls the axis of its coordinate; None: unknown."""
    name = str(dimension)
    found = next((axis for axis, known in _AXES.items() if name.lower() in known), None)
    if found is None and ending.startswith("_") and name.endswith(ending):
        found = name[:-len(ending)]
    if found is None and dimension in array.coords:
        stated = str(getattr(array.coords[dimension], "attrs", {}).get("axis", "")).lower()
        found = stated if stated in ("t", "z", "y", "x") else None
    return found


def _along(array, dimension, name):
    """The values of a coordinate of this name for each place along a dimension, or for the only one; None: it has none."""
    coordinate = array.coords[name] if name in array.coords else None
    return None if coordinate is None or tuple(coordinate.dims) not in ((dimension,), ()) else np.atleast_1d(np.asarray(coordinate.values))


def _ascending(numbers):
    """Numbers of frames; None where they were computed with: a mean over frames has none."""
    try:
        whole_ones = _frame_numbers("frame_number", numbers, _decimals("frame_number", numbers)) if numbers is not None else ()
    except (TypeError, ValueError):
        return None
    return numbers if len(whole_ones) and (np.diff(whole_ones) > 0).all() else None


def labelled(array, given):
    """(array of axes (t, z, y, x, c), what its labels say) of an xarray.DataArray. `given`: what the caller says in place of labels."""
    names = {}
    ending = _ending(array)
    unnamed = [dimension for dimension in array.dims if _axis_of(array, dimension, ending) is None]
    for dimension in array.dims:
        axis = _axis_of(array, dimension, ending)
        if axis is None or axis in names:
            example = next((f", as array.rename({one}='{str(one)[0].lower()}')" for one in unnamed if str(one)[:1].lower() in _AXES and str(one).isidentifier()), "")
            raise ValueError(f"the array has the dimensions {tuple(array.dims)}; expected z, y, x, with t (or time) and c (or channel) if there "
                             f"are any: rename them{example}")
        names[axis] = dimension
    missing = [axis for axis in "zyx" if axis not in names]
    if missing:
        raise ValueError(f"the array has the dimensions {tuple(array.dims)}, and no {' and '.join(missing)}; add them: "
                         f"array.expand_dims('{missing[0]}')")
    ordered = [axis for axis in _AXES if axis in names]
    data = array.transpose(*(names[axis] for axis in ordered)).data
    for place, axis in enumerate(ordered):
        coordinate = _coordinate(array, names[axis]) if axis in "xyz" else None
        if coordinate is not None and len(coordinate[0]) > 1 and coordinate[0].dtype.kind in "fiu" and coordinate[0][0] > coordinate[0][-1]:
            data = data[(slice(None),) * place + (slice(None, None, -1),)]
    if "t" not in names and "c" in names:
        data = data[np.newaxis]
    said = {"name": getattr(array, "name", None), "unit": getattr(array, "attrs", {}).get("units")}
    said["bounds"] = _bounds(array, names) if given.get("bounds") is None else None
    said["times"] = _times(array, names, ending) if given.get("times") is None else None
    said["frame_numbers"] = _ascending(_along(array, names.get("t"), "frame_number" + ending))
    attributes = getattr(array, "attrs", {})
    if attributes.get("up") in ("x", "y", "z"):
        said["up"] = attributes["up"]
    if "max_error" in attributes and "relative_rms_error" in attributes:  # of a .volute
        low, high = np.ravel(attributes.get("value_range", (0, np.inf)))
        most, rms = float(attributes["max_error"]), float(attributes["relative_rms_error"]) * ((high - low) or 1)
        if np.isfinite(most):
            said["source_max_error"], said["source_rms"] = most, rms if rms < most else most
    return data, {key: value for key, value in said.items() if value is not None}


def _in_memory(values):
    """The array behind it, where that is in memory or in a file that is mapped; None: its values are to be computed or fetched."""
    if isinstance(values, np.ndarray):
        return values
    try:
        return np.asarray(memoryview(values))
    except TypeError:
        return None


def _slabs(array):
    """Numbers of frames that come at once at little more cost than one."""
    count = array.shape[0]
    chunks = getattr(array, "chunks", None)
    first = chunks[0] if chunks else 1
    if isinstance(first, (int, np.integer)):
        first = [int(first)] * -(-count // int(first))
    begin = 0
    for size in first:
        yield begin, min(begin + int(size), count)
        begin += int(size)


def _pieces(values):
    """What is computed, fetched or handed over one after the other, as frames of axes (z, y, x[, c])."""
    if not hasattr(values, "shape") or not hasattr(values, "__getitem__"):
        try:
            yield from values
        except TypeError as error:
            if "not iterable" not in str(error):
                raise
            raise TypeError(f"{values!r}: expected an array of shape (t, z, y, x), or frames") from None
    elif len(values.shape) not in (3, 4, 5):
        five_axes(values.shape)  # says what is wrong
    elif len(values.shape) == 3:
        yield _computed(values)
    else:
        for begin, end in _slabs(values):
            yield from _computed(values[begin:end]) if end - begin > 1 else [_computed(values[begin])]


def _computed(values):
    return values.compute() if hasattr(values, "compute") else values


def _append(file, array, folder):
    left = memoryview(array.reshape(-1).view(np.uint8))
    try:
        while left:
            left = left[file.write(left):]
    except OSError as error:
        with about(folder):
            raise IoError(f"{folder}: cannot write a temporary file: {error.strerror}") from None


def _spool(values, folder, masked, refuses):
    """(array, rounding, whether something was masked) of frames that come once, in a file without a name: compression asks for them more
    than once. masked: what stands for a masked value. refuses: values that are not finite, beside masked ones."""
    count, shape, kept, rounding, masks, wrong = 0, None, None, 0.0, False, None
    with tempfile.TemporaryFile(dir=folder, buffering=0) as file:
        for frame in _pieces(values):
            frame, mask = _apart(frame)
            if mask is not None and mask.ndim == 4:
                _refuse_parts(mask, f"frame {count}")
            frame, before = reals(frame if mask is None else np.where(mask, 0, frame), f"frame {count}")
            if frame.ndim not in (3, 4):
                raise ValueError(f"frame {count} has shape {frame.shape}; expected (z, y, x) or (z, y, x, c)")
            if shape is None:
                shape = frame.shape
                _log.info("frames are kept in a file without a name in %s, %s each, until the compressed one is written", folder,
                          _bytes(4 * frame.size))
            if frame.shape != shape:
                raise ValueError(f"frame {count} has shape {frame.shape}; those before it have {shape}")
            if kept is None:
                kept = np.float64 if frame.dtype in (np.float64, np.int32, np.uint32) else np.float32
            exact = kept is np.float64 and (frame.dtype.kind == "f" or frame.dtype.itemsize <= 4)
            numbers, after = (frame, 0.0) if exact else _core.to_float32(frame)
            rounding = max(rounding, before + after)
            if wrong is None and refuses and not np.isfinite(numbers).all():
                wrong = count
            if mask is not None:
                masks, numbers = True, np.where(mask, masked, numbers)
            _append(file, np.ascontiguousarray(numbers, kept), folder)
            count += 1
        if not count:
            raise ValueError("there are no frames")
        if 0 in shape:
            five_axes((count,) + shape)  # says what is wrong
        if masks and wrong is not None:
            raise ValueError(_not_finite(wrong))
        return np.memmap(file, kept, "r", shape=(count,) + shape), rounding, masks


class Function:
    """A function of place and time as a volume: its values at the centres of voxels, at the times of frames. Scenes ask it for the
    frames that they show; compress() asks once for all.

    value(x, y, z, t) is given arrays of shape (n,) [m] and a number [s], and returns finite values of shape (n,), or (n, 3) with
    three channels. It may be asked for the same places again. What it raises ends the call that asked.
    shape: (z, y, x) voxels. bounds: their outer faces, ((x0, y0, z0), (x1, y1, z1)) [m]. times: [s], ascending."""

    def __init__(self, value, shape, *, bounds, times=(0.0,), channels=1, name=None, unit=None):
        if not callable(value):
            raise TypeError(f"value={value!r}: expected a function of x, y, z and t")
        if np.ndim(shape) != 1 or len(shape) != 3:
            raise ValueError(f"shape={shape!r}: expected (z, y, x)")
        self.value = value
        self.times = seconds("times", times).tolist()
        #: (t, z, y, x), and the channels if there are three
        self.shape = five_axes((len(self.times), *(whole("shape", side) for side in shape), whole("channels", channels)))
        self.bounds, self.name, self.unit = corners(bounds), name, unit
        if self.shape[4] == 1:
            self.shape = self.shape[:4]

    def __getitem__(self, index):
        """The frame of a number, shape (z, y, x[, 3])."""
        sides, low, high = self.shape[1:4], *map(np.asarray, self.bounds)
        count, values = int(np.prod(sides)), None
        for begin in range(0, count, 1 << 15):
            end = min(begin + (1 << 15), count)
            places = [low[2 - axis] + (number_of + 0.5) * (high - low)[2 - axis] / sides[axis]
                      for axis, number_of in enumerate(np.unravel_index(np.arange(begin, end), sides))]
            part = self._values(*places[::-1], self.times[index])
            if values is None:
                values = np.empty((count,) + self.shape[4:], part.dtype)
            values = values.astype(np.promote_types(values.dtype, part.dtype), copy=False)
            values[begin:end] = part
        return values.reshape(self.shape[1:])

    def __len__(self):
        return self.shape[0]

    def __repr__(self):
        times = f"{self.times[0]:g} to {self.times[-1]:g} s" if len(self) > 1 else f"{self.times[0]:g} s"
        z, y, x = self.shape[1:4]
        return f"<volute.Function {getattr(self.value, '__name__', 'value')}: {len(self)} frame{'s' * (len(self) != 1)} of {x} x {y} x {z} voxels, {times}>"

    def _values(self, x, y, z, t):
        """As the function gives them: compress() counts how far they are rounded."""
        values = unmasked(self.value(x, y, z, t), "the function's values")
        reals(values, "the function's values")
        expected = x.shape + self.shape[4:]
        if values.shape != expected:
            raise ValueError(f"the function returned shape {values.shape}; expected {expected}")
        wrong = np.argwhere(~np.isfinite(values))
        if len(wrong):
            i = wrong[0][0]
            raise ValueError(f"the function is {values[tuple(wrong[0])]} at ({x[i]:g}, {y[i]:g}, {z[i]:g}) m, {t:g} s; expected finite values")
        return values


def _without(array, not_finite):
    """The array with 0 in place of what is not finite, where that is asked for."""
    if not_finite == "refuse" or array.dtype.kind != "f" or np.isfinite(array).all():
        return array
    return np.where(np.isfinite(array), array, array.dtype.type(0))


def _shown(values, shape, not_finite):
    """Its frames, with 0 in place of what is masked, and of what is not finite where that is asked for."""
    array, mask = _apart(values)
    reals(array[:0])  # says what is wrong with its type
    if mask is not None:
        _refuse_parts(mask.reshape(shape), "the array")
        array = np.where(mask, 0, array)
    shown = reals(_without(array, not_finite))[0].reshape(shape).view(_Shown)
    shown.fresh = lambda: _shown(values, shape, not_finite)
    return shown


def check_not_finite(not_finite):
    if not_finite not in ("refuse", "inactive", "background"):
        raise ValueError(f"not_finite={not_finite!r}: expected 'refuse', 'inactive' or 'background'")


def volume(values, given, folder, lazily=False, not_finite="refuse"):
    """(frames, shape, said, rounding): what _core takes of any volume. `frames`: an array (t, z, y, x, c), or a function that gives
    each frame; `said`: what the volume says of itself, and `given` in place of it; `rounding` of what _core is given. lazily, for
    scenes: a Function is handed on as it is, and masked values are 0. Else they are NaN, and said["masked"] tells so; said["doubles"]
    tells that a function gives doubles."""
    check_not_finite(not_finite)
    said, refuses = {}, not_finite == "refuse" and not lazily
    if isinstance(values, (str, os.PathLike)):
        raise TypeError(f"{os.fspath(values)!r} is a path, and no array; volute.open() opens .volute files, other libraries other arrays")
    of_itself = getattr(values, "_of_itself", None)  # a Reconstruction
    if of_itself is not None:
        values, said = of_itself()
    if isinstance(values, Frames):
        if values.matrices is not None and given.get("bounds") is None:
            raise ValueError(f"{values.path}: '{values.name}' is turned, sheared or mirrored, or moves by parts of a voxel, which an array cannot say; "
                             "volute.resample() lays it along the axes, or give bounds")
        said = {key: getattr(values, key) for key in ("bounds", "times", "frame_numbers", "name", "unit", "basis", "up")}
        frames, shape, rounding = values.__getitem__, five_axes(values.shape), 0.0
    elif isinstance(values, Function) and lazily:
        said = {key: getattr(values, key) for key in ("bounds", "times", "name", "unit")}
        frames, shape, rounding = values, five_axes(values.shape), 0.0
    else:
        if isinstance(values, Function):
            said = {key: getattr(values, key) for key in ("bounds", "times", "name", "unit")}
        if hasattr(values, "data_vars"):
            raise TypeError(f"a Dataset has several arrays; give one of {', '.join(map(repr, values.data_vars))}: dataset[name]")
        if hasattr(values, "keys") and not hasattr(values, "shape"):
            raise TypeError(f"a {type(values).__name__} has arrays by name; give one of {', '.join(map(repr, values.keys())) or 'them, of which there are none'}")
        if hasattr(values, "dims") and hasattr(values, "coords"):
            values, said = labelled(values, given)
        if _vtk_values.is_image(values):
            values, said = _vtk_values.image(values, given.get("name"))
        array = _in_memory(values)
        if array is None:
            array, rounding, masks = _spool(values, folder, 0 if lazily else np.nan, refuses)
            if lazily or not_finite == "background":
                array = _without(array, not_finite)
            shape, mask = five_axes(array.shape), None
            said["masked"] = masks and not lazily
        else:
            shape = five_axes(array.shape)
            if lazily and (isinstance(array, np.ma.MaskedArray) or not_finite != "refuse"):
                array, mask, rounding = _shown(array, shape, not_finite), None, 0.0
            else:
                array, mask = _apart(array)
                if mask is None and not_finite == "background":
                    array = _without(array, not_finite)
                array, rounding = (array, 0.0) if mask is not None else reals(array)
        frames = array if isinstance(array, _Shown) else array.reshape(shape)
        if mask is not None:
            reals(array[:0])  # says what is wrong with its type
            _refuse_parts(mask.reshape(shape), "the array")
            frames = _Masked(frames, mask.reshape(shape), refuses)
            said["masked"], said["doubles"] = True, frames.kind is np.float64
    said.update((key, value) for key, value in given.items() if value is not None)
    for key in ("name", "unit"):
        said.setdefault(key, "")
    return frames, shape, checked(said, shape[0]), rounding


def checked(said, frames):
    """What is said of a volume of so many frames, as _core takes it."""
    if "frame_numbers" in said:
        said["decimals"] = _decimals("frame_numbers", said["frame_numbers"])
    for key, convert in (("times", seconds), ("frame_numbers", lambda what, values: _frame_numbers(what, values, said["decimals"]))):
        if key not in said:
            continue
        said[key] = convert(key, said[key]).tolist()
        if len(said[key]) != frames:
            raise ValueError(f"{key}: {len(said[key])} of them for {frames} frames")
    for key in ("name", "unit"):
        if key in said:
            said[key] = utf8(key, said[key] or "")
    said["bounds"] = corners(said.get("bounds"))
    if said.get("basis") not in (None, "box", "trilinear", "cubic"):
        raise ValueError(f"basis={said['basis']!r}: expected 'box', 'trilinear' or 'cubic'")
    return said


def plain(value):
    """A default of json.dumps: NumPy's numbers and arrays as the numbers that they are, paths as text."""
    if isinstance(value, np.floating):
        return float(value)  # a longdouble's item() is one itself
    if isinstance(value, np.generic) and not isinstance(value.item(), np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return unmasked(value, "an array in a scene").tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{value!r} is of type {type(value).__name__}; scenes have numbers, texts, lists and dicts")
