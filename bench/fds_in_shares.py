#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Draws an FDS case by ranks that hold a share of its meshes each, and compares with the picture of one that holds all.

    bench/fds_in_shares.py build/release/bin/volute --cells 128 --meshes 8 --ranks 4        17 million cells

Meshes stand side by side along x; each has a 3D slice of the extinction in its cells. Says the memory and CPU time of the ranks and the
greatest difference of the pictures: of the optical depth, and of smoke that a sun and a spot light.
"""
import argparse
import array
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tools"))
from fds_case import FdsCase, Mesh
from ranks import stats_of


class LargeCase(FdsCase):
    """Values repeat along y and z, so that a case of millions of cells is written in seconds."""

    def write_slice(self, path, mesh, labels, formula):
        def record(file, data):
            file.write(struct.pack("<i", len(data)) + data + struct.pack("<i", len(data)))

        nx, ny, nz = mesh.cells
        rows = []
        for phase in range(64):
            values = [0.05 * (1.2 + math.sin(0.9 * mesh.middle(0, i) + 0.3 * phase)) * (1 + phase / 64) for i in range(nx)]
            rows.append(array.array("f", [7.0] + values).tobytes())
        with open(path, "wb") as file:
            for label in labels:
                record(file, label[:30].ljust(30).encode())
            record(file, struct.pack("<6i", 0, nx, 0, ny, 0, nz))
            for time in self.times:
                record(file, struct.pack("<f", time))
                record(file, b"".join(rows[(3 * j + 5 * k) % 64] for k in range(nz + 1) for j in range(ny + 1)))


def draw(program, scene, target, ranks, options):
    """What --stats says."""
    pieces = ["--by-pieces"] if ranks > 1 else []
    return stats_of(ranks, [program, "render", scene, "-o", target, "--threads", "1", *options, *pieces], target.with_suffix(".json"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path, help="the volute command")
    parser.add_argument("--cells", type=int, default=128, help="of a mesh along each axis")
    parser.add_argument("--meshes", type=int, default=8)
    parser.add_argument("--ranks", type=int, default=4)
    parser.add_argument("--max-memory", default="16G")
    options = parser.parse_args()
    program = options.program.resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        meshes = [Mesh(f"mesh{i}", (2 * i, 2 * i + 2, 0, 2, 0, 2), (options.cells,) * 3) for i in range(options.meshes)]
        case = LargeCase(meshes, [0.0], None).write(folder)
        length = 2 * options.meshes
        scene = {"format": "volute-scene-1", "background": [1, 1, 1],
                 "lights": [{"kind": "sun", "direction": [0.5, 0.3, -1], "radiance": [1, 0.9, 0.8]},
                            {"kind": "spot", "position": [length / 2, 1, 1.9], "target": [length / 2, 1, 0], "angle": 150, "intensity": [3, 2, 1]}],
                 "camera": {"eye": [-0.2 * length, -0.6 * length, 0.4 * length], "target": [length / 2, 1, 1], "up": [0, 0, 1], "fov": 50,
                            "size": [400, 300]},
                 "media": [{"kind": "smoke", "case": case.name, "albedo": [0.8, 0.8, 0.8]}]}
        (folder / "scene.json").write_text(json.dumps(scene))
        print(f"{options.meshes * options.cells ** 3 / 1e6:.2f} million cells in {options.meshes} meshes", flush=True)
        for what, more in (("optical depth", ("--aov", "optical-depth")), ("lit", ("--measured",))):
            for ranks in (1, options.ranks):
                stats = draw(program, folder / "scene.json", folder / f"by{ranks}.exr", ranks, (*more, "--max-memory", options.max_memory))
                memory = ", ".join(f"{rank['peak_memory_bytes'] / 1e6:.0f}" for rank in stats["ranks"])
                print(f"{what}, {ranks} rank{'' if ranks == 1 else 's'}: {memory} MB, "
                      f"{sum(rank['cpu_seconds'] for rank in stats['ranks']):.1f} s CPU", flush=True)
            done = subprocess.run([program, "compare", folder / "by1.exr", folder / f"by{options.ranks}.exr", "--json"], stdout=subprocess.PIPE)
            difference = json.loads(done.stdout)["max_error"]
            print(f"{what}: greatest difference {difference:.2g}")
            if difference > 1e-5:
                return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
