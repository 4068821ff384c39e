# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Compiles targets of a CMake preset, and tells how far that is."""
import pathlib
import re
import subprocess

from children import Child


class Compiler:
    def __init__(self, root, preset, jobs, cmake="cmake"):
        self.root, self.preset, self.jobs, self.cmake = pathlib.Path(root), preset, jobs, cmake
        self.folder = self.root / "build" / preset
        self.configured = False

    @property
    def binaries(self):
        return self.folder / "bin"

    def configure(self, tick=lambda: None):
        """Writes what ninja reads; quick when nothing changed. Raises Failed."""
        if not self.configured:
            Child([self.cmake, "--preset", self.preset], cwd=self.root).wait(tick)
            self.configured = True

    def left(self, target):
        """(commands left, commands in all) of a target, by ninja itself; None where that is not known before configuring."""
        if not (self.folder / "build.ninja").is_file():
            return None

        def count():
            done = subprocess.run(["ninja", "-C", str(self.folder), "-n", target], stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL, text=True)
            if "Re-running CMake" in done.stdout:
                raise OSError("what is left is known only after configuring")
            found = re.findall(r"^\[\d+/(\d+)\]", done.stdout, re.MULTILINE)
            return int(found[-1]) if found else 0
        try:
            return count(), self.commands(target)
        except OSError:
            return None

    def commands(self, target):
        done = subprocess.run(["ninja", "-C", str(self.folder), "-t", "commands", target], stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True)
        return max(1, done.stdout.count("\n"))

    def build(self, target, told):
        """Builds one target and calls told(done, of) on the way. Raises Failed with what the compiler said."""
        self.configure(lambda: told(0, 0))
        child = Child([self.cmake, "--build", str(self.folder), "-j", str(self.jobs), "--target", target], cwd=self.root)
        at = [0, 0]

        def line(text):
            found = re.match(r"\[(\d+)/(\d+)\]", text)
            if found:
                at[:] = map(int, found.groups())

        child.wait(lambda: told(*at), line)
