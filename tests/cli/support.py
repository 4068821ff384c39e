# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""What the tests of the command line share: running the program, and .npy files read and written independently."""
import array
import ast
import json
import os
import pathlib
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

import schema

PROGRAM = os.environ["VOLUTE"]
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:  # of scripts' `&`: the programs that are started would ignore it, too
    signal.signal(signal.SIGINT, signal.default_int_handler)


class Result:
    def __init__(self, done):
        self.code, self.out, self.err = done.returncode, done.stdout, done.stderr

    @property
    def text(self):
        return self.out.decode()

    @property
    def message(self):
        return self.err.decode()

    @property
    def json(self):
        return json.loads(self.out)


SLOWER = float(os.environ.get("VOLUTE_TESTS_SLOWER", "1"))  # than without a sanitizer


def slower():
    """Than a machine where nobody else works."""
    return SLOWER * max(1.0, os.getloadavg()[0] / os.cpu_count())


def listening(process):
    """Waits until the program, maybe a child of a shell, takes signals itself: before that they end it without a word."""
    end = time.monotonic() + 60
    bit = 1 << signal.SIGINT - 1
    while process.poll() is None and time.monotonic() < end:
        children = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children")
        for pid in (process.pid, *map(int, children.read_text().split())):
            status = dict(line.split(":", 1) for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines() if ":" in line)
            if status["Name"].strip() == pathlib.Path(PROGRAM).name:  # what it forks itself is no matter
                if any(int(status[key], 16) & bit for key in ("SigBlk", "SigIgn", "SigCgt")):
                    return
                break
        time.sleep(0.005)


def volute(*arguments, **options):
    """Runs the program; `options` go to subprocess.run."""
    command = [PROGRAM, *map(str, arguments)]
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "timeout": 120 * slower(), "stdin": subprocess.DEVNULL} | options
    return Result(subprocess.run(command, **options))


def write_npy(path, shape, values, times=1, code="f"):
    """float32 in C order, or with code "d" float64; the values so many times."""
    header = repr({"descr": {"f": "<f4", "d": "<f8"}[code], "fortran_order": False, "shape": tuple(shape)}).encode()
    header += b" " * (-(len(header) + 11) % 64) + b"\n"
    data = array.array(code, values)
    if sys.byteorder == "big":
        data.byteswap()
    pathlib.Path(path).write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + times * data.tobytes())


def read_npy(data):
    """(shape, values) from the bytes of a file of float32 or float64."""
    assert data[:8] == b"\x93NUMPY\x01\x00", data[:8]
    (length,) = struct.unpack_from("<H", data, 8)
    header = ast.literal_eval(data[10:10 + length].decode())
    assert not header["fortran_order"], header
    values = array.array({"<f4": "f", "<f8": "d"}[header["descr"]])
    values.frombytes(data[10 + length:])
    return header["shape"], values


def plume(frames, size, channels=1):
    """A smooth moving blob, exact zeros around it: (shape, values)."""
    values = []
    for t in range(frames):
        centre = (0.5 * size, (0.3 + 0.02 * t) * size, 0.5 * size)
        for z in range(size):
            for y in range(size):
                for x in range(size):
                    square = sum((a - b) ** 2 for a, b in zip((x, y, z), centre))
                    value = max(0.0, 1 - square / (0.1 * size * size))
                    values.extend(value * (c + 1) for c in range(channels))
    return (frames, size, size, size) + ((channels,) if channels > 1 else ()), values


class TestCase(unittest.TestCase):
    """Each test has a folder of its own."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def path(self, name):
        return self.folder / name

    def files(self):
        """All names in the folder, half-written files included."""
        return sorted(entry.name for entry in self.folder.iterdir())

    def make_npy(self, name="in.npy", frames=3, size=12, channels=1):
        shape, values = plume(frames, size, channels)
        write_npy(self.path(name), shape, values)
        return self.path(name)

    def make_volute(self, name="in.volute", **options):
        source = self.make_npy("source.npy", **options)
        self.works("compress", source, "-o", self.path(name), "--rms", "0.002")
        source.unlink()
        return self.path(name)

    def works(self, *arguments, measured=None, **options):
        """Pictures with linear values are measured ones, unless a test says otherwise."""
        if measured is None:
            measured = arguments[:1] == ("render",) and any(str(a).endswith(".exr") for a in arguments[2:])
        result = volute(*arguments, *(["--measured"] if measured else []), **options)
        self.assertEqual(result.code, 0, result.message)
        if arguments and arguments[0] == "render" and str(arguments[1]).endswith(".json"):
            scene = json.loads(pathlib.Path(arguments[1]).read_text())
            self.assertEqual(schema.faults(scene), [], "docs/scene.schema.json refuses what was rendered")
        return result

    def measures_memory(self):
        if "VOLUTE_TESTS_SANITIZED" in os.environ:
            self.skipTest("a sanitizer keeps freed memory")

    def peak(self, *arguments):
        """Exit code, message, and the most memory that the program and those it waited for held [bytes]."""
        self.measures_memory()
        process = subprocess.Popen([PROGRAM, *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        message = process.stderr.read().decode()
        process.stderr.close()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        return process.returncode, message, usage.ru_maxrss << 10

    def fails(self, code, *arguments, **options):
        """The program ends with `code` and one sentence, and leaves no new file."""
        before = self.files()
        result = volute(*arguments, **options)
        self.assertEqual(result.code, code, result.message)
        self.assertTrue(result.message.startswith("volute"), result.message)
        self.assertEqual(self.files(), before)
        return result.message


def main():
    unittest.main(verbosity=1)
