#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Nothing is quadratic in the size of a text: each reader gets n, 2 n and 4 n of what a file may have many of, and the instructions that
valgrind counts grow in step: what the second doubling adds is at most 2.5 times what the first adds (2 where every step is of one element,
4 where each looks at all others). No clock is looked at. `python3 tests/cli/steps_test.py --table [WORD ..]` tells the counts."""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import sight_cases
import support

MOST = 2.5  # twice, and what n log n and tables that grow add
VALGRIND = shutil.which("valgrind")


def room(folder):
    hall = sight_cases.Mesh("hall", (0, 8, 0, 4, 0, 3), (8, 4, 3))
    sight_cases.FdsCase([hall], [0.0], lambda t, *_: 0.02).write(folder, "hall")
    (folder / "signs.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [7.9, 2, 2], "normal": [-1, 0, 0]}]}))
    (folder / "eyes.csv").write_text("x,y,z\n2,3,2\n")
    return folder


def put(folder, name, text):
    (folder / name).write_text(text)


SEE = "visibility hall.smv --signs signs.json {} --sight none -o out"


def camera(name, **more):
    return {"name": name, "width": 8, "height": 8, "K": [[9, 0, 4], [0, 9, 4], [0, 0, 1]], "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, 0, 4]} | more


def capture(folder, n, image, pictures):
    for picture in pictures:
        put(folder, picture, "")
    put(folder, "capture.json", json.dumps({"format": "volute-capture-1", "color": "linear", "volume": {"min": [-1] * 3, "max": [1] * 3,
                                            "resolution": [8] * 3}, "cameras": [camera(f"c{i}", image=image(i)) for i in range(n)]}))
    return "info capture.json"


def path_of_a_camera(folder, n):
    put(folder, "scene.json", json.dumps({"format": "volute-scene-2", "geometry": [], "camera": {
        "eye": [0, -9, 1], "target": [0, 0, 1], "fov": 40, "size": [2, 2], "keys": [[i, 0, -9, 1, 0, 0, 1 + i % 7] for i in range(n)]}}))
    return "info scene.json"


def signs(folder, n):
    room(folder)
    put(folder, "signs.json", json.dumps({"signs": [{"name": f"exit {i}", "position": [7.9, 0.1 + 3 * i / n, 2], "normal": [-1, 0, 0]} for i in range(n)]}))
    return SEE.format("--eyes eyes.csv")


def names_in_a_scene(folder, n):
    put(folder, "scene.json", json.dumps({"format": "volute-scene-2", "media": [], "geometry": [], **{f"member{i}": i for i in range(n)}}))
    return "info scene.json"


def media_in_a_scene(folder, n):
    put(folder, "scene.json", json.dumps({"format": "volute-scene-2", "media": [
        {"kind": "fog", "sigma_max": 0.1 + i, "color": [0.1, 0.1, 0.1]} for i in range(n)]}))
    return "info scene.json"


def cameras(folder, n):
    return capture(folder, n, lambda i: f"c{i}.png", [])


def pictures_of_one_folder(folder, n):
    return capture(folder, n, lambda i: f"c{i}_%04d.png", [f"c{i}_0001.png" for i in range(n)])


def yaml(folder, n):
    matrix = lambda name, rows, data: f"{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {3 if rows == 3 and len(data) > 3 else 1}\n   dt: d\n   data: {data}\n"
    put(folder, "cameras.yml", "%YAML:1.0\n---\nimage_width: 8\nimage_height: 8\n" + "".join(
        matrix(f"K_c{i}", 3, [9, 0, 4, 0, 9, 4, 0, 0, 1]) + matrix(f"R_c{i}", 3, [1, 0, 0, 0, 1, 0, 0, 0, 1]) + matrix(f"T_c{i}", 3, [0, 0, 4])
        for i in range(n)))
    return "info cameras.yml"


def colmap(folder, n):
    put(folder, "cameras.txt", "".join(f"{i + 1} PINHOLE 40 32 42 42 20 16\n" for i in range(n)))
    put(folder, "images.txt", "".join(f"{i + 1} 0.5 0.5 0.5 -0.5 0 0 4 {i + 1} picture_{i:07}.png\n\n" for i in range(n)))
    put(folder, "points3D.txt", "")
    return "info ."


def faces(folder, n):
    put(folder, "g.obj", "".join(f"v {i} {i % 7} {i % 5}\n" for i in range(n + 2)) + "".join(f"f {i + 1} {i + 2} {i + 3}\n" for i in range(n)))
    return scene_of(folder)


def corners_of_a_face(folder, n):
    put(folder, "g.obj", "".join(f"v {i} {i * i / n} 0\n" for i in range(n)) + "f " + " ".join(str(i + 1) for i in range(n)) + "\n")
    return scene_of(folder)


def materials(folder, n):
    put(folder, "g.mtl", "".join(f"newmtl m{i}\nKd 0.5 0.5 0.5\n" for i in range(n)))
    put(folder, "g.obj", "mtllib g.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n" + "".join(f"usemtl m{i}\nf 1 2 3\n" for i in range(0, n, 8)))
    return scene_of(folder)


def scene_of(folder):
    put(folder, "scene.json", json.dumps({"format": "volute-scene-2", "geometry": [{"file": "g.obj"}], "camera": {
        "eye": [0, -9, 1], "target": [0, 0, 1], "fov": 40, "size": [2, 2]}}))
    return "render scene.json -o out.png"


def eyes(folder, n):
    room(folder)
    put(folder, "eyes.csv", "x,y,z,name\n" + "".join(f"{1 + i % 60 / 10:.1f},{1 + i % 20 / 10:.1f},1.7,place {i}\n" for i in range(n)))
    return SEE.format("--eyes eyes.csv")


def routes(folder, n):
    room(folder)
    put(folder, "route.csv", "x,y,z,route\n" + "".join(f"{1 + i % 60 / 10:.1f},1,1.7,way {i}\n{1.05 + i % 60 / 10:.2f},1.01,1.7,way {i}\n" for i in range(n)))
    return SEE.format("--route route.csv --speed 1")


def walks(folder, n):
    room(folder)
    put(folder, "walk.csv", "time,id,x,y\n" + "".join(f"{t},{i},{1 + (i + t) % 60 / 10:.1f},2\n" for t in range(2) for i in range(n)))
    return SEE.format("--trajectories walk.csv --height 1.7")


def required_times(folder, n):
    room(folder)
    put(folder, "rset.csv", "x,y,rset\n" + "".join(f"{0.1 + 7 * (i % 100) / 100:.2f},{0.1 + 3 * (i // 100) / (n // 100):.5f},{5 + i % 9}\n" for i in range(n)))
    return SEE.format("--rset rset.csv --height 1.5 --step 2") + " --maps aset"


def lines_of_sight(folder, n):
    put(folder, "lines.csv", "x0,y0,z0,x1,y1,z1,transmittance\n" + "".join(
        f"-1,{0.2 + i % 160 / 100:.3f},{0.3 + i % 77 / 100:.3f},3,{1.8 - i % 91 / 100:.3f},{0.3 + i % 50 / 100:.3f},0.{700 + i % 100}\n" for i in range(n)))
    return "reconstruct lines.csv -o out.npy --bounds=0,0,0,2,2,2 --resolution 2,2,2 --iterations 1"


def cases_of_a_study(folder, n):
    room(folder)
    put(folder, "study.json", json.dumps({"cases": ["hall.smv"], "options": {"signs": "signs.json", "height": 1.5, "step": 2},
                                          "variants": [{"name": f"v{i}", "options": {"step": 2 + i}} for i in range(n)]}))
    return "sweep study.json --list"


def obstructions(folder, n):
    room(folder)
    text = (folder / "hall.smv").read_text()
    boxes = "".join(f" 1.0 2.0 1.0 {2 + i % 100 / 100:.2f} 1.0 2.0 {i} 0 0 0 0 0 0\n" for i in range(n)) + " 1 2 1 3 1 2 -1 -1\n" * n
    put(folder, "hall.smv", text.replace("OBST\n 0\n", f"OBST\n {n}\n{boxes}"))
    return "info hall.smv"


def devices(folder, n):
    room(folder)
    text = "".join(f"DEVICE\n T{i} % TEMPERATURE\n {1 + i % 60 / 10:.1f} 2.5 1.5 0 0 0 0 0 % null\n" for i in range(n))
    put(folder, "hall.smv", (folder / "hall.smv").read_text() + text)
    row = lambda words: ",".join(words) + "\n"
    put(folder, "hall_devc.csv", row(["s"] + ["C"] * n) + row(["Time"] + [f'"T{i}"' for i in range(n)]) + row(["0"] + ["20"] * n) + row(["9"] + ["30"] * n))
    return SEE.format("--eyes eyes.csv")


def meshes(folder, n):
    parts = [sight_cases.Mesh(f"m{i}", (i, i + 1, 0, 1, 0, 1), (1, 1, 1)) for i in range(n)]
    sight_cases.FdsCase(parts, [0.0], lambda t, *_: 0.02).write(folder, "hall")
    return "info hall.smv"


# What is read, and n.
READERS = {path_of_a_camera: 4000, signs: 500, names_in_a_scene: 400, media_in_a_scene: 500, cameras: 500, pictures_of_one_folder: 500, yaml: 500, colmap: 2000,
           faces: 8000, corners_of_a_face: 2000, materials: 4000, eyes: 4000, routes: 1000, walks: 4000, required_times: 2000, lines_of_sight: 4000,
           cases_of_a_study: 500, obstructions: 4000, devices: 1000, meshes: 60}


def steps(write, n):
    """(instructions, exit code, message)"""
    with tempfile.TemporaryDirectory() as name:
        command = write(pathlib.Path(name), n)
        done = subprocess.run([VALGRIND, "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null", support.PROGRAM, *command.split()],
                              cwd=name, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=600)
        own = re.findall(r"I +refs: +([\d,]+)", done.stderr)  # of each process
        message = "".join(line + "\n" for line in done.stderr.splitlines() if not line.startswith(("==", "--")))
        return sum(int(count.replace(",", "")) for count in own), done.returncode, message


class Steps(support.TestCase):
    def setUp(self):
        super().setUp()
        if not VALGRIND or "VOLUTE_TESTS_SANITIZED" in support.os.environ:
            self.skipTest("valgrind counts the steps")

    def test_nothing_is_quadratic(self):
        for write, n in READERS.items():
            with self.subTest(write.__name__):
                counts = []
                for size in (n, 2 * n, 4 * n):
                    count, code, message = steps(write, size)
                    self.assertIn(code, (0, 1), message)  # 1: what a scene or capture names is not there
                    counts.append(count)
                first, second = counts[1] - counts[0], counts[2] - counts[1]
                self.assertGreater(first, counts[0] / 100, "too few to be counted")
                self.assertLess(second, MOST * first, counts)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--table"]:
        for one, its_n in READERS.items():
            if all(word in one.__name__ for word in sys.argv[2:]):
                found = [steps(one, its_n * times) for times in (1, 2, 4)]
                (a, *_), (b, *_), (c, its_code, its_message) = found
                print(f"{one.__name__:24} {its_n:6} {a / 1e6:9.1f} M {b / 1e6:9.1f} M {c / 1e6:9.1f} M  {(c - b) / max(1, b - a):6.2f}  "
                      f"{its_code} {its_message.strip()[:200] if its_code else ''}", flush=True)
    else:
        support.main()
