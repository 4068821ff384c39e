# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""What the demo makes, as data: steps with their inputs, outputs and commands, in chapters of sections of pictures.

Running, going on, time left and the page are all derived from this.
"""
import dataclasses
import json
import pathlib
import shlex
import typing

HERE = pathlib.Path(__file__).resolve().parent


@dataclasses.dataclass(frozen=True)
class Step:
    """Makes files, by a command that the page shows or by a function of the demo's own.

    Paths are relative to the output folder; one that ends in "/" is a folder, made anew.
    """
    makes: tuple
    command: str = ""
    work: typing.Callable = None  # work(folder, *arguments), where there is no command
    arguments: tuple = ()
    reads: tuple = ()
    like: tuple = ()  # pictures that its own may be the same as

    @property
    def name(self):
        return self.makes[0]

    @property
    def words(self):
        return shlex.split(self.command)


@dataclasses.dataclass(frozen=True)
class Build:
    """Compiles one target, with all that it needs."""
    target: str
    seconds: float  # CPU time from nothing; less is left where parts are there

    @property
    def name(self):
        return f"build of {self.target}"


# What sections hold. A text may be a function of the results, called once its step is done.

@dataclasses.dataclass(frozen=True)
class Picture:
    """A still or a film."""
    file: str
    label: str
    caption: typing.Any
    poster: str = ""


@dataclasses.dataclass(frozen=True)
class Choice:
    """Pictures of one size at one place, and a slider that tells which of them is shown."""
    files: tuple  # of (file, what the slider says)
    label: str
    caption: typing.Any
    start: int = 0


@dataclasses.dataclass(frozen=True)
class Wipe:
    """Two pictures of one size, one above the other, and a slider that moves the border between them."""
    left: tuple  # (file, name)
    right: tuple
    label: str
    caption: typing.Any


@dataclasses.dataclass(frozen=True)
class Fact:
    value: typing.Any
    label: str
    needs: tuple


@dataclasses.dataclass(frozen=True)
class Drawn:
    """A plot or a table of `draw(results)`: the arguments of plots.line_plot, or columns and rows."""
    kind: str  # "plot" or "table"
    draw: typing.Callable
    needs: tuple


@dataclasses.dataclass(frozen=True)
class Command:
    """The command that made a file that is no picture."""
    file: str
    caption: typing.Any
    wide: bool = True


@dataclasses.dataclass(frozen=True)
class Section:
    title: str
    text: typing.Any
    parts: tuple
    columns: int = 2


@dataclasses.dataclass(frozen=True)
class Chapter:
    name: str  # its anchor and its folder
    title: str
    sentence: str  # below the title and on its door
    steps: tuple  # of Step and Build, in the order in which they are made
    sections: tuple
    door: tuple = ()  # pictures for its door, the best first: the first that is made is shown; none for what is no door


class Plan:
    """All chapters. A file is made by one step, and read after it was made."""

    def __init__(self, chapters, measured=None):
        """`measured`: {step: CPU seconds}, as Scale.measured reads them."""
        self.chapters = tuple(chapters)
        self.measured = measured or {}
        self.steps = [step for chapter in self.chapters for step in chapter.steps]
        self.maker = {}
        for step in self.steps:
            if isinstance(step, Build):
                continue
            for file in step.reads:
                if file not in self.maker:
                    raise ValueError(f"{step.name} reads {file}, which no step before it makes")
            for file in step.makes:
                if file in self.maker:
                    raise ValueError(f"{file} is made twice")
                self.maker[file] = step

    def seconds(self, step):
        """CPU time that a step takes on the machine of the table."""
        return step.seconds if isinstance(step, Build) else self.measured.get(step.name, 1.0)

    def step_of(self, file):
        """The step that makes this file, or a folder that holds it."""
        if file in self.maker:
            return self.maker[file]
        folder = file
        while "/" in folder:
            folder = folder[:folder.rindex("/")]
            if folder + "/" in self.maker:
                return self.maker[folder + "/"]
        raise KeyError(f"no step makes {file}")


class Scale:
    """How large everything is."""

    def __init__(self, quick):
        self.quick = quick

    def pick(self, whole, quick):
        return quick if self.quick else whole

    def table(self):
        """Where the seconds of this size are kept; `python3 tools/demo --measured` writes them after a whole run."""
        return HERE / f"seconds_{'quick' if self.quick else 'whole'}.json"

    def measured(self):
        return json.loads(self.table().read_text(encoding="utf-8"))
