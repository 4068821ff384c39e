# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Kinds of media that a program makes itself."""
import dataclasses
import inspect
import os

import numpy as np

from ._arrays import number, unmasked
from ._progress import Listener
from ._scene_api import _part, _text


@dataclasses.dataclass
class Member:
    """A member of a kind's entries in scenes: a number, or several."""
    usual: object = 0.0  #: its default: a number, or a sequence of up to 16
    unit: str = ""
    help: str = ""
    minimum: object = None  #: of each number
    maximum: object = None


#: what a kind's methods are given, and what its pieces() returns: types of structured arrays
SEGMENT = np.dtype([("origin", float, 3), ("direction", float, 3), ("begin", float), ("end", float)])
PIECE = np.dtype([("segment", np.uint64), ("begin", float), ("end", float), ("extinction", float, 4), ("emission", float, (3, 4)), ("decay", float)])


def pieces(segment, begin, end, extinction=0.0, emission=0.0, decay=0.0):
    """An array of the type PIECE, shape (n,).

    segment: numbers of segments, shape (n,), those of one from front to back. begin, end: [m], shape (n,) or (). extinction [1/m]:
    shape (n,) or (), or (n, 4) for a polynomial of u = s - begin, lowest first. emission [radiance/m]: shape (n,) or (), (n, 3) for
    linear RGB, or (n, 3, 4) for polynomials. decay [1/m]: both are times exp(-decay u)."""
    segment = np.atleast_1d(np.asarray(unmasked(segment, "segment")))
    made = np.zeros(segment.shape, PIECE)
    made["segment"], made["begin"], made["end"], made["decay"] = segment, begin, end, decay
    extinction, emission = np.asarray(extinction, float), np.asarray(emission, float)
    made["extinction"][:, :1 if extinction.ndim < 2 else None] = extinction[..., np.newaxis] if extinction.ndim < 2 else extinction
    if emission.ndim == 3:
        made["emission"] = emission
    else:
        made["emission"][:, :, 0] = emission if emission.ndim == 2 else emission[..., np.newaxis]
    return made


def _said(name, member):
    member = member if isinstance(member, Member) else Member(member)
    usual = [number(name, one) for one in np.atleast_1d(np.asarray(member.usual, float)).ravel()]
    low, high = (number(name, limit) if limit is not None else None for limit in (member.minimum, member.maximum))
    if low is None and high is None:
        low, high = 0.0, 0.0
    return (name, member.help, member.unit, usual, -np.inf if low is None else low, np.inf if high is None else high)


def medium(name, sentence="", *, members=None, ending=""):
    """Registers a class as a kind of medium: scenes of this process may have {"kind": name} from then on (docs/own-media.md).

        @volute.medium("ball", "an even ball of smoke", members={"radius": volute.Member(1.0, "m", minimum=1e-3)})
        class Ball:
            def __init__(self, radius): ...
            def bounds(self): return (-1, -1, -1), (1, 1, 1)        # over all times [m]
            def pieces(self, segments, time): return volute.pieces(..)

    members: {name: Member or default}, what __init__ takes, and what its entries in scenes may have. ending: ".ball" of files
    that are shown alone, then __init__ takes `file`, too. pieces() is called from several threads, with an array of the type
    SEGMENT, shape (n,), and a time [s]. Optional are `times` [s], between which it changes, optical_depth(segments, time) of
    shape (n,), and values(points, time): extinction of shape (n,), or it and emission of shape (n, 3), at points of shape (n, 3).
    What they raise ends the call that needed them."""
    said = [_said(key, member) for key, member in (members or {}).items()]

    def register(cls):
        for method in ("bounds", "pieces"):
            if not callable(getattr(cls, method, None)):
                raise TypeError(f"{cls.__name__} has no method {method}()")
        text = sentence or (inspect.getdoc(cls) or f"a medium of kind '{name}'").splitlines()[0].rstrip(".")
        _part().register_kind(name, text, ending, said, cls)
        return cls

    return register


def check_medium(entry, time=0.0, *, folder=".", progress=None):
    """What the conformance suite finds wrong with the media of an entry ({"kind": "ball", "radius": 2}) or a scene at a time:
    sentences, none if all is well. It compares pieces, optical depths and values with each other and with quadrature, on segments
    that are long, short, reversed, split, grazing and empty."""
    scene = entry if "media" in entry else {"format": "volute-scene-2", "media": [entry]}
    with Listener(progress) as listener:
        return _part().check_medium(_text(scene), os.path.join(os.fspath(folder), "scene.json"), number("time", time), listener)
