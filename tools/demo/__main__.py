# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Shows what Volute does on data that it makes from seeds: one page, which grows while this runs.

    python3 tools/demo                  # compiles what it needs first; ./dev demo does this
    python3 tools/demo --bin FOLDER     # with programs that are there
"""
import argparse
import json
import os
import pathlib
import shutil
import signal
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import effects
import laboratory
import papers
import safety
from compile import Compiler
from plan import Build, Plan, Scale
from progress import Forecast, spoken
from runner import Runner, say
from state import State

# What is built and what is made take on disk.
BUILD_MEGABYTES = 150
DEMO_MEGABYTES = {False: 540, True: 110}


def whole_plan(quick):
    scale = Scale(quick)
    return Plan([effects.chapter(scale), laboratory.chapter(scale), safety.chapter(scale), papers.chapter(scale)], scale.measured())


def announce(runner, out):
    """What will happen, how long it takes here, and what it needs."""
    builds, steps = [], 0.0
    for step in runner.todo():
        if isinstance(step, Build):
            builds.append(runner.forecast.compiling(runner.builds[step.name]))
        else:
            steps += runner.forecast.wall(runner.plan.seconds(step))
    there = len([step for step in runner.plan.steps if not isinstance(step, Build)]) - sum(not isinstance(step, Build) for step in runner.todo())
    compiling = f"compiles Volute ({spoken(sum(builds))} without a compiler cache), then " if sum(builds) > 5 else ""
    say(f"{compiling}makes the pictures, films and plots of four chapters ({spoken(steps)}): effects, laboratory, fire safety, the papers' figures.")
    if there:
        say(f"{there} of its steps are already done and are kept.")
    megabytes = (BUILD_MEGABYTES if sum(builds) > 5 else 0) + DEMO_MEGABYTES[runner.quick]
    free = shutil.disk_usage(out).free / 1e6
    say(f"It needs {megabytes} MB on this disk, which has {free / 1000:.0f} GB left. Ctrl-C stops it, and the next run continues from there.")
    if free < megabytes:
        sys.exit(f"demo: {free:.0f} MB are left on the disk of {out}; expected {megabytes}. Free some space, or choose another folder with --out.")


def keep_times(state, table):
    times = state.seconds()
    missing = [name for name in (step.name for step in state.plan.maker.values()) if name not in times]
    if missing:
        sys.exit(f"demo: {missing[0]} is not made; finish the demo first")
    kept = {step.name: round(times[step.name], 2) for step in state.plan.maker.values()}
    table.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    print(f"{sum(kept.values()):.0f} s of CPU time in {table}")
    return 0


def interrupted(*_):
    raise KeyboardInterrupt


def main():
    parser = argparse.ArgumentParser(prog="demo", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="make every chapter smaller: two minutes once Volute is compiled")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("demo"), help="folder of the page [demo]")
    parser.add_argument("--bin", type=pathlib.Path, help="folder of built programs; nothing is compiled")
    parser.add_argument("--preset", default="release", help="CMake preset to compile [release]")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--measured", action="store_true", help="keep the CPU times of a finished demo for the forecasts of later ones")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, interrupted)
    signal.signal(signal.SIGHUP, interrupted)

    out = options.out.resolve()
    compiler = None if options.bin else Compiler(HERE.parents[1], options.preset, options.jobs)
    plan = whole_plan(options.quick)
    state = State(out, plan, options.bin.resolve() if options.bin else compiler.binaries)
    if not state.lock():
        sys.exit(f"demo: another demo writes into {out}; wait for it, or choose another folder with --out")
    if options.measured:
        return keep_times(state, Scale(options.quick).table())
    runner = Runner(plan, state, compiler, Forecast(), options.quick)
    runner.plan_builds()
    announce(runner, out)
    page = os.path.relpath(out / "index.html")
    print(f"The page is updated while it runs: {page}", flush=True)
    try:
        whole = runner.run()
    except KeyboardInterrupt:
        done = len(plan.maker.keys()) and sum(state.done(step) for step in plan.steps if not isinstance(step, Build))
        total = sum(not isinstance(step, Build) for step in plan.steps)
        print(f"\nStopped; {done} of {total} steps are done. {page} shows them, and the same command continues.", flush=True)
        return 130
    if not whole:
        print(f"Parts could not be made; {page} lists them, and shows the rest.", flush=True)
        return 1
    print(f"Done. Open {page}", flush=True)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except OSError as error:  # a full disk, most likely
        where = f"{error.filename}: " if error.filename else ""
        sys.exit(f"demo: {where}{error.strerror or error}. The same command continues from what is done.")
