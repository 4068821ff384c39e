# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Runs two builds of the command on the same inputs and compares all that they write, byte by byte:

    python3 tools/compare_outputs.py before/bin/volute after/bin/volute [DATA]

Inputs are made up by the first build. DATA is a folder with smoke_hall/, smoke_mall/, volumes/, capture_fire/ and fds/;
what is not there is left out. Of .volute files of the default effort the size is compared, which may grow by --growth
percent; what each build reads from the other's is compared, too. The exit code is 1 when something differs."""
import argparse
import collections
import json
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile

SIGNS = {"signs": [{"name": "far", "position": [20, 6, 2.5], "normal": [-1, 0, 0], "size": [0.6, 0.3], "emitting": True},
                   {"name": "side", "position": [3, 1, 2], "normal": [1, 0, 0], "C": 3.5, "angle_law": "cosine"}]}
SMOKE = "--field soot --quantity soot-density --unit g/m3"

# A line each; .volute files of the default effort are named out_*.volute and compared by size.
INPUTS = f"""
synthesize fire -o fire.npy --size 32 --frames 20
synthesize flame -o flame.npy --size 32 --frames 18 --seed 3
synthesize smoke -o smoke.npy --size 32 --frames 17 --seed 5
synthesize smoke -o cloud.npy --size 32 --frames 5 --seed 6 --scalar
synthesize valley -o valley --size 64 --pixels 160x90
synthesize hall -o hall.pvd --cell 1 --frames 4 --interval 60
compress fire.npy -o fire.volute --rms 3e-3 --fast
compress cloud.npy -o cloud.volute --psnr 50 --fast
"""

TARGETS = ["--rms 1e-2", "--rms 3e-3", "--rms 3e-4", "--psnr 45", "--ratio 80", "--size 20K", "--max-error 0.02"]

MADE = f"""
synthesize fire -o again.npy --size 32 --frames 3 --seed 2
synthesize smoke -o again_%04d.vti --size 16 --frames 2
synthesize hall -o again.pvd --cell 1.5 --frames 2
synthesize ball -o ball.vtu
synthesize valley -o vale --size 64 --pixels 64x36 --geometry
info fire.volute --json --blocks
info hall.pvd --json
info cloud.npy --values --json
extract fire.volute -o whole.npy
extract fire.volute -o coarse.npy --level 1
extract cloud.volute -o cloud_%04d.vti
compress fire.npy -o mode.volute --rms 3e-3 --block-mode shaped:cdf53:2
render fire.volute -o fire.png --size 160x120 --time 0.2
render fire.volute -o fire.exr --size 160x120 --time 0.2 --renderer reference
render fire.volute -o fire_%04d.png --size 79x61 --frames 0:3 --exposure auto
render fire.volute -o fire.mp4 --size 161x91 --frames 0:12
render fire.volute -o fire.webm --size 80x61 --frames 0:4
render cloud.volute -o cloud.png --size 160x120
render cloud.volute -o depth.exr --size 160x120 --aov optical-depth
render cloud.volute -o depth.png --size 160x120 --aov transmittance
render fire.npy -o threads.png --size 160x120 --threads 1
render hall.pvd -o hall_%04d.png --size 160x120 {SMOKE} --exposure 1
render hall.pvd -o hall.exr --size 160x120 {SMOKE} --time 180
render hall.pvd -o hall.mp4 --size 161x90 {SMOKE} --exposure 1
render hall.pvd -o hall_depth.exr --size 160x120 --aov optical-depth {SMOKE} --time 120
render hall.pvd -o hall_reference.exr --size 40x30 --renderer reference {SMOKE} --time 120
render hall.pvd -o slice.png --size 160x120 --slice z=1.8 --legend {SMOKE} --time 180
render hall.pvd -o surface.png --size 160x120 --isosurface 10 --legend {SMOKE} --time 180
visibility hall.pvd --signs signs.json -o visibility --step 1 --maps all {SMOKE}
fog valley/fogmap.png --color valley/color.exr --depth valley/depth.exr --camera valley/camera.json -o foggy.png
fog valley/fogmap.png --color valley/color.exr --depth valley/depth.exr --camera valley/camera.json -o foggy.exr --path polar --profile slab:0,30
""" + "".join(f"compress {name}.npy -o out_{name}_{i}.volute {target}\ncompress {name}.npy -o fast_{name}_{i}.volute {target} --fast\n"
              for name in ("fire", "flame", "smoke", "cloud") for i, target in enumerate(TARGETS)) + """
compress fire.npy -o out_frame.volute --rms 3e-3 --frames 0:1
compress smoke.npy -o out_haar.volute --rms 3e-3 --wavelet haar
compress smoke.npy -o out_threads.volute --rms 3e-3 --threads 1
compress smoke.npy -o out_thread.volute --rms 3e-3
"""

WITH_DATA = {
    "smoke_hall": """
render data/smoke_hall/hall.pvd -o d_hall.png --size 640x360 --exposure 1 {smoke}
render data/smoke_hall/hall.pvd -o d_hall.mp4 --size 640x360 --exposure 1 {smoke}
visibility data/smoke_hall/hall.pvd --signs signs.json -o d_visibility --step 1 {smoke}
""",
    "smoke_mall": """
render data/smoke_mall/mall.pvd -o d_mall.png --size 640x360 --exposure 1 {smoke}
render data/smoke_mall/mall.pvd -o d_mall.exr --size 320x180 --aov optical-depth {smoke}
""",
    "volumes": """
compress fire64.npy -o out_d_fire.volute --rms 3e-3 --frames 0:16
compress fire64.npy -o out_d_fire_fine.volute --rms 3e-4 --frames 16:32
compress smoke64.npy -o out_d_smoke.volute --rms 1e-3 --frames 0:16
compress colour64.npy -o out_d_colour.volute --rms 3e-3 --frames 0:16
compress fire64.npy -o fast_d_fire.volute --rms 3e-3 --frames 0:16 --fast
render data/volumes/fire_flame_vdb -o d_flame.png --size 320x240 --frames 20:21
""",
    "capture_fire": """
reconstruct data/capture_fire/capture.json -o out_d_rebuilt.volute --resolution 32 --frames 37:38
project fire.volute data/capture_fire/capture.json -o d_{{camera}}_%04d.exr --frames 0:1
""",
    "fds": """
render data/fds/smoke_sensor/smoke_sensor.smv -o d_fds.png --size 320x240 --exposure 1
extract data/fds/smoke_sensor/smoke_sensor.smv -o d_fds.npy
""",
}
PACKED = {"fire64": "fire64_flame_f16", "smoke64": "smoke64_density_f16", "colour64": "smoke64_rgb_first32_f16"}
TIMES = re.compile(rb'"[a-z_ ]*(seconds|milliseconds|cpu|time_ms)": [0-9.e+-]+')


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


class Build:
    """One of the two, with a folder that it works in."""

    def __init__(self, program, folder):
        self.program, self.folder = program.resolve(), folder
        folder.mkdir()

    def run(self, words):
        """Exit code, what it said, and the CPU seconds that it took."""
        before = cpu_seconds()
        done = subprocess.run([self.program, *words], cwd=self.folder, capture_output=True)
        return done.returncode, done.stdout, done.stderr, cpu_seconds() - before

    def files(self):
        return {path.relative_to(self.folder): path for path in self.folder.rglob("*")
                if path.is_file() and "data" not in path.relative_to(self.folder).parts[:1]}


def is_default_effort(path):
    return path.suffix == ".volute" and path.name.startswith("out_")


class Comparison:
    def __init__(self, builds, growth):
        self.builds, self.growth = builds, growth
        self.compared, self.sizes, self.faults = 0, [], []
        self.seconds = collections.defaultdict(lambda: [0.0, 0.0])

    def run(self, line):
        words = line.split()
        known = set(self.builds[0].files())
        results = [build.run(words) for build in self.builds]
        for i in range(2):
            self.seconds[words[0]][i] += results[i][3]
        (code, out, error, _), (code2, out2, _, _) = results
        if code != code2:
            self.faults.append(f"{line}: exit code {code}, then {code2}")
        elif code != 0:
            self.faults.append(f"{line}: failed with both: {error.decode(errors='replace').strip().splitlines()[-1:]}")
        if words[0] == "info" and out != out2:
            self.faults.append(f"{line}: says something else")
        new = set(self.builds[0].files()) - known
        if code == code2 == 0 and words[0] != "info" and not new:
            self.faults.append(f"{line}: wrote nothing")

    def compare_files(self):
        before, after = (build.files() for build in self.builds)
        for path in sorted(before.keys() | after.keys()):
            if path not in before or path not in after:
                self.faults.append(f"{path}: only one build wrote it")
                continue
            if is_default_effort(path):
                sizes = before[path].stat().st_size, after[path].stat().st_size
                self.sizes.append((path, *sizes))
                if sizes[1] > sizes[0] * (1 + self.growth / 100):
                    self.faults.append(f"{path}: {sizes[0]} bytes, then {sizes[1]}: {growth_of(*sizes):+.2f} %")
                continue
            self.compared += 1
            data = [TIMES.sub(b"", files[path].read_bytes()) if path.suffix in (".json", ".html") else files[path].read_bytes()
                    for files in (before, after)]
            if data[0] != data[1]:
                at = next((i for i, (a, b) in enumerate(zip(*data)) if a != b), min(map(len, data)))
                self.faults.append(f"{path}: differs from byte {at} on; {len(data[0])} bytes, then {len(data[1])}")

    def read_each_others(self):
        """Both builds read what either wrote."""
        for path, before, after in list(self.sizes):
            for writer in self.builds:
                values = []
                for reader in self.builds:
                    source = writer.folder / path
                    done = subprocess.run([reader.program, "extract", source, "-o", "-", "-q"], capture_output=True)
                    values.append(done.stdout if done.returncode == 0 else None)
                self.compared += 1
                if values[0] is None or values[0] != values[1]:
                    self.faults.append(f"{path} of {writer.program}: read as something else, or not at all")


def growth_of(before, after):
    return 100 * (after / before - 1)


def same_threads(build):
    """Whether one thread and all wrote the same, but for the command that is kept in the file."""
    values = [json.loads(subprocess.run([build.program, "info", build.folder / f"out_{name}.volute", "--json", "--blocks"],
                                        capture_output=True).stdout) for name in ("threads", "thread")]
    return [{key: value for key, value in of.items() if key not in ("file", "path", "provenance")} for of in values]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("before", type=pathlib.Path, help="a volute program")
    parser.add_argument("after", type=pathlib.Path, help="another")
    parser.add_argument("data", type=pathlib.Path, nargs="?", help="folder with shared data")
    parser.add_argument("--growth", type=float, default=1, metavar="PERCENT", help="that a .volute may grow by [default 1]")
    parser.add_argument("--only", default="", metavar="REGEX", help="commands that match")
    parser.add_argument("--keep", type=pathlib.Path, metavar="FOLDER", help="a new folder for what was written")
    arguments = parser.parse_args()
    scratch = arguments.keep or pathlib.Path(tempfile.mkdtemp(prefix="compare_outputs"))
    scratch.mkdir(parents=True, exist_ok=True)
    first = Build(arguments.before, scratch / "before")
    lines = [line for line in MADE.splitlines() if line]
    for line in filter(None, INPUTS.splitlines()):
        code, _, error, _ = first.run(line.split())
        if code != 0:
            sys.exit(f"{line}: {error.decode(errors='replace')}")
    (first.folder / "signs.json").write_text(json.dumps(SIGNS))
    if arguments.data:
        (first.folder / "data").symlink_to(arguments.data.resolve())
        for name, text in WITH_DATA.items():
            if (arguments.data / name).is_dir():
                lines += [line for line in text.format(smoke=SMOKE.replace("soot ", "smoke ", 1)).splitlines() if line]
        for name, packed in PACKED.items():
            source = arguments.data / "volumes" / f"{packed}.npy.zst"
            if source.is_file() and re.search(arguments.only, "compress"):
                subprocess.run(["zstd", "-dqf", source, "-o", first.folder / f"{name}.npy"], check=True)
    second = Build(arguments.after, scratch / "after")
    shutil.copytree(first.folder, second.folder, symlinks=True, dirs_exist_ok=True)
    comparison = Comparison([first, second], arguments.growth)
    lines = [line for line in lines if re.search(arguments.only, line)]
    for number, line in enumerate(lines):
        if sys.stderr.isatty():
            print(f"\r{number + 1} of {len(lines)}: {line[:90]:<90}", end="", file=sys.stderr, flush=True)
        comparison.run(line)
    if sys.stderr.isatty():
        print("\r" + " " * 110 + "\r", end="", file=sys.stderr)
    comparison.compare_files()
    comparison.read_each_others()
    if (second.folder / "out_threads.volute").exists() and (second.folder / "out_thread.volute").exists():
        one, all_of_them = same_threads(second)
        if one != all_of_them:
            comparison.faults.append("out_threads.volute: one thread writes something else than all")
    for path, before, after in comparison.sizes:
        print(f"{str(path):<28} {before:>9} {after:>9} bytes {growth_of(before, after):+6.2f} %")
    if comparison.sizes:
        totals = [sum(sizes[i] for sizes in comparison.sizes) for i in (1, 2)]
        print(f"{'all of them':<28} {totals[0]:>9} {totals[1]:>9} bytes {growth_of(*totals):+6.2f} %")
    for verb, (before, after) in comparison.seconds.items():
        print(f"{verb:<28} {before:9.2f} {after:9.2f} s of CPU")
    for fault in comparison.faults:
        print(f"DIFFERS  {fault}")
    print(f"{len(lines)} commands, {comparison.compared} files the same but for {len(comparison.faults)} differences")
    if not arguments.keep:
        shutil.rmtree(scratch)
    sys.exit(1 if comparison.faults else 0)


if __name__ == "__main__":
    main()
