# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Scenes, pictures, lines of sight, and volumes from pictures."""
import base64
import dataclasses
import html
import json
import os
import tempfile

import numpy as np

from . import _vtk_values
from ._arrays import corners, frame_range, number, plain, unmasked, utf8, volume, whole, wholes
from ._compress import compress
from ._errors import InvalidArgument, NotFound, about
from ._lines import Lines
from ._mesh import Mesh
from ._progress import Listener
from ._volume import Frames, _Closed, _png, file_name, open as _open, size_of

#: what a call says of a volume in memory, and not of its appearance
_OF_VALUES = ("bounds", "times", "frame_numbers", "name", "unit", "not_finite")


def _part():
    """The extension module, which a package of its own may hold."""
    try:
        from . import _scene
    except ImportError as error:
        raise ImportError(f"scenes and pictures need volute._scene, which cannot be loaded ({error}); install python3-volute-render") from error
    return _scene


def _text(said):
    """JSON. NumPy's numbers and arrays are numbers."""
    try:
        text = json.dumps(said, default=plain, allow_nan=False, ensure_ascii=False)
    except ValueError as error:
        if "JSON compliant" not in str(error):
            raise
        raise ValueError("a number is not finite; scenes have finite numbers") from None
    return utf8("a text in a scene", text)


def _points(points):
    points = np.asarray(unmasked(points, "points"), float)
    return points.reshape(1, 3) if points.shape == (3,) else points


def _is_values(source):
    """Whether it is a volume in memory, or one that comes from a program, and not a file's name."""
    return not isinstance(source, (str, bytes, os.PathLike, dict, Frames))


class _Volumes:
    """Volumes in memory, under the names by which a scene's entries have them as files."""

    def __init__(self):
        self._count = 0
        self._kept = []
        self._sources = []  # files that are there as long as these are

    def add(self, values, given):
        """The name of a volume. What is computed is kept in a file without a name."""
        not_finite = given.pop("not_finite", None) or "refuse"
        frames, shape, said, _ = volume(values, given, tempfile.gettempdir(), lazily=True, not_finite=not_finite)
        return self.again(frames, shape, said)

    def again(self, frames, shape, said):
        """The same under a new name."""
        name = str(self._count)
        self._count += 1
        self._kept.append((name, frames, shape, said))
        return "memory:" + name

    def take(self):
        """Those that were added since the last call."""
        kept, self._kept = self._kept, []
        return kept

    def source(self, source, members):
        """(file, members of its entry) of anything that Scene() takes but dicts."""
        if isinstance(source, Lines):
            source = reconstruct(source)
        if isinstance(source, Reconstruction) and isinstance(source.values, Frames):
            source = source.values
        if _vtk_values.is_grid(source):
            source = Mesh(source)
        if isinstance(source, Mesh):
            return self.again(source, None, None) + ".vtu", members
        if isinstance(source, Frames):
            self._sources.append(source)
            if getattr(source, "name", None) and len(getattr(source, "grids", ())) > 1:
                members = {"field": source.name, **members}
            as_members = getattr(source, "_as_members", None)  # an FDS case
            return source.path, {**as_members(), **members} if as_members else members
        if not _is_values(source):
            return file_name(source, "source"), members
        given = {key: members.get(key) for key in _OF_VALUES}
        return self.add(source, given), {key: value for key, value in members.items() if key not in _OF_VALUES}

    def scene(self, said):
        """A scene whose volumes may have values in place of a file's name."""
        if not isinstance(said, dict) or not isinstance(said.get("media"), (list, tuple)):
            return said
        media = []
        for entry in said["media"]:
            if isinstance(entry, dict) and _vtk_values.is_grid(entry.get("case")):
                entry = {**entry, "case": Mesh(entry["case"])}
            if isinstance(entry, dict) and isinstance(entry.get("case"), (Mesh, Frames)):
                case, members = self.source(entry["case"], {})
                entry = {"kind": "smoke", **members, **entry, "case": case}
            if isinstance(entry, dict) and "file" in entry and not isinstance(entry["file"], (str, bytes, os.PathLike)):
                if _is_values(entry["file"]) and entry.get("kind", "volume") != "volume":
                    raise ValueError(f"/media/{len(media)}/kind: {entry['kind']!r} with an array as its file; arrays are of kind 'volume'")
                file, members = self.source(entry["file"], {key: value for key, value in entry.items() if key not in ("file", "kind")})
                entry = {"kind": entry.get("kind", "volume"), "file": file, **members}
            media.append(entry)
        return {**said, "media": media}


def _choice(what, value, choices, hint=""):
    if value is not None and value not in choices:
        raise ValueError(f"{what}={value!r}: expected {' or '.join(map(repr, choices))}{hint}")
    return value


def _view(camera, size, background):
    """What all pictures take."""
    if size is not None:
        if np.shape(size) != (2,):
            raise ValueError(f"size={size!r}: expected (width, height)")
        width, height = size
        size = (whole("size", width), whole("size", height))
        if not (1 <= min(size) and max(size) <= 32768):
            raise InvalidArgument(f"size: {size[0]} x {size[1]} pixels; expected 1 to 32768 on each side")
    if background is not None:
        if np.shape(background) != (3,):
            raise ValueError(f"background={background!r}: expected (r, g, b)")
        background = tuple(number("background", one) for one in background)
    return {"camera": None if camera is None else _text(camera), "size": size, "background": background}


def _look(exposure, tone, samples, bloom, colormap, legend, shutter):
    """How light becomes a picture."""
    exposure = None if exposure in (None, "auto") else number("exposure", exposure)
    if exposure is not None and not (0 < exposure < float("inf")):
        raise ValueError(f"exposure={exposure!r}: expected a number above 0, or 'auto'")
    samples = whole("samples", samples)
    if not 1 <= samples <= 256:
        raise ValueError(f"samples={samples}: expected 1 to 256")
    bloom = number("bloom", bloom)
    if not 0 <= bloom <= 1:
        raise ValueError(f"bloom={bloom}: expected 0 to 1")
    shutter = number("shutter", shutter)
    if not 0 <= shutter <= 1:
        raise ValueError(f"shutter={shutter}: expected 0 to 1, of the time to the next frame")
    return {"exposure": exposure, "tone": None if tone is None else str(tone), "samples": samples,
            "bloom": bloom, "shutter": shutter, "colormap": _choice("colormap", None if colormap == "grey" else colormap, ("viridis", "inferno")), "legend": legend}


def _maker_of(volumes, source, folder, members):
    """(how, (file or scene, ..)) of what the extension makes a scene of."""
    if isinstance(source, dict):
        if members:
            raise TypeError(f"{', '.join(members)}: members are for a single file; write them into the scene")
        return "make", (_text(volumes.scene(source)), os.path.join(os.fspath(folder), "scene.json"))
    for key in ("file", "case"):
        if key in members:
            raise TypeError(f"{key}={members[key]!r}: what is shown is the first argument; leave it out")
    file, members = volumes.source(source, members)
    return "open", (file, _text(members))


def _fresh(frames):
    """Of an array, as it is now."""
    again = getattr(frames, "fresh", None)
    return again() if again else frames


def _made(kind, source, options):
    return kind(source, **options)


class Scene:
    """A scene: media, surfaces, lights, signs and a camera.

    Made from
    - a scene file (.json), or any other file that Volute shows (.volute, .npy, .npz, .vdb, .vti, .pvd, .vtu, .smv, a map of fog);
    - a volute.Volume or an FDS case that is open, a volute.Mesh, a vtkImageData or vtkUnstructuredGrid, volute.Lines, or what
      reconstruct() gives;
    - an array of shape (z,y,x), (t,z,y,x) or (t,z,y,x,c), or anything else that compress() takes as `frames`, with bounds, times, name
      and unit as arguments as there. Arrays in memory are not copied: after a change of their values call touch();
    with the members of a scene's entry as arguments: Scene(array, bounds=((0, 0, 0), (2, 2, 2)), emission=2.0); or from
    - a dict of the form of a scene file (docs/scene.md), where "file" of a volume may be such an array, too, and "case" of smoke a Mesh.
    Threads may share one; pictures are rendered one at a time."""

    def __init__(self, source, *, folder=".", max_memory=4 << 30, progress=None, **members):
        """folder: where a dict's file names are found."""
        self._volumes = _Volumes()
        self._max_memory = size_of("max_memory", max_memory)
        self._given = source, {"folder": os.path.abspath(folder), "max_memory": self._max_memory, **members}
        self._maker = _maker_of(self._volumes, source, folder, members)
        self._added = self._volumes.take()
        self._told = set()  # what pictures said: not again with each
        self._open(progress)

    def __reduce__(self):
        self._scene.path  # says that it is closed
        return _made, (type(self), *self._given)

    def _open(self, progress):
        try:
            self._scene, self._shown, self._deep, self._unclear = self._opened(True, progress), None, None, None
        except InvalidArgument as error:
            # Which grid is to be measured may not be clear where it is clear what to show.
            self._scene = self._shown = self._opened(False, progress)
            self._deep, self._unclear = None, error

    def _opened(self, measured, progress, depth=False):
        """For measurements, those of optical depths among them, or as it is shown."""
        name, (first, second) = self._maker
        said = (os.fsencode(first), second) if name == "open" else (first, os.fsencode(second))
        with Listener(progress) as listener:
            return getattr(_part().Scene, name)(*said, self._added, measured, depth, self._max_memory, listener)

    def _pictured(self, progress=None):
        """The same as it is shown, opened when it is first asked for."""
        if self._shown is None:
            self._scene.path  # says that it is closed
            self._shown = self._opened(False, progress)
        return self._shown

    @classmethod
    def open(cls, path, **options):
        """As Scene(path, ..)."""
        return cls(path, **options)

    def close(self):
        """Closes its files and lets go of its arrays; what is asked of it then is a ValueError. `with` calls it."""
        self._scene, self._shown, self._deep, self._added, self._volumes = _Closed("the scene"), None, None, [], _Volumes()
        self._given = None

    def __enter__(self):
        return self

    def __exit__(self, *what):
        self.close()

    @property
    def path(self):
        return self._scene.path

    @property
    def json(self):
        """The scene as a dict; change() accepts another. Arrays have names there, as "memory:0", which stand for them until the scene is
        changed to one without them."""
        return json.loads(self._scene.json)

    @property
    def bounds(self):
        """((x0, y0, z0), (x1, y1, z1)) around the visible content [m]"""
        return self._scene.bounds

    @property
    def times(self):
        """Times of its frames [s], shape (t,)"""
        return np.asarray(self._scene.times)

    @property
    def media(self):
        """(kind, file, size) of each medium."""
        return self._scene.media

    def change(self, new, progress=None):
        """Changes the scene to the dict; data already read are reused where entries do not change. An array in it is read anew, so that
        one whose values have changed is given again. The scene lets go of arrays that are no longer in it: to go back to a former `json`,
        give the arrays themselves in it. An error leaves the scene unchanged."""
        self._scene.path  # says that it is closed
        given, new = new, _text(self._volumes.scene(new))
        more = self._volumes.take()
        self._refuse_unknown(new, self._added + more)
        with Listener(progress) as listener:
            try:
                self._scene.change(new, more, listener)
            except BaseException:
                self._scene.keep([one[0] for one in self._added])
                raise
        self._keep_named(new, self._added + more)
        self._maker, self._shown, self._deep, self._told = ("make", (new, self._scene.path)), None, None, set()
        self._given = given, {"folder": os.path.dirname(os.path.abspath(self._scene.path)), "max_memory": self._max_memory}
        if self._unclear:
            self._open(progress)

    @staticmethod
    def _refuse_unknown(said, added):
        """Names of arrays that the scene does not have, or has let go of."""
        media = json.loads(said)
        media = media.get("media") if isinstance(media, dict) else None
        known = {"memory:" + one[0] for one in added}
        for at, entry in enumerate(media if isinstance(media, list) else []):
            for key in ("file", "case"):
                name = os.path.basename(str(entry.get(key, ""))) if isinstance(entry, dict) else ""
                if name.startswith("memory:") and os.path.splitext(name)[0] not in known:
                    error = NotFound(f"/media/{at}/{key}: the scene has no array {name!r}: it lets go of arrays that change() or touch() replaced; "
                                     "give the array itself")
                    error.member = f"/media/{at}/{key}"
                    raise error

    def _keep_named(self, said, added):
        """Of volumes in memory, those that the scene names, and no others."""
        named = {os.path.splitext(os.path.basename(str(entry.get(key, ""))))[0] for entry in json.loads(said)["media"] for key in ("file", "case")}
        self._added = [one for one in added if "memory:" + one[0] in named]
        self._scene.keep([one[0] for one in self._added])

    def touch(self, name=None, progress=None):
        """Reads anew: for arrays whose values have changed in their place, and functions that give others. name: of the one that has
        changed, as it was given with `name`, or as scene.json has it ("memory:0"); None: all."""
        self._scene.path  # says that it is closed
        self._added = [(at, _fresh(frames), shape, said) for at, frames, shape, said in self._added]
        if name is not None:
            known = {f"memory:{at}": said["name"] or "density" for at, _, _, said in self._added if said}
            changed = [file for file, own in known.items() if name in (file, own)]
            if not changed:
                raise ValueError(f"name={name!r}: expected {' or '.join(repr(own) for own in sorted({*known, *known.values()})) or 'a scene of arrays'}")
            if self._maker[0] == "make":
                return self._touch(changed, progress)
        self._open(progress)

    def _touch(self, changed, progress):
        """Others stay as they were read: these get other names."""
        scene = self.json
        for entry in scene["media"]:
            if os.path.basename(str(entry.get("file"))) in changed:
                _, frames, shape, said = next(one for one in self._added if os.path.basename(entry["file"]) == "memory:" + one[0])
                entry["file"] = self._volumes.again(frames, shape, said)
        more, said = self._volumes.take(), _text(scene)
        with Listener(progress) as listener:
            for opened in [self._scene] + [self._shown] * (self._shown not in (None, self._scene)):
                opened.change(said, more, listener)
                opened.keep([one[0] for one in self._added + more if "memory:" + one[0] not in changed])
        self._deep = None
        self._added = [one for one in self._added if "memory:" + one[0] not in changed] + more
        self._maker = "make", (said, self._scene.path)

    def render(self, time=0.0, *, camera=None, size=None, renderer="cpu", aov=None, background=None, measured=True, progress=None):
        """Light at `time` [s]: linear RGB, float32, shape (height, width, 3), row 0 at the top.

        camera: a dict as in scenes: {"eye": [x,y,z], "target": [x,y,z], "fov": degrees} or "ortho": height [m], "up", "size";
            default the scene's, else one that frames the scene. size: (width, height) [pixels], default the camera's or 800 x 600.
        renderer: "cpu"; "gl", by OpenGL 4.5, a context for each call; or "reference", in double. aov: "optical-depth" or "transmittance" instead of light, shape (height, width);
            where no extinction is stated it is as the unit of the values says, of a file or array alone without a unit 1, as for `volute render --aov`.
        background: (r, g, b) instead of the scene's. progress: a function (stage, done, total), or True for a bar.
        measured: one ray through each pixel's centre, the file's own basis, as `volute render --measured`; False: as a picture is made,
            with the appearance that a file alone has, and smooth edges: the .exr of `volute render`. time=None: as in picture()."""
        _choice("renderer", renderer, ("cpu", "gl", "reference"))
        _choice("aov", aov, ("optical-depth", "transmittance"))
        said = {"time": None if time is None else number("time", time), "aov": aov, "measured": bool(measured), "renderer": renderer,
                **_view(camera, size, background)}
        if measured and self._unclear:
            raise self._unclear
        scene = self._scene if measured else self._pictured(progress)
        self._scene.path  # says that it is closed
        if aov is not None and (self._maker[0] == "open" or any(one.get("kind") == "volume" and "extinction" not in one for one in self.json.get("media", []))):
            self._deep = scene = self._deep or self._opened(True, progress, depth=True)
        with Listener(progress, self._told) as listener:
            return scene.render(said, listener)

    def picture(self, time=None, *, camera=None, size=None, background=None, exposure=None, tone=None, samples=8, bloom=0.0, colormap=None,
                legend=None, shutter=0.0, renderer="cpu", progress=None):
        """A picture for a display: sRGB, uint8, shape (height, width, 3), or (height, width) where light has no colour: the pixels of the
        .png that `volute render` writes of the same file or values.

        time: [s]; default one that has something to see. camera, size, background, progress, renderer ("cpu" or "gl"): as for render().
        exposure: a factor of light; default: brightest parts near white. tone: "filmic", "agx", "shoulder", "none", or by
            OpenColorIO "aces", "ocio" and "ocio:DISPLAY/VIEW"; default filmic; for measured transmittance none, with flames shoulder. samples: rays per pixel at edges. bloom: share of light that glows, 0 to 1.
        colormap: "viridis" or "inferno", for volumes with one channel. legend: draw mode, field, time and colour scale into it.
        shutter: averages light over this share of the time to the next frame, 0.5 is 180 degrees; a volume moves then if its member
            `interpolate` is "auto", "velocity" or "linear"."""
        said = {"time": None if time is None else number("time", time), **_view(camera, size, background),
                **_look(exposure, tone, samples, bloom, colormap, legend, shutter), "renderer": _choice("renderer", renderer, ("cpu", "gl"))}
        with Listener(progress, self._told) as listener:
            return self._pictured(progress).picture(said, listener)

    def film(self, path, *, frames=None, speed=1.0, orbit=None, camera=None, size=None, background=None, exposure=None, tone=None, samples=8,
             bloom=0.0, colormap=None, legend=None, shutter=0.0, renderer="cpu", progress=None):
        """Writes a film (.mp4, .webm), or numbered pictures (fire_%04d.png), as `volute render` does: with one exposure for all.

        frames: (first, end), numbers of frames, or range(first, end, step); default all. speed: seconds of the scene in one of the film. orbit: turns the camera
        around its target by so many degrees over the film. The rest as for picture(). What is stopped leaves no file."""
        path = file_name(path)
        said = {"target": os.fsencode(path), "frames": frame_range(frames),
                "speed": number("speed", speed), "orbit": None if orbit is None else number("orbit", orbit),
                **_view(camera, size, background), **_look(exposure, tone, samples, bloom, colormap, legend, shutter),
                "renderer": _choice("renderer", renderer, ("cpu", "gl"))}
        if not said["speed"] > 0:
            raise ValueError(f"speed={speed!r}: expected a number above 0")
        with Listener(progress, self._told) as listener:
            self._pictured(progress).film(said, listener)

    def __repr__(self):
        what = ", ".join(f"{what}{' (' + size + ')' if size else ''}" for what, _, size in self.media) or "no media"
        times = self.times
        low, high = (", ".join(f"{v:.4g}" for v in point) for point in self.bounds)
        return f"<volute.Scene {os.path.basename(self.path)}: {what}; {times[0]:g} to {times[-1]:g} s, ({low}) to ({high}) m>"

    def _repr_png_(self):
        return _png(self.picture(size=(400, 300)))

    def _repr_html_(self):
        data = base64.b64encode(_png(self.picture(size=(240, 180)))).decode()
        return (f"<div style='display:flex;gap:1em;align-items:center'><img alt='' src='data:image/png;base64,{data}'>"
                f"<div>{html.escape(repr(self)[1:-1])}</div></div>")


def _scene_of(source, progress, members):
    if not isinstance(source, Scene):
        return Scene(source, progress=progress, **members)
    if members:
        raise TypeError(f"{', '.join(members)}: members are for what a scene is made of; this one is made")
    return source


def render(source, time=0.0, *, camera=None, size=None, renderer="cpu", aov=None, background=None, measured=True, progress=None, **members):
    """Light of a scene, a dict, any file that Volute shows, or an array: linear RGB, shape (height, width, 3). See Scene and
    Scene.render()."""
    return _scene_of(source, progress, members).render(time, camera=camera, size=size, renderer=renderer, aov=aov, background=background,
                                                       measured=measured, progress=progress)


def picture(source, time=None, *, camera=None, size=None, background=None, exposure=None, tone=None, samples=8, bloom=0.0, colormap=None,
            legend=None, shutter=0.0, renderer="cpu", progress=None, **members):
    """A picture of a scene, a dict, any file that Volute shows, or an array: sRGB, uint8, shape (height, width, 3), as `volute render`
    writes it. See Scene and Scene.picture()."""
    return _scene_of(source, progress, members).picture(time, camera=camera, size=size, background=background, exposure=exposure, tone=tone,
                                                        samples=samples, bloom=bloom, colormap=colormap, legend=legend, shutter=shutter,
                                                        renderer=renderer, progress=progress)


def film(source, path, *, frames=None, speed=1.0, orbit=None, camera=None, size=None, background=None, exposure=None, tone=None, samples=8,
         bloom=0.0, colormap=None, legend=None, shutter=0.0, renderer="cpu", progress=None, **members):
    """A film of a scene, a dict, any file that Volute shows, or an array. See Scene and Scene.film()."""
    _scene_of(source, progress, members).film(path, frames=frames, speed=speed, orbit=orbit, camera=camera, size=size, background=background,
                                              exposure=exposure, tone=tone, samples=samples, bloom=bloom, colormap=colormap, legend=legend,
                                              shutter=shutter, renderer=renderer, progress=progress)


def to_srgb(image):
    """Converts linear light to sRGB as uint8, with the same shape; values are clamped to 0..1."""
    x = np.clip(_light(image, "linear light as floats; uint8 is sRGB as it is"), 0, 1)
    return np.round(255 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(x, 1 / 2.4) - 0.055)).astype(np.uint8)


def read_image(path):
    """Linear float32 of a .png or .exr, shape (height, width, 3), or (height, width) of one channel; row 0 at the top."""
    with about(file_name(path)):
        return _part().read_image(file_name(path))


def write_image(path, image):
    """Writes a picture, shape (height, width[, 3]): a .png (8 bits, sRGB) or a .exr (linear, float32). Floats are linear values, which a .png
    clamps to 0..1; uint8 is sRGB, as picture() gives it."""
    image = unmasked(image, "the picture")
    if image.dtype == np.uint8:
        steps = np.arange(256) / 255
        image = np.where(steps <= 0.04045, steps / 12.92, ((steps + 0.055) / 1.055) ** 2.4)[image]
    path = file_name(path)
    _part().write_image(path, _light(image, "linear light as floats, or sRGB as uint8", finite=path.lower().endswith(".png")))


def _light(image, expected, finite=True):
    image = unmasked(image, "the picture")
    if image.dtype.kind != "f":
        raise TypeError(f"the picture has values of type {image.dtype}; expected {expected}")
    if finite and np.isnan(image).any():
        raise ValueError(f"the picture has {int(np.isnan(image).sum())} values that are no numbers (NaN); expected {expected}")
    return image.astype(np.float32)


def _looked_through(volumes, source, folder, members):
    """((file, members), scene) of what lines of sight go through; scene: JSON, or "" of a file."""
    how, said = _maker_of(volumes, source, folder, members)
    return (said, "") if how == "open" else ((said[1], "{}"), said[0])


class Sight:
    """Lines of sight through whatever a Scene is made of: a scene file or dict, an FDS case, a mesh, a volume, an array.

    A volume says what its values take away of light by extinction=.. [1/m], or by its unit, where that is 1/m. Fields are read forward
    in time; going back opens them again."""

    def __init__(self, source, *, folder=".", max_memory=4 << 30, **members):
        max_memory = size_of("max_memory", max_memory)
        self._given = source, {"folder": os.path.abspath(folder), "max_memory": max_memory, **members}
        self._volumes = volumes = _Volumes()
        (self.path, members), scene = _looked_through(volumes, source, folder, members)
        with Listener() as listener:
            self._sight = _part().Sight(os.fsencode(self.path), members, scene, volumes.take(), max_memory, listener)

    def __reduce__(self):
        self._sight.times  # says that it is closed
        return _made, (type(self), *self._given)

    def close(self):
        """Closes its files and lets go of its arrays; what is asked of it then is a ValueError. `with` calls it."""
        self._sight, self._volumes, self._given = _Closed(self.path), None, None

    def __enter__(self):
        return self

    def __exit__(self, *what):
        self.close()

    @property
    def times(self):
        """Stored times [s], shape (t,), ascending"""
        return np.asarray(self._sight.times)

    @property
    def bounds(self):
        """((x0, y0, z0), (x1, y1, z1)) of the known region [m]"""
        return self._sight.bounds

    @property
    def description(self):
        """The source of the extinction."""
        return self._sight.description

    @property
    def remarks(self):
        """Sentences about the files, and about the extinction of the times that were looked at: whether its unit can be right."""
        return self._sight.remarks

    def look(self, eyes, targets, time=0):
        """Looks along straight lines at the stored time with index `time`, from 0.

        eyes, targets: shape (n, 3) or (3,), x y z [m]; one of them may be a single point.
        Returns a structured array, shape (n,): depth (integral of the extinction, natural logarithm), low and high (its bounds),
        covered (the medium is known along the whole line; else depth is NaN, low is that of the known part and high infinite), blocked
        (an obstruction is in the way)."""
        eyes, targets = np.broadcast_arrays(_points(eyes), _points(targets))
        if np.ndim(time):
            raise TypeError(f"time={time!r}: expected one index of a stored time")
        with Listener() as listener:
            return self._sight.look(int(_stored("time", time, self._sight.time_count)[0]), eyes, targets, listener)

    def __repr__(self):
        times = self.times
        return f"<volute.Sight {os.path.basename(self.path)}: {self.description}; {len(times)} times, {times[0]:g} to {times[-1]:g} s>"


def _stored(what, indices, count):
    """Indices of `count` stored times, shape (n,)."""
    found = np.atleast_1d(unmasked(indices, what))
    if found.size and (found.ndim > 1 or found.dtype.kind not in "iu"):
        raise TypeError(f"{what}={indices!r}: expected indices of stored times, whole numbers from 0 to {count - 1}; Sight.times has these "
                        "times [s], and those of an array are given by Sight(array, times=..)")
    wrong = [int(one) for one in found if not 0 <= one < count]
    if wrong:
        raise InvalidArgument(f"{what}: there is no stored time {wrong[0]}; there are {count}, from 0")
    return found.astype(np.int64)


@dataclasses.dataclass
class Survey:
    """The visibility of signs from eyes over time."""
    #: shape (time, sign, eye): distance [m], angle [degrees], depth with low and high, mean_extinction [1/m], visibility [m],
    #: and truths: covered, blocked, visible, certainly, possibly
    sightings: np.ndarray
    times: np.ndarray  #: [s], shape (time,)
    signs: list  #: names
    eyes: np.ndarray  #: [m], shape (eye, 3)

    def lost(self):
        """The first stored time at which an eye no longer sees a sign [s], shape (sign, eye); infinite if it always sees the sign."""
        hidden = ~self.sightings["visible"]
        return np.where(hidden.any(axis=0), self.times[hidden.argmax(axis=0)], np.inf)


def _list_file(folder, key, said):
    """The name of a file with a list of signs or criteria, as bytes, which is written where the list itself is said."""
    if not isinstance(said, (list, tuple)):
        return os.fsencode(file_name(said, key))
    name = os.path.join(folder, key + ".json")
    with open(name, "w", encoding="utf-8") as file:
        file.write(_text({key: list(said)}))
    return os.fsencode(name)


class Engine:
    """Who sees which sign, and what people take in, for programs that move them: asked for all agents at once, again and again
    while time goes on.

    source, signs and **members as for visibility(). criteria: a .json file as `volute visibility --criteria` takes it, or a list of
    dicts; default the usual ones that the case stores enough for. Threads may share one; they wait for each other."""

    #: what sees() says
    NOT_SEEN, SEEN, CANNOT_TELL = 0, 1, 2

    def __init__(self, source, signs, *, criteria=None, folder=".", max_memory=4 << 30, progress=None, **members):
        self._volumes = volumes = _Volumes()
        (self.path, members), scene = _looked_through(volumes, source, folder, members)
        with tempfile.TemporaryDirectory() as folder, Listener(progress) as listener:
            said = "" if criteria is None else _list_file(folder, "criteria", criteria)
            self._engine = _part().Engine(os.fsencode(self.path), members, scene, volumes.take(), _list_file(folder, "signs", signs), said,
                                          size_of("max_memory", max_memory), listener)

    def close(self):
        """Closes its files and lets go of its arrays; what is asked of it then is a ValueError. `with` calls it."""
        self._engine, self._volumes = _Closed(self.path), None

    def __enter__(self):
        return self

    def __exit__(self, *what):
        self.close()

    @property
    def times(self):
        """Stored times [s], shape (t,), ascending"""
        return np.asarray(self._engine.times)

    @property
    def signs(self):
        """Names, in the order of sign_places."""
        return self._engine.signs

    @property
    def sign_places(self):
        """[m], shape (sign, 3): before the wall that a sign is on"""
        return self._engine.sign_places

    @property
    def criteria(self):
        """{name: (limit, unit)} of what dose() gives."""
        return {name: (limit, unit) for name, limit, unit in self._engine.criteria}

    @property
    def missing(self):
        """{criterion: why} of those that the case does not store enough for."""
        return dict(self._engine.missing)

    @property
    def remarks(self):
        """Sentences about the files, and about the extinction that was read so far: whether its unit can be right."""
        return self._engine.remarks

    def sees(self, eyes, time, facing=None):
        """Which signs each agent sees at `time` [s], linear between stored times: a structured array, shape (agent,), with a field
        a sign: NOT_SEEN, SEEN or CANNOT_TELL (the case's values are rounded too much). eyes: shape (agent, 3) or (3,) [m]. facing:
        where agents walk to or look, shape (agent, 2) or (agent, 3): signs behind them are not seen."""
        eyes = _points(eyes)
        with Listener() as listener:
            seen = self._engine.sees(number("time", time), eyes, listener)
        if facing is not None:
            facing = np.asarray(unmasked(facing, "facing"), float)
            if facing.ndim not in (1, 2) or facing.shape[-1] not in (2, 3) or not np.isfinite(facing).all():
                raise ValueError(f"facing: shape {facing.shape}; expected (agent, 2), finite numbers")
            facing = np.broadcast_to(np.atleast_2d(facing)[:, :2], (len(eyes), 2))
            ahead = self.sign_places[:, np.newaxis, :2] - eyes[np.newaxis, :, :2]
            seen = np.where((ahead * facing).sum(-1) < 0, np.uint8(self.NOT_SEEN), seen)
        return _fields(self.signs, np.uint8, seen)

    def dose(self, ids, eyes, time, worst=False):
        """What each agent has taken in until `time` [s] since the calls before, by trapezoids: steps of a second or less are small
        enough for people who walk. A structured array, shape (agent,), with a field a criterion: a dose so far or a level (see
        criteria); NaN where nothing is known. ids: shape (agent,), whole numbers, each once. worst: by the worst that rounding, caps
        and means at nodes of the files allow, instead of by the values themselves; both are followed, and may be asked for at the
        same time."""
        ids = wholes("ids", ids)
        with Listener() as listener:
            return _fields(self.criteria, float, self._engine.dose(number("time", time), ids, _points(eyes), bool(worst), listener))

    def extinction(self, eyes, time):
        """K at each eye [1/m], shape (agent,), for walking speeds; NaN where nothing is known."""
        with Listener() as listener:
            return self._engine.extinction(number("time", time), _points(eyes), listener)

    def walking_speed(self, eyes, time, clear=1.2, law="fridolf"):
        """How fast agents walk in the smoke where their eyes are [m/s], shape (agent,), who walk at `clear` [m/s] without it; NaN where
        the smoke is not known. law: as `volute visibility --slowed` takes it: fridolf, frantzich-nilsson, or with own coefficients
        ("fridolf:0.34,3,0.2")."""
        eyes = _points(eyes)
        with Listener() as listener:
            return self._engine.walking_speed(number("time", time), eyes, np.broadcast_to(np.asarray(clear, float), len(eyes)), law, listener)

    def __repr__(self):
        times = self.times
        return (f"<volute.Engine {os.path.basename(self.path)}: {len(self.signs)} signs, {len(self.criteria)} criteria; "
                f"{times[0]:g} to {times[-1]:g} s>")


def _fields(names, kind, rows):
    """Shape (name, n) as a structured array, shape (n,)."""
    table = np.empty(rows.shape[1], [(name, kind) for name in names])
    for name, row in zip(names, rows):
        table[name] = row
    return table


class Trajectories:
    """Where walking people are: JuPedSim's .sqlite or text format, Pathfinder's occupants .csv, or a table id,time,x,y[,z].
    height: z of all eyes [m]; by default the file's, or `eye_height` [m] above it where the file's z is the floor, as
    `remarks` say."""

    def __init__(self, path, height=None, eye_height=1.8):
        with open(path, "rb") as file:
            text = file.read()
        self._walks = _part().Trajectories(text, os.fsencode(file_name(path)), height, eye_height)
        self.begin, self.end = self._walks.span  #: [s]
        self.remarks = self._walks.remarks

    @property
    def ids(self):
        """Of all people, ascending"""
        return np.asarray(self._walks.ids)

    def at(self, time):
        """(ids, eyes) of those who are there at `time` [s], eyes of shape (person, 3) [m]: what Engine.dose() takes."""
        return self._walks.at(number("time", time))


def visibility(source, signs, eyes, *, times=None, max_memory=4 << 30, progress=None, **members):
    """From where, and when, signs are seen through smoke: a Survey with a structured array of shape (time, sign, eye).

    source: an FDS case, a mesh, a volume or a scene (or a Sight). signs: a .json file with "signs", or a list of dicts
    {"name", "position": [x,y,z], "normal": [x,y,z], "size", "emitting" or "C", "angle_law"} (docs/visibility.md).
    eyes: shape (n, 3) or (3,) [m]. times: indices of stored times, default all; those of an array are given by Sight(array, times=..).
    **members: members of a scene's entry for the file."""
    if isinstance(source, Sight):
        members.update({"max_memory": max_memory} if max_memory != 4 << 30 else {})
        if members:
            raise TypeError(f"{', '.join(members)}: a Sight is made with them already: volute.Sight(source, {next(iter(members))}=..)")
    sight = source if isinstance(source, Sight) else Sight(source, max_memory=max_memory, **members)
    eyes = _points(eyes)
    stored = sight.times
    chosen = np.arange(len(stored)) if times is None else _stored("times", times, len(stored))
    with tempfile.TemporaryDirectory() as folder, Listener(progress) as listener:
        signs = _list_file(folder, "signs", signs)
        table = sight._sight.survey(chosen.tolist(), signs, eyes, listener)
        names = sight._sight.sign_names(signs)
    return Survey(table, stored[chosen], names, eyes)


@dataclasses.dataclass
class Reconstruction:
    """Volumes from pictures."""
    values: object  #: radiance per metre, shape (t, z, y, x, 3): a NumPy array, or the file as a volute.Volume
    bounds: tuple  #: ((x0, y0, z0), (x1, y1, z1)) [m]
    times: np.ndarray  #: [s]
    frame_numbers: np.ndarray
    report: dict  #: all that was measured: residuals of each camera, iterations, warnings
    name: str = ""  #: of the values, and their unit
    unit: str = ""
    sigma: object = None  #: with error_bars: the standard deviation of each value, of the same shape; of a file its grid 'emission_sigma'
    basis: str = "box"  #: what the values mean between the centres of voxels, as for compress()
    velocity: object = None  #: asked for: velocities [m/s], shape (t, z, y, x, 3); of a file its grid 'velocity'

    def _of_itself(self):
        """The values, and what they say: a Reconstruction is a volume wherever arrays are."""
        return self.values, {key: getattr(self, key) for key in ("bounds", "times", "frame_numbers", "name", "unit", "basis")}


def reconstruct(capture, output=None, *, rms=1e-3, frames=None, resolution=None, bounds=None, images=None, max_memory=4 << 30,
                progress=None, **options):
    """Reconstructs fire from the pictures of calibrated cameras, or smoke from optical depths along lines.

    capture: capture.json, NeRF's transforms.json, a COLMAP folder or OpenCV's .yml (docs/capture.md); or volute.Lines, or a .csv of lines, of
    which bounds, resolution, frames, basis, iterations, lambda_ and force (leaves lines out that miss the bounds) are the options.
    output: a .volute file to write, at a relative RMS error of `rms`, that of `volute reconstruct`; None: an array is returned.
    frames: (first, end), or range(first, end, step). resolution: (x, y, z) voxels, or one number for the longest side. bounds: ((x0,y0,z0),(x1,y1,z1)) [m].
    images: the pattern of pictures, {camera} and %04d. Options as those of the command: basis, solver, iterations, regularization,
    lambda_, sparsity, temporal, refine, refined (a .json to write the capture to, with the calibration that was used), rays_per_pixel, hull,
    coarse_to_fine, warm_start, noise_sigma, hold_out, error_bars, velocity, force. error_bars=True estimates standard deviations, too, and velocity=True velocities between frames; temperature=True writes temperature and extinction of a
    flame's soot as grids of `output`."""
    part = _part()
    lines = isinstance(capture, Lines) or str(capture).lower().endswith(".csv")
    known = {"basis": ("trilinear", "box"), "solver": ("apg", "mlem", "sirt", "cgls"),
             "regularization": ("auto", "none", "tv", "smooth", "wavelet"), "rays_per_pixel": (1, 4), "iterations": None, "lambda": None,
             "sparsity": None, "temporal": None, "refine": (True, False), "refined": None, "hull": None, "coarse_to_fine": None, "warm_start": None, "noise_sigma": None, "hold_out": None,
             "error_bars": (True, False), "velocity": (True, False), "temperature": (True, False), "force": None}
    if lines:
        known = {key: known[key] for key in ("basis", "iterations", "lambda", "force")}
    said = {key.rstrip("_"): value for key, value in options.items() if value is not None}
    for key, value in said.items():
        if key not in known:
            raise TypeError(f"reconstruct() has no option {key!r}; there are {', '.join(known)}")
        if known[key] and value not in known[key]:
            raise ValueError(f"{key}={value!r}: expected {' or '.join(map(repr, known[key]))}")
    if "temporal" in said:
        said["temporal"] = number("temporal", said["temporal"])
        if not 0 <= said["temporal"] < np.inf:
            raise ValueError(f"temporal={said['temporal']!r}: expected 0 or more")
    if "refined" in said:
        said["refined"] = file_name(said["refined"], "refined")
    if "hold_out" in said:
        said["hold_out"] = [said["hold_out"]] if isinstance(said["hold_out"], str) else list(said["hold_out"])
    if frames is not None:
        said["frames"] = frame_range(frames)
    if resolution is not None:
        if np.shape(resolution) not in ((), (3,)):
            raise ValueError(f"resolution={resolution!r}: expected (x, y, z), or one number for the longest side")
        said["resolution"] = [whole("resolution", n) for n in resolution] if np.ndim(resolution) else [whole("resolution", resolution), 0, 0]
    if bounds is not None:
        said["bounds"] = corners(bounds)
    if images is not None:
        said["images"] = file_name(images, "images")
    if output is None and said.get("temperature"):
        raise ValueError("temperature=True needs an output: its grids are those of the file")
    output = None if output is None else file_name(output, "output")
    if output is not None and not output.endswith(".volute"):
        raise ValueError(f"'{output}' does not end in .volute")
    if lines:
        return _from_lines(capture, output, rms, said, max_memory, progress)
    with Listener(progress) as listener:
        values, place, report, sigma, velocity = part.reconstruct(os.fsencode(file_name(capture, "capture")), os.fsencode(output or ""), number("rms", rms), _text(said),
                                                        size_of("max_memory", max_memory), listener)
    if output is not None:
        values = _open(output, grid=place["grid"])
        sigma = _open(output, grid=place["grid"] + "_sigma") if said.get("error_bars") else None
        velocity = _open(output, grid="velocity") if said.get("velocity") else None
    return Reconstruction(values, place["bounds"], np.asarray(place["times"]), np.asarray(place["frame_numbers"]), json.loads(report),
                          place["grid"], place["unit"], sigma, place["basis"], velocity)


def _from_lines(lines, output, rms, said, max_memory, progress):
    source = lines._said() if isinstance(lines, Lines) else os.fsencode(file_name(lines, "lines"))
    with Listener(progress) as listener:
        values, place, records = _part().reconstruct_lines(source, _text(said), size_of("max_memory", max_memory), listener)
    found = Reconstruction(values, place["bounds"], np.asarray(place["times"]), np.asarray(place["frame_numbers"]),
                           {"lines": json.loads(records)}, place["grid"], place["unit"], basis=place["basis"])
    if output is not None:
        found.values = compress(found, output, rms=rms, progress=progress).open()
    return found
